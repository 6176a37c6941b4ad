//! What an `expect` is about: a port, an activity or a component, as its other keys say.

use std::collections::BTreeSet;

use serde_json::Value;

use super::fields::Fields;
use crate::model::{Codels, Expected};

const PORT: [&str; 3] = ["value", "absent", "samples"];
const ACTIVITY: [&str; 2] = ["states", "running"];
const COMPONENT: [&str; 3] = ["codels", "missed", "state"];

pub(super) fn read(fields: &Fields<'_, '_, '_>, labels: &BTreeSet<String>) -> Option<Expected> {
    let of = fields.text("expect")?;
    let kinds = [&PORT[..], &ACTIVITY, &COMPONENT];
    let given = kinds.map(|keys| keys.iter().find(|key| fields.has(key)));
    let mistake = |message: String, help: &str| {
        fields.found.add(fields.span.clone(), message, Some(help.to_owned()));
        None
    };
    let slash = of.contains('/');
    match given {
        [Some(_), None, None] => {
            let port = fields.address("expect");
            let value = fields.value("value");
            let tolerance = fields.tolerance();
            let absent = fields.boolean("absent").unwrap_or(false);
            let samples = fields.count("samples", 0);
            if absent && value.is_some() {
                return mistake(
                    "a port that is `absent` has no `value`".to_owned(),
                    "leave one out",
                );
            }
            Some(Expected::Port { port: port?, value, tolerance, absent, samples })
        }
        [None, Some(key), None] => {
            if !slash && !labels.contains(of) {
                fields.offer(&ACTIVITY);
                let message = format!("`{key}` is of an activity, which `{of}` is not");
                return mistake(
                    message,
                    "write COMPONENT/SERVICE, or the name that `as` gave to it",
                );
            }
            let states = fields.has("states").then(|| fields.texts("states"));
            let states = states.map(|names| names.into_iter().map(str::to_owned).collect());
            let running = fields.boolean("running");
            Some(Expected::Activity { of: of.to_owned(), states, running })
        }
        [None, None, Some(key)] => {
            if slash {
                fields.offer(&COMPONENT);
                return mistake(
                    format!("`{key}` is of a component, which `{of}` is not"),
                    "write COMPONENT",
                );
            }
            let codels = codels(fields);
            let missed = fields.count("missed", 0);
            let state = fields.text("state").map(str::to_owned);
            Some(Expected::Component { name: of.to_owned(), codels, missed, state })
        }
        [None, None, None] => {
            // A misspelt key is told besides.
            fields.offer(kinds.into_iter().flatten());
            mistake(
                format!("it is not said what `{of}` has to be"),
                "value, absent or samples of a port; states or running of an activity; codels, \
                 missed or state of a component",
            )
        }
        [a, b, c] => {
            let keys: Vec<_> =
                [a, b, c].into_iter().flatten().map(|key| format!("`{key}`")).collect();
            let message = format!("{} are of different things", keys.join(" and "));
            fields.offer(kinds.into_iter().flatten());
            mistake(message, "make two steps of it")
        }
    }
}

/// Names of codels that ran, or how often each did.
fn codels(fields: &Fields<'_, '_, '_>) -> Option<Codels> {
    let value = fields.get("codels")?;
    if value.get_ref().is_array() {
        let names = fields.texts("codels");
        return Some(Codels::Ran(names.into_iter().map(str::to_owned).collect()));
    }
    let Value::Object(counts) = fields.members("codels")? else { return None };
    let count = |(name, count): (String, Value)| match count.as_u64() {
        Some(count) => Some((name, count)),
        None => {
            let message = format!("`{name}` ran a whole number of times, not {count}");
            fields.found.add(value.span(), message, None);
            None
        }
    };
    Some(Codels::Counts(counts.into_iter().filter_map(count).collect()))
}
