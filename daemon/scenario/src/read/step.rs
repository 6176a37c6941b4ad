//! The steps of a scenario: what each does is the key that names it.

use std::collections::BTreeSet;
use std::path::Path;

use genom_nearest::nearest;
use genom_protocol::{ConnectionRequest, StepRequest};
use serde_json::{Map, Value};

use super::expected;
use super::fields::{Fields, Spot};
use super::found::Found;
use super::setup;
use crate::model::{Action, Ended, Fault, Harm, Step, Takes};
use crate::source::Place;

/// Keys that say what a step does.
const VERBS: [&str; 15] = [
    "load",
    "unload",
    "connect",
    "disconnect",
    "step",
    "publish",
    "call",
    "start",
    "abort",
    "wait",
    "fire",
    "expect",
    "fault",
    "repair",
    "kill",
];

/// Time on the clock that a service may take, if nothing else is said: 60 s.
const WITHIN: u64 = 60_000_000_000;

/// Reads the steps of one scenario, in their order.
pub(super) struct Steps<'a> {
    text: &'a str,
    directory: &'a Path,
    found: &'a Found,
    /// Names that `as` gave to activities so far.
    labels: BTreeSet<String>,
}

impl<'a> Steps<'a> {
    pub(super) fn new(text: &'a str, directory: &'a Path, found: &'a Found) -> Self {
        Self { text, directory, found, labels: BTreeSet::new() }
    }

    pub(super) fn read(&mut self, value: Spot<'_, '_>) -> Option<Step> {
        let fields = Fields::of(value, "a step", self.found)?;
        let place = Place::of(self.text, value.span().start);
        let verb = verb(&fields)?;
        let action = self.action(verb, &fields);
        fields.finish(&format!("`{verb}`"));
        Some(Step { place, action: action? })
    }

    fn action(&mut self, verb: &str, fields: &Fields<'_, '_, '_>) -> Option<Action> {
        Some(match verb {
            "load" => {
                let value = fields.get("load")?;
                let request = setup::component(value, "`load`", self.directory, self.found)?;
                Action::Load(Box::new(request))
            }
            "unload" => Action::Unload(fields.text("unload")?.to_owned()),
            "connect" => {
                let (from, to) = (fields.address("connect"), fields.text("to"));
                if !fields.has("to") {
                    fields
                        .missing("to", "name the out port or the service: to = \"demo/position\"");
                }
                let policy = fields.text("policy").map(str::to_owned);
                let (over, backend) = (fields.text("over"), fields.text("backend"));
                let over = over.or(backend).map(str::to_owned);
                let (inport, outport) = (from?.to_string(), to?.to_owned());
                Action::Connect(ConnectionRequest { inport, outport, policy, over, wait: false })
            }
            "disconnect" => Action::Disconnect(fields.address("disconnect")?),
            "step" => Action::Advance(self.span(fields)?),
            "publish" => {
                let (port, value) = (fields.address("publish"), fields.value("value"));
                if !fields.has("value") {
                    fields.missing("value", "say what is published: value = 0.5");
                }
                Action::Publish { port: port?, value: value? }
            }
            "call" => {
                let (service, inputs) = (fields.address("call"), inputs(fields));
                Action::Call { service: service?, inputs, ended: ended(fields) }
            }
            "start" => {
                let (service, inputs) = (fields.address("start"), inputs(fields));
                let label = fields.text("as").map(str::to_owned);
                self.labels.extend(label.clone());
                let service = service?;
                let label = label.unwrap_or_else(|| service.to_string());
                Action::Start { service, inputs, label }
            }
            "abort" => Action::Abort(self.activity(fields, "abort")?),
            "wait" => Action::Wait { of: self.activity(fields, "wait")?, ended: ended(fields) },
            "fire" => {
                let event = fields.address("fire")?;
                Action::Fire { component: event.component.clone(), event: event.name() }
            }
            "expect" => Action::Expect(expected::read(fields, &self.labels)?),
            "fault" => Action::Fault(fault(fields)?),
            "repair" => Action::Repair(fields.address("repair")?),
            _ => Action::Kill(fields.text("kill")?.to_owned()),
        })
    }

