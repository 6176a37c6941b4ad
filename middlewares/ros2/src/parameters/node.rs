//! The parameter services of one node.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, OnceLock};

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
use serde::Serialize;

use super::error::SetError;
use super::events::Events;
use super::gather::Gather;
use super::table::{Attribute, Known, parameters};
use crate::lock::lock;
use crate::names::TypeName;
use crate::rmw::{self, EndError, ServerEnd};
use crate::ros::Ros;
use crate::typed;

/// Attributes of an instance, by name.
pub(crate) type Attributes = Arc<Mutex<BTreeMap<String, Arc<Attribute>>>>;

/// One of the parameter services.
pub(crate) struct Service {
    pub(crate) name: &'static str,
    /// Name of its type in `rcl_interfaces/srv`.
    ty: &'static str,
    /// Decodes a request and arranges for the reply; `None` if it cannot be decoded.
    serve: fn(&Node, Reply, &[u8]) -> Option<()>,
}

/// All parameter services, in the order of [`Node`]'s ends.
pub(crate) const SERVICES: [Service; 6] = [
    Service { name: "describe_parameters", ty: "DescribeParameters", serve: describe },
    Service { name: "get_parameter_types", ty: "GetParameterTypes", serve: types },
    Service { name: "get_parameters", ty: "GetParameters", serve: get },
    Service { name: "list_parameters", ty: "ListParameters", serve: list },
    Service { name: "set_parameters", ty: "SetParameters", serve: set },
    Service { name: "set_parameters_atomically", ty: "SetParametersAtomically", serve: set_one },
];

/// The services of one node. Fields are dropped in order.
pub(crate) struct Node {
    events: Arc<Events>,
    ends: OnceLock<Vec<Box<dyn ServerEnd>>>,
    belonging: OnceLock<Box<dyn Send + Sync>>,
    attributes: Attributes,
}

type Reply = Box<dyn rmw::Reply>;

impl Node {
    /// `node_name` has the namespace in front.
    pub(crate) fn open(
        ros: &Ros,
        node_name: &str,
        attributes: Attributes,
    ) -> Result<Arc<Self>, EndError> {
        let events = Events::open(ros, node_name)?;
        let mut entities = events.entities();
        let (ends, belonging) = (OnceLock::new(), OnceLock::new());
        let node = Arc::new(Self { events, ends, belonging, attributes });
        let mut made = Vec::with_capacity(SERVICES.len());
        for service in &SERVICES {
            let ty = TypeName::new("rcl_interfaces", "srv", service.ty);
            let of = ros.of_ros(format!("{node_name}/{}", service.name), ty);
            let weak = Arc::downgrade(&node);
            let on_request = move |reply, message: &[u8]| {
                let Some(node) = weak.upgrade() else { return };
                if (service.serve)(&node, reply, message).is_none() {
                    tracing::warn!("a request of {} cannot be read; it is left out", service.ty);
                }
            };
            made.push(ros.rmw.server(node_name, &of, Box::new(on_request))?);
        }
        for one in made.iter().map(|end| end.entities()) {
            entities.writers.extend(one.writers);
            entities.readers.extend(one.readers);
        }
        // Cannot fail: nobody else has the node yet.
        let _ = node.ends.set(made);
        let _ = node.belonging.set(ros.rmw.belong(node_name, entities));
        Ok(node)
    }

    fn parameters(&self) -> BTreeMap<String, Known> {
        parameters(lock(&self.attributes).values())
    }
}

/// Sends a reply.
fn answer(reply: Reply, response: &impl Serialize) {
    // None of them can fail to be encoded: they consist of texts and numbers.
    if let Some(body) = typed::encode(response) {
        reply.send(body);
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        self.ends.get().into_iter().flatten().for_each(|end| end.flush());
    }
}

