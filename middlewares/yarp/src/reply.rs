//! What a server of YARP that is no genomd means by its answer (`docs/yarp.md`, "Servers of YARP").

use genom_types::{DataType, Kind, Record};
use serde_json::Value as Json;

use crate::bottle::decode::{self, Misfit};
use crate::bottle::reader::{Item, List, Reader};
use crate::bottle::{NoBottle, Value};
use crate::words;

/// Words that come before the outputs, and instead of them.
const DONE: [&str; 3] = ["ok", "ack", "done"];
const FAILED: [&str; 4] = ["fail", "nack", "err", "error"];

/// Most values and characters of an answer that an error repeats.
const MOST_VALUES: usize = 8;
const MOST_CHARACTERS: usize = 160;

/// What was answered.
#[derive(Debug)]
pub(crate) enum Said {
    /// Success.
    Outputs(Record),
    /// An exception of the service.
    Exception { name: String, detail: Json },
    /// The server could not do it; the answer as it was.
    Failed(String),
}

/// An answer that means nothing for this service.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Odd {
    #[error("that is no bottle: {0}")]
    NoBottle(#[from] NoBottle),
    #[error("{0}")]
    Outputs(#[from] Misfit),
    #[error("that cannot be a value of {ty}: {why}")]
    Record { ty: String, why: String },
    #[error("the name of an exception is ::NAME::NAME, not {0}")]
    Name(String),
    #[error("the members of exception {name} are to be a text in JSON: {why}")]
    Members { name: String, why: String },
}

/// A bottle, and what is left of it.
#[derive(Clone)]
struct Rest<'a> {
    reader: Reader<'a>,
    list: List,
}

impl<'a> Rest<'a> {
    fn next(&mut self) -> Result<Option<Item<'a>>, NoBottle> {
        self.reader.next(&mut self.list)
    }

    /// The outputs, if all that is left are these.
    fn outputs(mut self, output: &DataType) -> Result<Said, Odd> {
        let (mut message, mut record) = (Vec::new(), Record::new(output));
        decode::values(output, &mut self.reader, &mut self.list, &mut message)?;
        self.reader.end()?;
        record.decode_message(&message).map_err(|error| Odd::Record {
            ty: output.name().to_owned(),
            why: error.to_string(),
        })?;
        Ok(Said::Outputs(record))
    }

    /// What is left, for an error.
    fn shown(&mut self) -> String {
        let mut shown = Vec::new();
        while let Ok(Some(item)) = self.next() {
            if shown.len() == MOST_VALUES {
                shown.push("...".to_owned());
                break;
            }
            shown.push(match item {
                Item::Text(text) => {
                    let text =
                        String::from_utf8_lossy(text).chars().take(MOST_CHARACTERS).collect();
                    Value::line(&[Value::Text(text)])
                }
                Item::Vocab(word) => Value::line(&[Value::Vocab(word)]),
                Item::Int(value) => value.to_string(),
                Item::Float(value) => format!("{value:?}"),
                Item::Blob(_) => item.described(),
                Item::List(_) => {
                    shown.push(item.described());
                    break;
                }
            });
        }
        shown.join(" ")
    }

    fn exception(mut self) -> Result<Said, Odd> {
        let name = match self.next()? {
            Some(Item::Text(name)) => String::from_utf8_lossy(name).into_owned(),
            Some(other) => return Err(Odd::Name(other.described())),
            None => return Err(Odd::Name("nothing".to_owned())),
        };
        let parts: Option<Vec<&str>> =
            name.strip_prefix("::").map(|rest| rest.split("::").collect());
        if parts.is_none_or(|parts| parts.len() < 2 || parts.iter().any(|part| !is_word(part))) {
            let shown: String = name.chars().take(MOST_CHARACTERS).collect();
            return Err(Odd::Name(format!("{shown:?}")));
        }
        let detail = match self.next()? {
            None => Json::Null,
            Some(Item::Text(json)) => match serde_json::from_slice(json) {
                Ok(detail) => detail,
                Err(error) => return Err(Odd::Members { name, why: error.to_string() }),
            },
            Some(other) => return Err(Odd::Members { name, why: other.described() }),
        };
        match self.next()? {
            None => Ok(Said::Exception { name, detail }),
            Some(other) => {
                let why = format!("{} follows it", other.described());
                Err(Odd::Members { name, why })
            }
        }
    }
}

fn is_word(text: &str) -> bool {
    let mut letters = text.chars();
    letters.next().is_some_and(|first| first.is_ascii_alphabetic() || first == '_')
        && letters.all(|one| one.is_ascii_alphanumeric() || one == '_')
}

/// Whether the outputs are one boolean.
fn is_truth(output: &DataType) -> bool {
    let only = output.member(0).filter(|_| output.member_count() == 1);
    only.is_some_and(|only| matches!(only.kind(), Kind::Boolean))
}

/// What an answer means for a service with these outputs.
pub(crate) fn read(output: &DataType, bottle: &[u8]) -> Result<Said, Odd> {
    let (reader, list) = Reader::open(bottle)?;
    let all = Rest { reader, list };
    let mut rest = all.clone();
    let first = rest.next()?;
    if let Some(Item::Vocab(word)) = first {
        let word = Value::Vocab(word).as_word().unwrap_or_default();
        let (done, failed) = (DONE.contains(&word.as_str()), FAILED.contains(&word.as_str()));
        if (done || failed) && rest.list.left == 0 && is_truth(output) {
            let mut record = Record::new(output);
            let truth = record.merge_json(
                &serde_json::json!({ output.member_name(0).unwrap_or_default(): done }),
            );
            let ty = || output.name().to_owned();
            truth.map_err(|error| Odd::Record { ty: ty(), why: error.to_string() })?;
            return Ok(Said::Outputs(record));
        }
        return match (done, failed) {
            (true, _) => rest.outputs(output),
            (_, true) => Ok(Said::Failed(all.clone().shown())),
            _ => all.outputs(output),
        };
    }
    let Some(Item::Text(word)) = first else { return all.outputs(output) };
    // A text may be the first output, too: that it is one, and all is there, comes first.
    let plain = match all.clone().outputs(output) {
        Ok(outputs) => return Ok(outputs),
        Err(odd) => odd,
    };
    match std::str::from_utf8(word).unwrap_or_default() {
        word if DONE.contains(&word) => rest.outputs(output),
        word if FAILED.contains(&word) => Ok(Said::Failed(all.clone().shown())),
        words::EXCEPTION => rest.exception(),
        _ => Err(plain),
    }
}
