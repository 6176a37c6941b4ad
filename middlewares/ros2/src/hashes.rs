//! Hashes by which ROS nodes recognise the types of ports and services.

use genom_middleware::{ServiceKind, ServiceType};
use genom_rosidl::{Action, Interface, Mapper, Service, TypeName};
use genom_types::DataType;

use crate::masquerades::Masquerades;

/// The hashes of a service or action; `None` if a type within is unknown, or ROS has none like it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Hashes {
    /// Of the service, or of the one that takes goals.
    pub(crate) service: Option<String>,
    /// Of the service that gives results, and of the message with the feedback.
    pub(crate) get_result: Option<String>,
    pub(crate) feedback: Option<String>,
}

impl Masquerades {
    /// The hash of the message of a port; `None` if a message within it is unknown.
    pub(crate) fn hash(&self, ty: &DataType) -> Option<String> {
        let mut mapper = Mapper::new(ty.table(), self.all());
        let name = mapper.port(ty.id()).ok()?;
        let all = mapper.finish();
        let made = all.iter().find(|one| *one.name() == name).cloned();
        let whole = made.or_else(|| self.library.find(&name).ok())?;
        self.hash_of(&whole, &all)
    }

    /// The hash of one of ROS's own types.
    pub(crate) fn hash_of_foreign(&self, name: &TypeName) -> Option<String> {
        self.hash_of(&self.library.find(name).ok()?, &[])
    }

    /// The hash of an interface. `made` has the messages that are not in the library.
    fn hash_of(&self, whole: &Interface, made: &[Interface]) -> Option<String> {
        let find = |name: &TypeName| {
            let made = made.iter().flat_map(Interface::parts).find(|part| part.name == *name);
            made.cloned().or_else(|| self.library.message(name).ok())
        };
        genom_rosidl::hash(whole, &find).ok()
    }

    /// The hashes of a service of this name, which is ours or, with `foreign`, one of ROS's.
    pub(crate) fn hashes(&self, name: &TypeName, ty: &ServiceType, foreign: bool) -> Hashes {
        let found = if foreign {
            self.library.find(name).ok().map(|whole| (whole, Vec::new()))
        } else {
            self.ours(name, ty)
        };
        let Some((whole, mut made)) = found else { return Hashes::default() };
        made.push(whole.clone());
        let hash = |part: Interface| self.hash_of(&part, &made);
        match whole {
            Interface::Action(action) => Hashes {
                service: hash(Interface::Service(action.send_goal())),
                get_result: hash(Interface::Service(action.get_result())),
                feedback: hash(Interface::Message(action.feedback_message())),
            },
            whole => Hashes { service: hash(whole), ..Hashes::default() },
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

    fn masquerades() -> Masquerades {
        Masquerades::new(&Options::default())
    }

    #[test]
    fn services_and_actions_of_ours_have_hashes_that_tell_them_apart() {
        let of = |kind, input, output, folder| {
            let ty = ServiceType::new(kind, input, output);
            masquerades().hashes(&TypeName::new("demo", folder, "Goto"), &ty, false)
        };
        let function = of(ServiceKind::Function, state(), note(), "srv");
        assert!(function.service.is_some() && function.get_result.is_none());
        let other = of(ServiceKind::Function, state(), state(), "srv");
        assert_ne!(function.service, other.service);
        let action = of(ServiceKind::Activity, state(), note(), "action");
        let all = [action.service, action.get_result, action.feedback].map(Option::unwrap);
        assert!(all[0] != all[1] && all[1] != all[2] && all[0] != all[2], "{all:?}");
    }

    #[test]
    fn the_parts_of_an_action_of_ros_have_the_hashes_that_ros_publishes() {
        let name = TypeName::new("test_msgs", "action", "Fibonacci");
        let ty = ServiceType::new(ServiceKind::Activity, state(), state());
        let hashes = masquerades().hashes(&name, &ty, true);
        let published = "RIHS01_d807633803e38e164276573cd97e9fbd71e109c290bbf4cc312a0a1c9da7bbd9";
        assert_eq!(hashes.service.as_deref(), Some(published));
        let cancel = TypeName::new("action_msgs", "srv", "CancelGoal");
        assert!(masquerades().hash_of_foreign(&cancel).is_some());
    }
}
