//! The messages and services of `lifecycle_msgs`, as IDL types whose names are those of ROS.

use std::sync::Arc;

use genom_middleware::{ServiceKind, ServiceType};
use genom_types::{DataType, Kind, LayoutError, Member, ScopedName, TypeId, TypeTable};

/// The package of all of them.
const PACKAGE: &str = "lifecycle_msgs";

/// The services of a managed node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Service {
    ChangeState,
    GetState,
    GetAvailableStates,
    GetAvailableTransitions,
    /// Of the same type as the one before; it tells all transitions, not only those that are possible
    /// now.
    GetTransitionGraph,
}

impl Service {
    pub(crate) const ALL: [Self; 5] = [
        Self::ChangeState,
        Self::GetState,
        Self::GetAvailableStates,
        Self::GetAvailableTransitions,
        Self::GetTransitionGraph,
    ];

    /// Its name below the node's.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::ChangeState => "change_state",
            Self::GetState => "get_state",
            Self::GetAvailableStates => "get_available_states",
            Self::GetAvailableTransitions => "get_available_transitions",
            Self::GetTransitionGraph => "get_transition_graph",
        }
    }

    /// The full name of our type, and the ROS type that it is.
    pub(crate) fn masquerade(self) -> (String, String) {
        let ros = match self {
            Self::ChangeState => "ChangeState",
            Self::GetState => "GetState",
            Self::GetAvailableStates => "GetAvailableStates",
            Self::GetAvailableTransitions | Self::GetTransitionGraph => "GetAvailableTransitions",
        };
        (format!("::{PACKAGE}::{}", self.name()), format!("{PACKAGE}/srv/{ros}"))
    }

    /// Its input and output.
    pub(crate) fn types(self) -> Result<ServiceType, LayoutError> {
        let mut table = Table::default();
        let (input, output) = match self {
            Self::ChangeState => {
                let (transition, success) = (table.transition(), table.0.add(Kind::Boolean));
                (vec![("transition", transition)], ("success", success))
            }
            Self::GetState => (vec![], ("current_state", table.state())),
            Self::GetAvailableStates => {
                let state = table.state();
                (vec![], ("available_states", table.several(state)))
            }
            Self::GetAvailableTransitions | Self::GetTransitionGraph => {
                let description = table.description();
                (vec![], ("available_transitions", table.several(description)))
            }
        };
        let input = table.of([self.name(), "input"], input);
        let output = table.of([self.name(), "output"], vec![output]);
        let table = Arc::new(table.0);
        let (input, output) = (DataType::new(&table, input)?, DataType::new(&table, output)?);
        Ok(ServiceType::new(ServiceKind::Function, input, output))
    }
}

/// `lifecycle_msgs/msg/TransitionEvent`.
pub(crate) fn event() -> Result<DataType, LayoutError> {
    let mut table = Table::default();
    let timestamp = table.0.add(Kind::UnsignedLongLong);
    let (transition, state) = (table.transition(), table.state());
    let members = vec![
        ("timestamp", timestamp),
        ("transition", transition),
        ("start_state", state),
        ("goal_state", state),
    ];
    let event = table.of(["TransitionEvent"], members);
    DataType::new(&Arc::new(table.0), event)
}

/// A table with the messages that the others are made of.
#[derive(Default)]
struct Table(TypeTable);

impl Table {
    /// A struct with this name within the package.
    fn of<const N: usize>(&mut self, name: [&str; N], members: Vec<(&str, TypeId)>) -> TypeId {
        let member = |(name, ty): (&str, TypeId)| Member { name: name.to_owned(), ty };
        let members = members.into_iter().map(member).collect();
        let name = ScopedName::new([PACKAGE].into_iter().chain(name));
        self.0.add(Kind::Struct { name, members })
    }

    /// `Transition` and `State` have the same members.
    fn spelled(&mut self, name: &str) -> TypeId {
        let (id, label) = (self.0.add(Kind::Octet), self.0.add(Kind::String { bound: None }));
        self.of([name], vec![("id", id), ("label", label)])
    }

    fn state(&mut self) -> TypeId {
        self.spelled("State")
    }

    fn transition(&mut self) -> TypeId {
        self.spelled("Transition")
    }

    fn description(&mut self) -> TypeId {
        let (transition, state) = (self.transition(), self.state());
        let members =
            vec![("transition", transition), ("start_state", state), ("goal_state", state)];
        self.of(["TransitionDescription"], members)
    }

    fn several(&mut self, element: TypeId) -> TypeId {
        self.0.add(Kind::Sequence { element, bound: None })
    }
}
