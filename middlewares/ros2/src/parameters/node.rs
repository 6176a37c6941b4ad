//! The parameter services of one node.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, OnceLock};

use genom_middleware::{Address, Outcome};
use genom_types::Record;

use super::error::SetError;
use super::gather::Gather;
use super::table::{Attribute, Parameter, parameters};
use super::value::{Value, put_all, put_long};
use crate::body::{self, Fields};
use crate::lock::lock;
use crate::names::{self, TypeName};
use crate::rmw::{self, EndError, Entities, Named, ServerEnd};
use crate::ros::Ros;

/// Attributes of an instance, by name.
pub(crate) type Attributes = Arc<Mutex<BTreeMap<String, Arc<Attribute>>>>;

/// One of the parameter services.
pub(crate) struct Service {
    pub(crate) name: &'static str,
    /// Name of its type in `rcl_interfaces/srv`.
    ty: &'static str,
    /// Decodes a request and arranges for the reply; `None` if it cannot be decoded.
    serve: fn(&Arc<Node>, Reply, Fields<'_>) -> Option<()>,
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
    ends: OnceLock<Vec<Box<dyn ServerEnd>>>,
    belonging: OnceLock<Box<dyn Send + Sync>>,
    attributes: Attributes,
}

type Reply = Box<dyn rmw::Reply>;

impl Node {
    pub(crate) fn open(
        ros: &Ros,
        path: &str,
        at: &Address,
        attributes: Attributes,
    ) -> Result<Arc<Self>, EndError> {
        let (ends, belonging) = (OnceLock::new(), OnceLock::new());
        let node = Arc::new(Self { ends, belonging, attributes });
        let name = names::token(&at.instance);
        let mut made = Vec::with_capacity(SERVICES.len());
        for service in &SERVICES {
            let ty = TypeName::new("rcl_interfaces", "srv", service.ty);
            let hash = ros.masquerades.hash_of_foreign(&ty);
            let of = Named { name: format!("{path}/{}", service.name), ty, hash };
            let weak = Arc::downgrade(&node);
            let on_request = move |reply, message: &[u8]| {
                let Some(node) = weak.upgrade() else { return };
                let served = Fields::of(message).and_then(|all| (service.serve)(&node, reply, all));
                if served.is_none() {
                    tracing::warn!("a request of {} cannot be read; it is left out", service.ty);
                }
            };
            made.push(ros.rmw.server(&name, &of, Box::new(on_request))?);
        }
        let mut entities = Entities::default();
        for one in made.iter().map(|end| end.entities()) {
            entities.writers.extend(one.writers);
            entities.readers.extend(one.readers);
        }
        // Cannot fail: nobody else has the node yet.
        let _ = node.ends.set(made);
        let _ = node.belonging.set(ros.rmw.belong(&name, entities));
        Ok(node)
    }

