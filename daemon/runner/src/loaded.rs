//! What the interpreter says of a script that it was to load.

use std::collections::HashMap;
use std::ops::Range;

use serde::Deserialize;
use serde_json::Value;

/// A script that is loaded.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Loaded {
    /// Address of the C function of each codel.
    pub(crate) functions: HashMap<String, usize>,
    /// Memory of the events that they return.
    pub(crate) events: Range<usize>,
    /// What the interpreter calls it.
    pub(crate) number: u64,
}

/// Why it is not.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Refused {
    errors: Vec<String>,
}

/// Most bytes of an answer: of one that is longer, no more than shows that is kept.
pub(crate) const LARGEST: usize = 4 << 20;

/// Reads an answer.
///
/// # Errors
/// The script was refused, with the reasons; or the answer is none.
pub(crate) fn understand(answer: &[u8]) -> Result<Loaded, Vec<String>> {
    if answer.is_empty() {
        let text = "the runner gave no answer; its standard error says why";
        return Err(vec![text.to_owned()]);
    }
    if answer.len() > LARGEST {
        let most = LARGEST >> 20;
        return Err(vec![format!("the answer of the runner has more than {most} MiB")]);
    }
    let misread =
        |why| vec![format!("the answer of the runner is not as docs/runners.md says: {why}")];
    let said: Value = serde_json::from_slice(answer).map_err(|why| misread(why.to_string()))?;
    if said.get("errors").is_some() {
        let Refused { errors } =
            Refused::deserialize(said).map_err(|why| misread(why.to_string()))?;
        return Err(if errors.is_empty() {
            misread("`errors` is empty".to_owned())
        } else {
            errors
        });
    }
    let loaded = Loaded::deserialize(said).map_err(|why| misread(why.to_string()))?;
    if let Some((name, _)) = loaded.functions.iter().find(|(_, address)| **address == 0) {
        return Err(misread(format!("the address of `{name}` is 0")));
    }
    if loaded.events.is_empty() || loaded.events.start == 0 {
        return Err(misread("no memory lies from `start` to `end` of `events`".to_owned()));
    }
    Ok(loaded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_what_was_loaded_or_why_not() {
        let text = br#"{"functions": {"f": 16}, "events": {"start": 32, "end": 64}, "number": 3}"#;
        let loaded = understand(text).unwrap();
        assert_eq!((loaded.functions["f"], loaded.events, loaded.number), (16, 32..64, 3));
        assert_eq!(understand(br#"{"errors": ["no"]}"#).unwrap_err(), ["no"]);
        assert!(understand(b"").unwrap_err()[0].contains("standard error"));
    }

    #[test]
    fn an_answer_that_is_none_is_told_with_what_is_wrong() {
        for (text, told) in [
            (r#"{"functions": {"f": 16}"#, "EOF while parsing"),
            (r#"{"errors": []}"#, "`errors` is empty"),
            (r#"{"errors": "no"}"#, "expected a sequence"),
            (r#"{"errors": ["no"], "number": 1}"#, "unknown field `number`"),
            (r#"{"functions": {"f": 16}, "number": 3}"#, "missing field `events`"),
            (
                r#"{"functions": {"f": 0}, "events": {"start": 32, "end": 64}, "number": 3}"#,
                "the address of `f` is 0",
            ),
            (
                r#"{"functions": {"f": -1}, "events": {"start": 32, "end": 64}, "number": 3}"#,
                "integer `-1`",
            ),
            (
                r#"{"functions": {"f": 16}, "events": {"start": 64, "end": 32}, "number": 3}"#,
                "from `start` to `end`",
            ),
        ] {
            let errors = understand(text.as_bytes()).unwrap_err();
            assert!(errors.len() == 1 && errors[0].contains(told), "{text}: {errors:?}");
        }
        let errors = understand(&[b' '; LARGEST + 1]).unwrap_err();
        assert_eq!(errors, ["the answer of the runner has more than 4 MiB"]);
    }
}
