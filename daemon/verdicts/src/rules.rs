//! Rules of supervision in a configuration or deployment file: whether they can be broken.

use std::io;
use std::path::{Path, PathBuf};

use genom_description::model::Span;
use genom_formal::{Bounds, Fires, Limits, Line, System, Times, Trace};
use genom_protocol::Deployment;
use genom_runtime::Supervised;
use serde_json::{Value, json};
use toml::de::{DeTable, DeValue};

use crate::columns;
use crate::data::line;
use crate::subject::Subject;
use crate::told::Told;

/// Limit on the file, in bytes.
const LARGEST: u64 = 16 << 20;

/// Why rules cannot be read from a file.
#[derive(Debug, thiserror::Error)]
pub enum Unruled {
    /// It cannot be read.
    #[error("{}: {error}", .file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The reason.
        error: io::Error,
    },
    /// It is too large.
    #[error("{}: {size} bytes, and {LARGEST} are the most", .file.display())]
    Large {
        /// The file.
        file: PathBuf,
        /// Its size in bytes.
        size: u64,
    },
    /// A mistake on a line.
    #[error("{}:{line}: {why}", .file.display())]
    Mistake {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong.
        why: String,
    },
    /// It loads none of the components that are asked about.
    #[error("{}: it loads none of: {names}", .file.display())]
    Others {
        /// The file.
        file: PathBuf,
        /// Their names.
        names: String,
    },
}

impl Unruled {
    /// What to do about it.
    #[must_use]
    pub fn help(&self) -> &'static str {
        match self {
            Self::Others { .. } => {
                "a component is recognised by the name of its library, as `library = \"demo\"`"
            }
            _ => "docs/supervision.md says how rules are written",
        }
    }
}

/// Rules of components that were described.
#[derive(Debug)]
pub struct Ruled {
    components: Vec<Component>,
}

#[derive(Debug)]
struct Component {
    /// Its instance name.
    instance: String,
    /// Which of the components that are asked about, by index.
    subject: usize,
    /// In words.
    texts: Vec<String>,
    rules: Vec<Supervised>,
}

/// A rule, and whether it can be broken.
#[derive(Debug)]
pub struct Judged {
    component: String,
    instance: String,
    number: usize,
    text: String,
    fires: Fires,
}

impl Ruled {
    /// Reads the rules of these components.
    ///
    /// # Errors
    /// The file cannot be read, has mistakes, or has none of them.
    pub fn read(file: &Path, subjects: &[Subject]) -> Result<Self, Unruled> {
        let path = || file.to_owned();
        let unread = |error| Unruled::File { file: path(), error };
        let size = std::fs::metadata(file).map_err(unread)?.len();
        if size > LARGEST {
            return Err(Unruled::Large { file: path(), size });
        }
        let text = std::fs::read_to_string(file).map_err(unread)?;
        let mistake = |line, why| Unruled::Mistake { file: path(), line, why };
        let read: Deployment = toml::from_str(&text).map_err(|error| {
            let line = error.span().map_or(1, |span| line_of(&text, span.start));
            mistake(line, error.message().to_owned())
        })?;
        let mut components = Vec::new();
        for (place, request) in read.component.iter().enumerate() {
            let library = request.library.file_stem().unwrap_or_default().to_string_lossy();
            let named = |one: &Subject| one.plan.component().name == library;
            let Some(subject) = subjects.iter().position(named) else { continue };
            let model = subjects[subject].plan.component();
            let rules = genom_rules::rules(request, model).map_err(|why| {
                let line = line_of_rule(&text, place, why.at()).unwrap_or(1);
                mistake(line, why.to_string())
            })?;
            let texts = request.supervision.iter().filter_map(|rule| rule.condition().ok());
            let texts = texts.map(|condition| condition.to_string()).collect();
            components.push(Component { instance: request.instance(), subject, texts, rules });
        }
        if components.is_empty() {
            let names: Vec<&str> =
                subjects.iter().map(|one| one.plan.component().name.as_str()).collect();
            return Err(Unruled::Others { file: path(), names: names.join(", ") });
        }
        Ok(Self { components })
    }

    /// Whether each can be broken, within these bounds and with these times of codels.
    pub fn judge(
        &self,
        told: &[Told],
        bounds: impl Fn(&Subject) -> Bounds,
        times: impl Fn(&Subject) -> Result<Times, String>,
        limits: &Limits,
    ) -> Vec<Judged> {
        let mut judged = Vec::new();
        for one in &self.components {
            let subject = &told[one.subject].subject;
            let system = System::new(&subject.plan, bounds(subject));
            let times = times(subject);
            let times = times.as_ref().map_err(String::as_str);
            for ((number, rule), text) in (1..).zip(&one.rules).zip(&one.texts) {
                judged.push(Judged {
                    component: subject.plan.component().name.clone(),
                    instance: one.instance.clone(),
                    number,
                    text: text.clone(),
                    fires: system.fires(&rule.rule, times, limits),
                });
            }
        }
        judged
    }
}

