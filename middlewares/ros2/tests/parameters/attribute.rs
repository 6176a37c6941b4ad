//! Attributes of a component `robot`, which are parameters of its node.

use std::sync::{Arc, Mutex};

use genom_middleware::{
    ActivityId, Address, Outcome, Replies, Served, ServiceHandler, ServiceKind, ServiceType,
    Services as _,
};
use genom_ros2::Ros2;
use genom_types::Record;
use serde_json::{Map, Value, json};

use crate::services::{Make, service};

/// The data of a component, by name.
pub(crate) type Ids = Arc<Mutex<Map<String, Value>>>;

/// An attribute with one member, which refuses 13.
pub(crate) struct Attribute {
    ids: Ids,
    ty: ServiceType,
}

impl Attribute {
    /// Serves what gets it and what sets it.
    pub(crate) fn serve(ros2: &Ros2, ids: &Ids, member: &str, ty: Make) -> [Box<dyn Served>; 2] {
        let value = [(member, ty)];
        ["get", "set"].map(|verb| {
            let name = format!("{verb}_{member}");
            let (input, output): (&[_], &[_]) =
                if verb == "get" { (&[], &value) } else { (&value, &[]) };
            let ty = service(ServiceKind::Attribute, &name, input, output);
            let handler = Arc::new(Self { ids: Arc::clone(ids), ty: ty.clone() });
            ros2.serve(&Address::new("robot", name), &ty, handler).unwrap()
        })
    }
}

impl ServiceHandler for Attribute {
    fn request(&self, input: Record, replies: Box<dyn Replies>) {
        let mut ids = self.ids.lock().unwrap();
        for (name, value) in input.to_json().as_object().into_iter().flatten() {
            if *value == json!(13) {
                let (name, detail) = ("::demo::UNLUCKY".to_owned(), json!({"value": 13}));
                return replies.finish(Outcome::Exception { name, detail });
            }
            ids.insert(name.clone(), value.clone());
        }
        let mut output = Record::new(&self.ty.output);
        if let Some(name) = self.ty.output.member_name(0) {
            output.merge_json(&json!({name: ids[name]})).unwrap();
        }
        replies.finish(Outcome::Success(output));
    }

    fn cancel(&self, _: ActivityId) {}
}
