//! `~/get_type_description`: what the types are made of that a node uses (REP-2016).
//!
//! A type is found by its hash, as ROS's nodes find it. On DDS none of ours is announced, so that a
//! type is also found by its name if no hash is given.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use genom_rosidl::{
    Description, Field, FieldType, Message, Missing, Source, TypeName, fields, sources,
};
use serde::{Deserialize, Serialize};

use crate::lock::lock;
use crate::masquerades::Masquerades;
use crate::own_services::{OwnService, OwnServices, Reply, answer};
use crate::rmw::{EndError, Entities};
use crate::ros::Ros;
use crate::typed;
use crate::used::Used;

/// Types that a node uses, by hash, each with the number of its users.
pub(crate) type Types = Arc<Mutex<BTreeMap<String, (Arc<Used>, usize)>>>;

/// What `rcl` and its tools call the hash of an end that announces none.
const NO_HASH: &str = "INVALID";

/// The service.
const SERVICES: [OwnService<Descriptions>; 1] = [OwnService {
    name: "get_type_description",
    ty: ("type_description_interfaces", "GetTypeDescription"),
    serve: describe,
}];

/// The types of one node.
pub(crate) struct Descriptions {
    types: Types,
    masquerades: Arc<Masquerades>,
}

/// The service of a node with these types. `node` has the namespace in front.
pub(crate) fn open(ros: &Ros, node: &str, types: &Types) -> Result<OwnServices, EndError> {
    let (types, masquerades) = (Arc::clone(types), Arc::clone(&ros.masquerades));
    let state = Arc::new(Descriptions { types, masquerades });
    OwnServices::open(ros, node, &SERVICES, &state, Entities::default())
}

/// Whether the service has this name.
pub(crate) fn is_taken_by(name: &str) -> bool {
    SERVICES.iter().any(|service| service.name == name)
}

/// Its type.
pub(crate) fn types() -> impl Iterator<Item = TypeName> {
    SERVICES.iter().map(OwnService::type_name)
}

/// A type is not described.
#[derive(Debug, thiserror::Error)]
enum NotDescribed {
    #[error("`{0}` is no type hash: that is RIHS01_ and 64 hexadecimal digits")]
    NoHash(String),
    #[error("no type of this hash is in use by this node")]
    NotInUse,
    #[error("no type {0} is in use by this node")]
    NoSuchType(String),
    #[error(transparent)]
    Missing(#[from] Missing),
}

impl Descriptions {
    fn find(
        &self,
        Request { type_name, type_hash, .. }: &Request,
    ) -> Result<Arc<Used>, NotDescribed> {
        let types = lock(&self.types);
        if type_hash.is_empty() || type_hash == NO_HASH {
            let of_name =
                |used: &&(Arc<Used>, usize)| used.0.whole.name().to_string() == *type_name;
            let found = types.values().find(of_name);
            return found
                .map(|(used, _)| Arc::clone(used))
                .ok_or_else(|| NotDescribed::NoSuchType(type_name.clone()));
        }
        let digits = type_hash.strip_prefix("RIHS01_").unwrap_or_default();
        if digits.len() != 64 || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            return Err(NotDescribed::NoHash(type_hash.clone()));
        }
        let found = types.get(type_hash).map(|(used, _)| Arc::clone(used));
        found.ok_or(NotDescribed::NotInUse)
    }

    fn describe(&self, request: &Request) -> Result<Response, NotDescribed> {
        let used = self.find(request)?;
        let description = self.masquerades.describe(&used)?;
        let sources = match request.include_type_sources {
            true => sources(&used.whole, &description).into_iter().map(Into::into).collect(),
            false => Vec::new(),
        };
        let by_name = !request.type_hash.starts_with("RIHS01_");
        let hash = by_name.then(|| ("type_hash".to_owned(), used.hash.clone()));
        Ok(Response {
            successful: true,
            failure_reason: String::new(),
            type_description: description.into(),
            type_sources: sources,
            extra_information: hash.into_iter().collect(),
        })
    }
}

fn describe(node: &Descriptions, reply: Reply, message: &[u8]) -> Option<()> {
    let request: Request = typed::decode(message)?;
    let response = node
        .describe(&request)
        .unwrap_or_else(|why| Response { failure_reason: why.to_string(), ..Response::default() });
    answer(reply, &response);
    Some(())
}

// The messages of type_description_interfaces.

#[derive(Deserialize)]
struct Request {
    type_name: String,
    type_hash: String,
    include_type_sources: bool,
}

#[derive(Default, Serialize)]
struct Response {
    successful: bool,
    failure_reason: String,
    type_description: TypeDescription,
    type_sources: Vec<TypeSource>,
    extra_information: Vec<(String, String)>,
}

#[derive(Default, Serialize)]
struct TypeDescription {
    type_description: Individual,
    referenced_type_descriptions: Vec<Individual>,
}

#[derive(Default, Serialize)]
struct Individual {
    type_name: String,
    fields: Vec<Member>,
}

#[derive(Serialize)]
struct Member {
    name: String,
    type_id: u8,
    capacity: u64,
    string_capacity: u64,
    nested_type_name: String,
    /// Has no part in the hash, and is not known.
    default_value: String,
}

#[derive(Serialize)]
struct TypeSource {
    type_name: String,
    encoding: String,
    raw_file_contents: String,
}

impl From<Description> for TypeDescription {
    fn from(Description { whole, others }: Description) -> Self {
        Self {
            type_description: (&whole).into(),
            referenced_type_descriptions: others.iter().map(Into::into).collect(),
        }
    }
}

impl From<&Message> for Individual {
    fn from(message: &Message) -> Self {
        let fields = fields(message).iter().map(Into::into).collect();
        Self { type_name: message.name.to_string(), fields }
    }
}

impl From<&Field> for Member {
    fn from(field: &Field) -> Self {
        let FieldType { id, capacity, string_capacity, nested } = FieldType::of(field);
        Self {
            name: field.name.clone(),
            type_id: id,
            capacity: capacity.into(),
            string_capacity: string_capacity.into(),
            nested_type_name: nested,
            default_value: String::new(),
        }
    }
}

impl From<Source> for TypeSource {
    fn from(Source { name, encoding, text }: Source) -> Self {
        let (type_name, encoding) = (name.to_string(), encoding.to_owned());
        Self { type_name, encoding, raw_file_contents: text }
    }
}