    fn span(&self, fields: &Fields<'_, '_, '_>) -> Option<u64> {
        let span = fields.time("step")?;
        if span > StepRequest::LONGEST {
            let message =
                format!("a step of one hour is the longest, not {}", span / 1_000_000_000);
            self.found.add(fields.get("step")?.span(), format!("{message} s"), None);
        }
        Some(span)
    }

    /// An activity: a name that `as` gave, or its service.
    fn activity(&self, fields: &Fields<'_, '_, '_>, key: &'static str) -> Option<String> {
        let text = fields.text(key)?;
        if !self.labels.contains(text) && !text.contains('/') {
            let message = format!("no step before this one started `{text}`");
            let help = nearest(text, self.labels.iter().map(String::as_str)).map_or_else(
                || "write COMPONENT/SERVICE, or the name that `as` gave to it".to_owned(),
                |near| format!("did you mean `{near}`?"),
            );
            self.found.add(fields.get(key)?.span(), message, Some(help));
        }
        Some(text.to_owned())
    }
}

/// What a step does.
fn verb(fields: &Fields<'_, '_, '_>) -> Option<&'static str> {
    let verbs: Vec<_> = VERBS.into_iter().filter(|verb| fields.has(verb)).collect();
    let help = match verbs.as_slice() {
        [verb] => return Some(verb),
        [] => {
            let near = fields.keys().find_map(|(key, _)| nearest(key, VERBS));
            near.map(|near| format!("did you mean `{near}`?"))
        }
        [one, other, ..] => {
            let message = format!("a step does one thing: `{one}` and `{other}` are two");
            fields.found.add(fields.span.clone(), message, Some("make two steps of it".to_owned()));
            return None;
        }
    };
    let help = help.unwrap_or_else(|| format!("one of {}", VERBS.join(", ")));
    fields.found.add(fields.span.clone(), "a step says what it does by a key", Some(help));
    None
}

fn inputs(fields: &Fields<'_, '_, '_>) -> Value {
    fields.members("inputs").unwrap_or_else(|| Value::Object(Map::new()))
}

fn ended(fields: &Fields<'_, '_, '_>) -> Ended {
    let ended = Ended {
        within: fields.time("within").unwrap_or(WITHIN),
        result: fields.members("result"),
        throws: fields.text("throws").map(str::to_owned),
        detail: fields.value("detail"),
        tolerance: fields.tolerance(),
        takes: takes(fields),
    };
    let told = |message: &str| fields.found.add(fields.span.clone(), message, None);
    if ended.throws.is_some() && ended.result.is_some() {
        told("what ends with an exception (`throws`) has no `result`");
    }
    if ended.detail.is_some() && !fields.has("throws") {
        told("`detail` is of an exception: say which with `throws`");
    }
    ended
}

/// A time, or the least and the most that it may be.
fn takes(fields: &Fields<'_, '_, '_>) -> Option<Takes> {
    let value = fields.get("takes")?;
    if value.get_ref().is_str() {
        let exact = fields.time("takes")?;
        return Some(Takes { least: exact, most: exact });
    }
    let bounds = Fields::of(value, "`takes`, unless it is a time,", fields.found)?;
    let takes = Takes {
        least: bounds.time("least").unwrap_or(0),
        most: bounds.time("most").unwrap_or(u64::MAX),
    };
    bounds.finish("`takes`");
    Some(takes)
}

fn fault(fields: &Fields<'_, '_, '_>) -> Option<Fault> {
    let port = fields.address("fault");
    let drop = fields.boolean("drop").filter(|drop| *drop).map(|_| Harm::Drop);
    let delay = fields.time("delay").map(Harm::Delay);
    let corrupt = fields.value("corrupt").map(Harm::Corrupt);
    let every = fields.count("every", 1).unwrap_or(1);
    let samples = fields.count("samples", 1);
    let mut harms = [drop, delay, corrupt].into_iter().flatten();
    let (harm, more) = (harms.next(), harms.next());
    if more.is_some() || harm.is_none() {
        let message = "a fault is one of `drop`, `delay` and `corrupt`";
        let help = "drop = true, delay = \"20ms\" or corrupt = { velocity = 9.0 }";
        fields.found.add(fields.span.clone(), message, Some(help.to_owned()));
    }
    Some(Fault { port: port?, harm: harm?, every, samples })
}
