//! Requests to the parameter services of a node.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use genom_middleware::Outcome;
use genom_types::Record;
use ros2_client::parameters::raw::{self, IntegerRange, ParameterDescriptor, SetParametersResult};
use ros2_client::parameters::{Parameter, ParameterType, ParameterValue as Value};
use ros2_client::rcl_interfaces::{
    DescribeParametersRequest, DescribeParametersResponse, GetParameterTypesRequest,
    GetParameterTypesResponse, GetParametersRequest, GetParametersResponse, ListParametersRequest,
    ListParametersResponse, ListParametersResult, SetParametersAtomicallyResponse,
    SetParametersRequest, SetParametersResponse,
};

use super::error::SetError;
use super::events::Events;
use super::gather::Gather;
use super::table::{Attributes, Known, parameters};
use crate::lock::lock;
use crate::own_services::{OwnService, Reply, answer};
use crate::typed;

/// The parameters of one node.
pub(crate) struct Parameters {
    pub(super) events: Arc<Events>,
    pub(super) attributes: Attributes,
    /// Whether the time of components is that of a simulator.
    pub(super) simulated: bool,
}

const PACKAGE: &str = "rcl_interfaces";

/// All parameter services.
pub(crate) const SERVICES: [OwnService<Parameters>; 6] = [
    OwnService {
        name: "describe_parameters",
        ty: (PACKAGE, "DescribeParameters"),
        serve: describe,
    },
    OwnService { name: "get_parameter_types", ty: (PACKAGE, "GetParameterTypes"), serve: types },
    OwnService { name: "get_parameters", ty: (PACKAGE, "GetParameters"), serve: get },
    OwnService { name: "list_parameters", ty: (PACKAGE, "ListParameters"), serve: list },
    OwnService { name: "set_parameters", ty: (PACKAGE, "SetParameters"), serve: set },
    OwnService {
        name: "set_parameters_atomically",
        ty: (PACKAGE, "SetParametersAtomically"),
        serve: set_one,
    },
];

impl Parameters {
    fn all(&self) -> BTreeMap<String, Known> {
        parameters(lock(&self.attributes).values(), self.simulated)
    }
}

/// `GetParameters`.
fn get(node: &Parameters, reply: Reply, message: &[u8]) -> Option<()> {
    let names = typed::decode::<GetParametersRequest>(message)?.names;
    let all = node.all();
    let gather = Gather::new(vec![Value::NotSet; names.len()], move |values: Vec<Value>| {
        let values = values.into_iter().map(Into::into).collect();
        answer(reply, &GetParametersResponse { values });
    });
    for (place, name) in names.iter().enumerate() {
        let pair = match all.get(name) {
            Some(Known::Clock(clock)) => {
                gather.put(place, clock.value());
                continue;
            }
            Some(Known::Attributes(pair)) => pair,
            None => continue,
        };
        let Some((attribute, shape)) = pair.get.clone() else { continue };
        let told = move |outcome: Outcome| match outcome {
            Outcome::Success(output) => shape.value(&output.to_json()).unwrap_or(Value::NotSet),
            _ => Value::NotSet,
        };
        let input = Record::new(&attribute.ty.input);
        attribute.handler.request(input, gather.place(place, told));
    }
    Some(())
}

/// Result of setting a parameter: the reason if it was not set.
type Set = Result<(), SetError>;

fn result(set: &Set) -> SetParametersResult {
    let why = set.as_ref().err().map(SetError::to_string);
    SetParametersResult { successful: set.is_ok(), reason: why.unwrap_or_default() }
}

/// Sets several parameters, one after the other, and tells all who listen which ones were set.
fn set_all(
    node: &Parameters,
    wanted: Vec<raw::Parameter>,
    then: impl FnOnce(Vec<Set>) + Send + 'static,
) {
    let all = node.all();
    let given_up = wanted.iter().map(|_| Err(SetError::Gone)).collect();
    let values: Vec<_> = wanted.iter().cloned().map(Parameter::from).collect();
    let events = Arc::clone(&node.events);
    let gather = Gather::new(given_up, move |results: Vec<Set>| {
        let set = wanted.into_iter().zip(&results).filter(|(_, result)| result.is_ok());
        events.changed(set.map(|(parameter, _)| parameter).collect());
        then(results);
    });
    for (place, Parameter { name, value }) in values.iter().enumerate() {
        let pair = match all.get(name) {
            Some(Known::Attributes(pair)) => pair,
            Some(Known::Clock(clock)) => {
                gather.put(place, clock.set(value));
                continue;
            }
            None => {
                gather.put(place, Err(SetError::Unknown(name.clone())));
                continue;
            }
        };
        let Some((attribute, shape)) = &pair.set else {
            gather.put(place, Err(SetError::ReadOnly(name.clone())));
            continue;
        };
        let input = shape.json(value).and_then(|json| {
            let mut input = Record::new(&attribute.ty.input);
            input.merge_json(&json)?;
            Ok(input)
        });
        match input {
            Ok(input) => attribute.handler.request(input, gather.place(place, outcome_of_set)),
            Err(why) => gather.put(place, Err(why)),
        }
    }
}

