//! Definitions of the types that ports and services use, of ours and of ROS.

use std::sync::Arc;

use genom_middleware::{ServiceKind, ServiceType};
use genom_rosidl::{Action, Description, Interface, Mapper, Missing, Service, TypeName};
use genom_types::DataType;

use crate::lock::lock;
use crate::masquerades::Masquerades;
use crate::used::{Parts, Used};

impl Masquerades {
    /// The message of a port; `None` if a message within it is unknown.
    pub(crate) fn of_port(&self, ty: &DataType) -> Option<Arc<Used>> {
        let mut mapper = Mapper::new(ty.table(), self.all());
        let name = mapper.port(ty.id()).ok()?;
        let made = mapper.finish();
        match made.iter().find(|one| *one.name() == name).cloned() {
            Some(whole) => self.used(whole, &Arc::new(made)),
            None => self.of_ros(&name),
        }
    }

    /// One of ROS's own types.
    pub(crate) fn of_ros(&self, name: &TypeName) -> Option<Arc<Used>> {
        if let Some(known) = lock(&self.foreign).get(name) {
            return Some(Arc::clone(known));
        }
        let used = self.used(self.library.find(name).ok()?, &Arc::default())?;
        lock(&self.foreign).insert(name.clone(), Arc::clone(&used));
        Some(used)
    }

    fn used(&self, whole: Interface, made: &Arc<Vec<Interface>>) -> Option<Arc<Used>> {
        let hash = genom_rosidl::hash(&whole, &|name| self.message_within(made, name)).ok()?;
        Some(Arc::new(Used { whole, made: Arc::clone(made), hash }))
    }

    /// The description of a type in use.
    pub(crate) fn describe(&self, used: &Used) -> Result<Description, Missing> {
        Description::of(&used.whole, &|name| self.message_within(&used.made, name))
    }

    fn message_within(&self, made: &[Interface], name: &TypeName) -> Option<genom_rosidl::Message> {
        let made = made.iter().flat_map(Interface::parts).find(|part| part.name == *name);
        made.cloned().or_else(|| self.library.message(name).ok())
    }

    /// The types of a service of this name, which is ours or, with `foreign`, one of ROS's.
    pub(crate) fn of_service(&self, name: &TypeName, ty: &ServiceType, foreign: bool) -> Parts {
        let found = if foreign {
            self.library.find(name).ok().map(|whole| (whole, Vec::new()))
        } else {
            self.ours(name, ty)
        };
        let Some((whole, mut made)) = found else { return Parts::default() };
        made.push(whole.clone());
        let made = Arc::new(made);
        let used = |part: Interface| self.used(part, &made);
        match whole {
            Interface::Action(action) => Parts {
                service: used(Interface::Service(action.send_goal())),
                get_result: used(Interface::Service(action.get_result())),
                feedback: used(Interface::Message(action.feedback_message())),
                action: used(Interface::Action(action)),
            },
            whole => Parts { service: used(whole), ..Parts::default() },
        }
    }

    /// The definition of a service of ours, and of the messages within.
    fn ours(&self, name: &TypeName, ty: &ServiceType) -> Option<(Interface, Vec<Interface>)> {
        // Input and output may be of different tables.
        let mut input = Mapper::new(ty.input.table(), self.all());
        let mut output = Mapper::new(ty.output.table(), self.all());
        let whole = if ty.kind == ServiceKind::Activity {
            let goal = input.fields(&name.part("_Goal"), ty.input.id()).ok()?;
            let result = output.response(&name.part("_Result"), ty.output.id()).ok()?;
            let feedback = Mapper::feedback(name);
            Interface::Action(Action { name: name.clone(), goal, result, feedback })
        } else {
            let request = input.fields(&name.part("_Request"), ty.input.id()).ok()?;
            let response = output.response(&name.part("_Response"), ty.output.id()).ok()?;
            Interface::Service(Service { name: name.clone(), request, response })
        };
        let mut made = input.finish();
        made.extend(output.finish());
        Some((whole, made))
    }
}

#[cfg(test)]
mod tests {
    use genom_conformance::samples::{note, state};

    use super::*;
    use crate::options::Options;
    use crate::used::hash;

    fn masquerades() -> Masquerades {
        Masquerades::new(&Options::default())
    }

    #[test]
    fn services_and_actions_of_ours_have_hashes_that_tell_them_apart() {
        let of = |kind, input, output, folder| {
            let ty = ServiceType::new(kind, input, output);
            masquerades().of_service(&TypeName::new("demo", folder, "Goto"), &ty, false)
        };
        let function = of(ServiceKind::Function, state(), note(), "srv");
        assert!(function.service.is_some() && function.get_result.is_none());
        let other = of(ServiceKind::Function, state(), state(), "srv");
        assert_ne!(hash(function.service.as_ref()), hash(other.service.as_ref()));
        let action = of(ServiceKind::Activity, state(), note(), "action");
        let mut all: Vec<_> = action.all().map(|used| used.hash.clone()).collect();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 4, "{all:?}");
    }

    #[test]
    fn the_parts_of_an_action_of_ros_have_the_hashes_that_ros_publishes() {
        let name = TypeName::new("test_msgs", "action", "Fibonacci");
        let ty = ServiceType::new(ServiceKind::Activity, state(), state());
        let parts = masquerades().of_service(&name, &ty, true);
        let published = "RIHS01_d807633803e38e164276573cd97e9fbd71e109c290bbf4cc312a0a1c9da7bbd9";
        assert_eq!(hash(parts.service.as_ref()).as_deref(), Some(published));
        let published = "RIHS01_be9273e3557225044b4a040811112491f7079326e3a573f83258b0b4c30bd069";
        assert_eq!(hash(parts.action.as_ref()).as_deref(), Some(published));
        let cancel = TypeName::new("action_msgs", "srv", "CancelGoal");
        assert!(masquerades().of_ros(&cancel).is_some());
    }
}