/// `GetParameters`.
fn get(node: &Node, reply: Reply, message: &[u8]) -> Option<()> {
    let names = typed::decode::<GetParametersRequest>(message)?.names;
    let all = node.parameters();
    let gather = Gather::new(vec![Value::NotSet; names.len()], move |values: Vec<Value>| {
        let values = values.into_iter().map(Into::into).collect();
        answer(reply, &GetParametersResponse { values });
    });
    for (place, name) in names.iter().enumerate() {
        let Some((attribute, shape)) = all.get(name).and_then(|known| known.get.clone()) else {
            continue;
        };
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
fn set_all(node: &Node, wanted: Vec<raw::Parameter>, then: impl FnOnce(Vec<Set>) + Send + 'static) {
    let all = node.parameters();
    let given_up = wanted.iter().map(|_| Err(SetError::Gone)).collect();
    let values: Vec<_> = wanted.iter().cloned().map(Parameter::from).collect();
    let events = Arc::clone(&node.events);
    let gather = Gather::new(given_up, move |results: Vec<Set>| {
        let set = wanted.into_iter().zip(&results).filter(|(_, result)| result.is_ok());
        events.changed(set.map(|(parameter, _)| parameter).collect());
        then(results);
    });
    for (place, Parameter { name, value }) in values.iter().enumerate() {
        let input = match all.get(name) {
            None => Err(SetError::Unknown(name.clone())),
            Some(Known { set: None, .. }) => Err(SetError::ReadOnly(name.clone())),
            Some(Known { set: Some((attribute, shape)), .. }) => {
                shape.json(value).and_then(|json| {
                    let mut input = Record::new(&attribute.ty.input);
                    input.merge_json(&json)?;
                    Ok((attribute, input))
                })
            }
        };
        match input {
            Ok((attribute, input)) => {
                attribute.handler.request(input, gather.place(place, outcome_of_set));
            }
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
fn set(node: &Node, reply: Reply, message: &[u8]) -> Option<()> {
    set_all(node, wanted(message)?, move |results| {
        answer(reply, &SetParametersResponse { results: results.iter().map(result).collect() });
    });
    Some(())
}

/// `SetParametersAtomically`. Attributes are set one by one, so only a single one can be set
/// atomically.
fn set_one(node: &Node, reply: Reply, message: &[u8]) -> Option<()> {
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
fn types(node: &Node, reply: Reply, message: &[u8]) -> Option<()> {
    let names = typed::decode::<GetParameterTypesRequest>(message)?.names;
    let all = node.parameters();
    let ty = |name| all.get(name).map_or(ParameterType::NotSet, Known::ty) as u8;
    answer(reply, &GetParameterTypesResponse { values: names.iter().map(ty).collect() });
    Some(())
}

/// `DescribeParameters`.
fn describe(node: &Node, reply: Reply, message: &[u8]) -> Option<()> {
    let names = typed::decode::<DescribeParametersRequest>(message)?.names;
    let all = node.parameters();
    let values = names.into_iter().map(|name| described(all.get_key_value(&name))).collect();
    answer(reply, &DescribeParametersResponse { values });
    Some(())
}

/// One that is not known is described without a name.
fn described(known: Option<(&String, &Known)>) -> ParameterDescriptor {
    let (name, known) =
        known.map_or_else(Default::default, |(name, known)| (name.clone(), known.clone()));
    let range = |(from_value, to_value)| IntegerRange { from_value, to_value, step: 1 };
    ParameterDescriptor {
        name,
        r#type: known.ty() as u8,
        description: known.description(),
        additional_constraints: known.constraint().to_owned(),
        read_only: known.set.is_none(),
        dynamic_typing: false,
        floating_point_range: Vec::new(),
        integer_range: known.range().map(range).into_iter().collect(),
    }
}

/// `ListParameters`.
fn list(node: &Node, reply: Reply, message: &[u8]) -> Option<()> {
    let ListParametersRequest { prefixes, depth } = typed::decode(message)?;
    let (names, prefixes) = listed(node.parameters().into_keys(), &prefixes, depth);
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
