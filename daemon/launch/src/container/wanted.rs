//! What a request to load a node wants, in the words of a component.

use std::collections::BTreeMap;

use genom_description::model::{
    Component as Model, Direction, PortDirection, Service, ServiceKind,
};
use genom_nearest::suggest;
use genom_protocol::{BadRemap, Remap, Renamed};
use serde_json::{Map, Value, json};

/// Why a component cannot be loaded as it is asked for.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Unwanted {
    #[error("{0}")]
    Rule(#[from] BadRemap),
    #[error("remap rule `{rule}` is for node `{node}`; this one is `{name}`")]
    OtherNode { rule: String, node: String, name: String },
    #[error("{component} has no attribute that sets parameter `{name}`; {help}")]
    NoParameter { component: String, name: String, help: String },
    #[error(
        "parameter `{CLOCK}` = {0}: the clock of all components is that of the daemon, `clock` in \
         its configuration"
    )]
    Clock(Value),
    #[error("parameter `{0}` has no value")]
    NoValue(String),
    #[error("extra argument `{name}`: give {wanted}")]
    Argument { name: String, wanted: &'static str },
}

/// The parameter that says which clock a node has.
const CLOCK: &str = "use_sim_time";

/// A parameter of ROS: its name and value.
pub(crate) fn parameter(message: &Value) -> (String, Value) {
    let value = &message["value"];
    // `rcl_interfaces/msg/ParameterType`.
    let member = match value["type"].as_u64() {
        Some(1) => "bool_value",
        Some(2) => "integer_value",
        Some(3) => "double_value",
        Some(4) => "string_value",
        Some(5) => "byte_array_value",
        Some(6) => "bool_array_value",
        Some(7) => "integer_array_value",
        Some(8) => "double_array_value",
        Some(9) => "string_array_value",
        _ => "",
    };
    let value = value.get(member).cloned().unwrap_or(Value::Null);
    (message["name"].as_str().unwrap_or_default().to_owned(), value)
}

/// An attribute that sets a parameter, and its one member.
struct Setter<'a> {
    service: &'a Service,
    member: &'a str,
}

fn setters(model: &Model) -> Vec<Setter<'_>> {
    let attributes = model.services.iter().filter(|one| one.kind == ServiceKind::Attribute);
    attributes
        .filter_map(|service| {
            let mut taken = service.parameters.iter().filter(|parameter| {
                matches!(parameter.direction, Direction::In | Direction::InOut)
            });
            let member = &taken.next()?.name;
            taken.next().is_none().then_some(Setter { service, member })
        })
        .collect()
}

/// Inputs of the attributes that set these parameters, by name of the attribute. A parameter has the
/// name of the member, or `attribute.member` where several attributes have such a one. The clock of
/// a node cannot be set, but is said to be right: `simulated` if it is that of a simulator.
pub(crate) fn attributes(
    model: &Model,
    parameters: &[(String, Value)],
    simulated: bool,
) -> Result<BTreeMap<String, Value>, Unwanted> {
    let setters = setters(model);
    let alone = |member: &str| setters.iter().filter(|one| one.member == member).count() == 1;
    let full = |one: &Setter<'_>| format!("{}.{}", one.service.name, one.member);
    let mut all = BTreeMap::new();
    for (name, value) in parameters {
        let is = |one: &&Setter<'_>| (one.member == name && alone(name)) || full(one) == *name;
        let Some(setter) = setters.iter().find(is) else {
            if name == CLOCK {
                match value.as_bool() == Some(simulated) {
                    true => continue,
                    false => return Err(Unwanted::Clock(value.clone())),
                }
            }
            let known: Vec<String> = setters
                .iter()
                .map(|one| if alone(one.member) { one.member.to_owned() } else { full(one) })
                .collect();
            let help = suggest(name, known.iter().map(String::as_str));
            let (component, name) = (model.name.clone(), name.clone());
            return Err(Unwanted::NoParameter { component, name, help });
        };
        if value.is_null() {
            return Err(Unwanted::NoValue(name.clone()));
        }
        let inputs = Map::from_iter([(setter.member.to_owned(), value.clone())]);
        all.insert(setter.service.name.clone(), Value::Object(inputs));
    }
    Ok(all)
}

/// Rules of renaming, apart from what in ports are to read.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Rules {
    pub(crate) remap: Vec<Remap>,
    /// In ports, and the names in ROS of what they read.
    pub(crate) reads: Vec<(String, String)>,
}

/// Sorts rules as ROS writes them: `from:=to`, or `node:from:=to` for one node.
pub(crate) fn rules(model: &Model, node: &str, rules: &[&str]) -> Result<Rules, Unwanted> {
    let mut sorted = Rules::default();
    for rule in rules {
        let plain = match rule.split_once(":=").and_then(|(from, _)| from.split_once(':')) {
            None => *rule,
            Some((of, _)) if of == node => &rule[of.len() + 1..],
            Some((of, _)) => {
                let (rule, node, name) = ((*rule).to_owned(), of.to_owned(), node.to_owned());
                return Err(Unwanted::OtherNode { rule, node, name });
            }
        };
        let remap: Remap = plain.parse()?;
        let reads = |name: &str| {
            let port = model.ports.iter().find(|port| name.split('/').next() == Some(&port.name));
            port.is_some_and(|port| port.direction == PortDirection::In)
        };
        match &remap.what {
            Renamed::Name(name) if reads(name) => sorted.reads.push((name.clone(), remap.to)),
            _ => sorted.remap.push(remap),
        }
    }
    Ok(sorted)
}

/// The cell in which it is to run, if the extra arguments say so. Those of ROS's own containers that
/// have no meaning here are left out.
pub(crate) fn cell(arguments: &[(String, Value)]) -> Result<Option<String>, Unwanted> {
    let given = arguments.iter().find(|(name, _)| name == "cell");
    match given {
        None => Ok(None),
        Some((_, Value::String(cell))) => Ok(Some(cell.clone())),
        Some((name, _)) => {
            let wanted = "the name of a cell, a string";
            Err(Unwanted::Argument { name: name.clone(), wanted })
        }
    }
}

/// The answer to a request that failed.
pub(crate) fn refused(why: &impl std::fmt::Display) -> Value {
    json!({"success": false, "error_message": why.to_string()})
}