/// The number of the line of a byte.
fn line_of(text: &str, at: usize) -> usize {
    text.as_bytes().iter().take(at).filter(|byte| **byte == b'\n').count() + 1
}

/// The line of a rule of a component, both by place.
fn line_of_rule(text: &str, component: usize, rule: usize) -> Option<usize> {
    let parsed = DeTable::parse(text).ok()?;
    let DeValue::Array(components) = parsed.get_ref().get("component")?.get_ref() else {
        return None;
    };
    let entry = components.get(component)?;
    let at = match entry.get_ref() {
        DeValue::Table(members) => match members.get("supervision")?.get_ref() {
            DeValue::Array(rules) => rules.get(rule)?.span().start,
            _ => entry.span().start,
        },
        _ => entry.span().start,
    };
    Some(line_of(text, at))
}

fn verdict(fires: &Fires) -> (&'static str, Option<&str>, Option<&Trace>) {
    match fires {
        Fires::Never => ("cannot fire", None, None),
        Fires::Can { what, run } => ("can fire", Some(what), Some(run)),
        Fires::Always { what, run } => ("always fires", Some(what), Some(run)),
        Fires::Undecided(why) => ("not decided", Some(why), None),
    }
}

/// The rules of a component.
fn of<'a>(judged: &'a [Judged], subject: &Subject) -> impl Iterator<Item = &'a Judged> {
    let name = subject.plan.component().name.clone();
    judged.iter().filter(move |one| one.component == name)
}

/// The rules of a component, for people.
#[must_use]
pub fn text(judged: &[Judged], subject: &Subject) -> String {
    let mut text = String::new();
    for one in of(judged, subject) {
        let (verdict, what, run) = verdict(&one.fires);
        let what = what.map_or_else(String::new, |what| format!(": {what}"));
        let (instance, number, rule) = (&one.instance, one.number, &one.text);
        text.push_str(&format!("rule     {instance} {number} ({rule}) {verdict}{what}\n"));
        let place = |span: Option<Span>| {
            span.map_or_else(String::new, |span| {
                let location = subject.texts.location(span);
                format!(" ({}:{})", location.path.display(), location.line)
            })
        };
        match run {
            None => {}
            Some(Trace::Steps(lines)) => {
                for Line { who, what, span } in lines {
                    text.push_str(&format!("    {who}: {what}{}\n", place(*span)));
                }
            }
            Some(Trace::Dated(lines)) => text.push_str(&columns::run(lines, place)),
        }
    }
    text
}

/// The same, as JSON.
#[must_use]
pub fn data(judged: &[Judged], subject: &Subject) -> Value {
    let all: Vec<Value> = of(judged, subject)
        .map(|one| {
            let (verdict, what, run) = verdict(&one.fires);
            let lines = run.into_iter().flat_map(Trace::lines);
            let run: Vec<Value> = lines
                .map(|(date, one)| {
                    let mut value = line(one, &subject.texts);
                    if let Some(date) = date {
                        value["date_ns"] = json!(date);
                    }
                    value
                })
                .collect();
            json!({
                "instance": one.instance, "rule": one.text, "number": one.number,
                "verdict": verdict.replace(' ', "_"), "what": what, "run": run,
            })
        })
        .collect();
    json!(all)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::rc::Rc;
    use std::sync::Arc;

    use genom_description::{Options, read_text};
    use genom_formal::Dated;
    use genom_runtime::Plan;

    use super::*;

    #[test]
    fn a_run_with_dates_has_a_column_for_them_and_they_are_numbers_in_json() {
        let text = "component one { task t { period 5 ms; }; };";
        let analysis = read_text("one.gen", text, &Options::default());
        let plan = Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap());
        let subject = Subject {
            plan,
            texts: Rc::new(analysis.sources),
            files: Vec::new(),
            include: Vec::new(),
            defines: Vec::new(),
            running: None,
            measured: None,
        };
        let line = |who: &str, what: &str| Line { who: who.into(), what: what.into(), span: None };
        let dated = |date, who, what| Dated { date, line: line(who, what) };
        let judged = |run| Judged {
            component: "one".into(),
            instance: "one".into(),
            number: 1,
            text: "slow".into(),
            fires: Fires::Can { what: "it is".into(), run },
        };
        let run = vec![dated(5_000_000, "t", "tick"), dated(7_000_001, "rule", "is broken")];
        let all =
            [judged(Trace::Dated(run)), judged(Trace::Steps(vec![line("client", "requests x")]))];
        assert_eq!(
            super::text(&all, &subject),
            "rule     one 1 (slow) can fire: it is\n                t       rule\n      5.000 ms  tick\n      \
             7.000 ms          is broken\nrule     one 1 (slow) can fire: it is\n    client: requests x\n"
        );
        let told = data(&all, &subject);
        assert_eq!(told[0]["run"][1]["date_ns"], 7_000_001);
        assert_eq!(told[1]["run"][0].get("date_ns"), None);
    }
}