    fn parameters(&self) -> BTreeMap<String, Parameter> {
        parameters(lock(&self.attributes).values())
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        self.ends.get().into_iter().flatten().for_each(|end| end.flush());
    }
}

/// `string[]`.
fn strings(fields: &mut Fields<'_>) -> Option<Vec<String>> {
    fields.all(|fields| fields.string().map(str::to_owned))
}

/// `GetParameters`.
fn get(node: &Arc<Node>, reply: Reply, mut fields: Fields<'_>) -> Option<()> {
    let names = strings(&mut fields)?;
    let all = node.parameters();
    let gather = Gather::new(vec![Value::NotSet; names.len()], move |values| {
        let mut body = Vec::new();
        put_all(&mut body, &values, |out, value| value.put(out));
        reply.send(body);
    });
    for (place, name) in names.iter().enumerate() {
        let Some((attribute, shape)) = all.get(name).and_then(|known| known.get.clone()) else {
            continue;
        };
        let told = move |outcome: Outcome| match outcome {
            Outcome::Success(output) => shape.value(&output.to_json()).unwrap_or_default(),
            _ => Value::NotSet,
        };
        let input = Record::new(&attribute.ty.input);
        attribute.handler.request(input, gather.place(place, told));
    }
    Some(())
}

/// Result of setting a parameter: the reason if it was not set.
type Set = Result<(), SetError>;

fn put_set(out: &mut Vec<u8>, set: &Set) {
    out.push(u8::from(set.is_ok()));
    let why = set.as_ref().err().map(SetError::to_string);
    body::put_string(out, why.as_deref().unwrap_or_default());
}

/// Sets several parameters, one after the other.
fn set_all(
    node: &Node,
    wanted: Vec<(String, Value)>,
    then: impl FnOnce(Vec<Set>) + Send + 'static,
) {
    let all = node.parameters();
    let gather = Gather::new(wanted.iter().map(|_| Err(SetError::Gone)).collect(), then);
    for (place, (name, value)) in wanted.iter().enumerate() {
        let input = match all.get(name) {
            None => Err(SetError::Unknown(name.clone())),
            Some(Parameter { set: None, .. }) => Err(SetError::ReadOnly(name.clone())),
            Some(Parameter { set: Some((attribute, shape)), .. }) => {
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

/// `rcl_interfaces/msg/Parameter[]`.
fn pairs(fields: &mut Fields<'_>) -> Option<Vec<(String, Value)>> {
    fields.all(|fields| Some((fields.string()?.to_owned(), Value::take(fields)?)))
}

/// `SetParameters`.
fn set(node: &Arc<Node>, reply: Reply, mut fields: Fields<'_>) -> Option<()> {
    set_all(node, pairs(&mut fields)?, move |results| {
        let mut body = Vec::new();
        put_all(&mut body, &results, put_set);
        reply.send(body);
    });
    Some(())
}

/// `SetParametersAtomically`. Attributes are set one by one, so only a single one can be set
/// atomically.
fn set_one(node: &Arc<Node>, reply: Reply, mut fields: Fields<'_>) -> Option<()> {
    let wanted = pairs(&mut fields)?;
    let answer = move |result: Set| {
        let mut body = Vec::new();
        put_set(&mut body, &result);
        reply.send(body);
    };
    if wanted.len() > 1 {
        answer(Err(SetError::Several));
    } else {
        set_all(node, wanted, move |results| answer(results.into_iter().collect()));
    }
    Some(())
}

/// `GetParameterTypes`.
fn types(node: &Arc<Node>, reply: Reply, mut fields: Fields<'_>) -> Option<()> {
    let names = strings(&mut fields)?;
    let all = node.parameters();
    let mut body = Vec::new();
    put_all(&mut body, &names, |out, name| {
        out.push(all.get(name).map_or(Value::NotSet.ty(), Parameter::ty) as u8);
    });
    reply.send(body);
    Some(())
}

/// `DescribeParameters`.
fn describe(node: &Arc<Node>, reply: Reply, mut fields: Fields<'_>) -> Option<()> {
    let names = strings(&mut fields)?;
    let all = node.parameters();
    let unknown = Parameter::default();
    let mut body = Vec::new();
    put_all(&mut body, &names, |out, name| {
        let (name, known) = match all.get(name) {
            Some(known) => (name.as_str(), known),
            None => ("", &unknown),
        };
        body::put_string(out, name);
        out.push(known.ty() as u8);
        body::put_string(out, &known.description());
        body::put_string(out, known.constraint());
        // Read-only; may change its type.
        out.extend_from_slice(&[u8::from(known.set.is_none()), 0]);
        let ranges: Vec<_> = known.range().into_iter().collect();
        put_all::<()>(out, &[], |_, ()| {});
        put_all(out, &ranges, |out, (least, greatest)| {
            put_long(out, *least);
            put_long(out, *greatest);
            put_long(out, 1);
        });
    });
    reply.send(body);
    Some(())
}

/// `ListParameters`.
fn list(node: &Arc<Node>, reply: Reply, mut fields: Fields<'_>) -> Option<()> {
    let (prefixes, depth) = (strings(&mut fields)?, fields.long()?);
    let (names, prefixes) = listed(node.parameters().into_keys(), &prefixes, depth);
    let mut body = Vec::new();
    put_all(&mut body, &names, |out, name| body::put_string(out, name));
    put_all(&mut body, &prefixes, |out, name| body::put_string(out, name));
    reply.send(body);
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
