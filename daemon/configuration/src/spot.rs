//! Finds an entry of a configuration in its file, for mistakes that are found only when it is
//! applied: a port the component does not have, a value of the wrong type.

use std::fmt;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use genom_protocol::LoadRequest;
use genom_protocol::{CallEntry, ConnectionEntry};

/// Identifies an entry of a configuration, and a key in it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Spot(Box<Inner>);

/// Boxed to keep the errors that carry a `Spot` small.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Inner {
    /// `component`, `connection`, `call` or `activity`.
    section: &'static str,
    /// Members that identify the entry.
    is: Vec<(&'static str, String)>,
    /// Path of keys from the entry to the mistake.
    key: Vec<String>,
}

impl Spot {
    fn entry(section: &'static str, is: Vec<(&'static str, String)>) -> Self {
        Self(Box::new(Inner { section, is, key: Vec::new() }))
    }

    /// The entry of `[[component]]` that this request comes from.
    pub fn component(request: &LoadRequest) -> Self {
        let is = match &request.name {
            Some(name) => vec![("name", name.clone())],
            None => vec![("library", request.library.to_string_lossy().into_owned())],
        };
        Self::entry("component", is)
    }

    /// The entry of `[[component]]` of this instance name.
    pub fn named(instance: &str) -> Self {
        Self::entry("component", vec![("name", instance.to_owned())])
    }

    /// An entry of `[[connection]]`.
    pub fn connection(entry: &ConnectionEntry) -> Self {
        Self::entry("connection", vec![("in", entry.inport.clone())])
    }

    /// An entry of `[[call]]` or `[[activity]]`.
    pub fn request(section: &'static str, entry: &CallEntry) -> Self {
        let is = vec![("component", entry.component.clone()), ("service", entry.service.clone())];
        Self::entry(section, is)
    }

    /// Appends keys below the entry.
    pub fn key<S: Into<String>>(mut self, key: impl IntoIterator<Item = S>) -> Self {
        self.0.key = key.into_iter().map(Into::into).collect();
        self
    }

    /// `FILE:LINE: KEY`, or the nearest enclosing place that the file contains.
    pub fn told(&self, file: &Path, text: &str) -> Option<String> {
        let at = self.find(text)?;
        Some(format!("{}:{}: {self}", file.display(), line(text, at)))
    }

    /// Byte offset of the key or, if the text does not contain it, of the nearest key or entry
    /// above it.
    fn find(&self, text: &str) -> Option<usize> {
        let parsed = DeTable::parse(text).ok()?;
        let DeValue::Array(entries) = parsed.get_ref().get(self.0.section)?.get_ref() else {
            return None;
        };
        let entry = entries.iter().find(|entry| {
            let DeValue::Table(members) = entry.get_ref() else { return false };
            self.0.is.iter().all(|(key, value)| {
                string(members, key).is_some_and(|found| {
                    // Paths in the request were made absolute: compare their end with what the file
                    // says.
                    found == value || (*key == "library" && value.ends_with(found))
                })
            })
        })?;
        let mut at = entry.span().start;
        let mut value = entry.get_ref();
        for key in &self.0.key {
            if let DeValue::Array(entries) = value {
                let Some(entry) = key.parse().ok().and_then(|at: usize| entries.get(at)) else {
                    break;
                };
                (at, value) = (entry.span().start, entry.get_ref());
                continue;
            }
            let DeValue::Table(members) = value else { break };
            let Some((name, inner)) =
                members.iter().find(|(name, _)| name.get_ref().as_ref() == key.as_str())
            else {
                break;
            };
            (at, value) = (Spanned::span(name).start, inner.get_ref());
        }
        Some(at)
    }
}

/// Line and address of the first in port or remote that a second `[[connection]]` names.
pub(crate) fn connected_twice(text: &str) -> Option<(usize, String)> {
    let parsed = DeTable::parse(text).ok()?;
    let DeValue::Array(entries) = parsed.get_ref().get("connection")?.get_ref() else {
        return None;
    };
    let mut seen = Vec::new();
    for entry in entries.iter() {
        let DeValue::Table(members) = entry.get_ref() else { continue };
        let Some(inport) = string(members, "in") else { continue };
        if seen.contains(&inport) {
            return Some((line(text, members.get("in")?.span().start), inport.to_owned()));
        }
        seen.push(inport);
    }
    None
}

/// Number of the line, from 1, that contains a byte offset.
fn line(text: &str, at: usize) -> usize {
    text.as_bytes()[..at.min(text.len())].iter().filter(|&&one| one == b'\n').count() + 1
}

fn string<'a>(table: &'a DeTable<'_>, key: &str) -> Option<&'a str> {
    match table.get(key)?.get_ref() {
        DeValue::String(text) => Some(text),
        _ => None,
    }
}

impl fmt::Display for Spot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.section)?;
        self.0.key.iter().try_for_each(|key| write!(f, ".{key}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "[[component]]\nlibrary = \"demo\"\n\n[[component]]\nlibrary = \"a/b.so\"\n\
                        name = \"arm\"\n[component.attributes]\nset_speed = { velocity = 3 }\n\
                        [[connection]]\nin = \"arm/goal\"\nout = \"demo/position\"\n";

    #[track_caller]
    fn check(place: &Spot, told: &str) {
        assert_eq!(place.told(Path::new("robot.toml"), FILE).as_deref(), Some(told));
    }

    #[test]
    fn a_key_is_found_in_its_entry() {
        let arm = LoadRequest { name: Some("arm".into()), ..LoadRequest::default() };
        let attribute = ["attributes", "set_speed", "velocity"];
        check(
            &Spot::component(&arm).key(attribute),
            "robot.toml:8: component.attributes.set_speed.velocity",
        );
        check(&Spot::component(&arm).key(["tasks"]), "robot.toml:4: component.tasks");
        let rules = "[[component]]\nlibrary = \"demo\"\n[[component.supervision]]\nstuck = true\n\
                     [[component.supervision]]\nwcet = true\n";
        let second =
            Spot::component(&LoadRequest { library: "demo".into(), ..LoadRequest::default() });
        let second = second.key(["supervision", "1"]);
        let told = second.told(Path::new("robot.toml"), rules).unwrap();
        assert_eq!(told, "robot.toml:5: component.supervision.1");
        let demo = LoadRequest { library: "/path/demo".into(), ..LoadRequest::default() };
        check(&Spot::component(&demo).key(["library"]), "robot.toml:2: component.library");
        let wanted = Spot::entry("connection", vec![("in", "arm/goal".into())]).key(["out"]);
        check(&wanted, "robot.toml:11: connection.out");
        assert_eq!(Spot::default().told(Path::new("robot.toml"), FILE), None);
    }
}