fn outcome_of_set(outcome: Outcome) -> Set {
    match outcome {
        Outcome::Success(_) => Ok(()),
        Outcome::Exception { name, detail } => Err(SetError::Exception { name, detail }),
        Outcome::Lost(error) => Err(SetError::Lost(error)),
    }
}

/// What is to be set; `None` if the message is cut, or a value is of an unknown type.
fn wanted(message: &[u8]) -> Option<Vec<raw::Parameter>> {
    let wanted = typed::decode::<SetParametersRequest>(message)?.parameter;
    let greatest = raw::ParameterType::STRING_ARRAY;
    wanted.iter().all(|one| one.value.ptype <= greatest).then_some(wanted)
}

/// `SetParameters`.
fn set(node: &Parameters, reply: Reply, message: &[u8]) -> Option<()> {
    set_all(node, wanted(message)?, move |results| {
        answer(reply, &SetParametersResponse { results: results.iter().map(result).collect() });
    });
    Some(())
}

/// `SetParametersAtomically`. Attributes are set one by one, so only a single one can be set
/// atomically.
fn set_one(node: &Parameters, reply: Reply, message: &[u8]) -> Option<()> {
    let wanted = wanted(message)?;
    let told = move |set: Set| {
        answer(reply, &SetParametersAtomicallyResponse { result: result(&set) });
    };
    if wanted.len() > 1 {
        told(Err(SetError::Several));
    } else {
        set_all(node, wanted, move |results| told(results.into_iter().collect()));
    }
    Some(())
}

/// `GetParameterTypes`.
fn types(node: &Parameters, reply: Reply, message: &[u8]) -> Option<()> {
    let names = typed::decode::<GetParameterTypesRequest>(message)?.names;
    let all = node.all();
    let ty = |name| all.get(name).map_or(ParameterType::NotSet, Known::ty) as u8;
    answer(reply, &GetParameterTypesResponse { values: names.iter().map(ty).collect() });
    Some(())
}

/// `DescribeParameters`.
fn describe(node: &Parameters, reply: Reply, message: &[u8]) -> Option<()> {
    let names = typed::decode::<DescribeParametersRequest>(message)?.names;
    let all = node.all();
    let values = names.into_iter().map(|name| described(all.get_key_value(&name))).collect();
    answer(reply, &DescribeParametersResponse { values });
    Some(())
}

/// One that is not known is described without a name.
fn described(known: Option<(&String, &Known)>) -> ParameterDescriptor {
    let name = known.map_or_else(String::new, |(name, _)| name.clone());
    let known = known.map_or_else(Known::default, |(_, known)| known.clone());
    let range = |(from_value, to_value)| IntegerRange { from_value, to_value, step: 1 };
    ParameterDescriptor {
        name,
        r#type: known.ty() as u8,
        description: known.description(),
        additional_constraints: known.constraint().to_owned(),
        read_only: known.is_read_only(),
        dynamic_typing: false,
        floating_point_range: Vec::new(),
        integer_range: known.range().map(range).into_iter().collect(),
    }
}

/// `ListParameters`.
fn list(node: &Parameters, reply: Reply, message: &[u8]) -> Option<()> {
    let ListParametersRequest { prefixes, depth } = typed::decode(message)?;
    let (names, prefixes) = listed(node.all().into_keys(), &prefixes, depth);
    answer(reply, &ListParametersResponse { result: ListParametersResult { names, prefixes } });
    Some(())
}

/// Names below one of the prefixes (all names if there are none), at most `depth` levels below it
/// (0: any depth); and the prefixes of these names, up to their last dot.
fn listed(
    names: impl Iterator<Item = String>,
    prefixes: &[String],
    depth: u64,
) -> (Vec<String>, Vec<String>) {
    let shallow = |rest: &str| {
        let dots = rest.matches('.').count();
        depth == 0 || u64::try_from(dots).is_ok_and(|dots| dots < depth)
    };
    let below = |name: &str, prefix: &String| match name.strip_prefix(prefix.as_str()) {
        Some("") => true,
        Some(rest) => rest.strip_prefix('.').is_some_and(shallow),
        None => false,
    };
    let wanted = |name: &String| match prefixes {
        [] => shallow(name),
        _ => prefixes.iter().any(|prefix| below(name, prefix)),
    };
    let names: Vec<String> = names.filter(wanted).collect();
    let before: BTreeSet<&str> =
        names.iter().filter_map(|name| name.rsplit_once('.')).map(|(before, _)| before).collect();
    let before = before.into_iter().map(str::to_owned).collect();
    (names, before)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_listed_by_prefix_and_depth() {
        let names = ["gain", "left.gain", "left.limit.lower", "leftover"];
        let list = |prefixes: &[&str], depth| {
            let prefixes: Vec<String> = prefixes.iter().map(|&prefix| prefix.to_owned()).collect();
            listed(names.iter().map(|&name| name.to_owned()), &prefixes, depth)
        };
        assert_eq!(list(&[], 0).0, names);
        assert_eq!(list(&[], 0).1, ["left", "left.limit"]);
        assert_eq!(list(&[], 1).0, ["gain", "leftover"]);
        assert_eq!(list(&["left"], 0).0, ["left.gain", "left.limit.lower"]);
        assert_eq!(list(&["left"], 1).0, ["left.gain"]);
        assert_eq!(list(&["gain", "right"], 0).0, ["gain"]);
    }
}
