//! The messages and services of `lifecycle_msgs`.

use genom_middleware::ServiceType;
use genom_types::{DataType, Kind, LayoutError, TypeId};

use crate::offer::Kind as Offered;
use crate::table::Table;

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
}

impl Offered for Service {
    fn name(self) -> &'static str {
        match self {
            Self::ChangeState => "change_state",
            Self::GetState => "get_state",
            Self::GetAvailableStates => "get_available_states",
            Self::GetAvailableTransitions => "get_available_transitions",
            Self::GetTransitionGraph => "get_transition_graph",
        }
    }

    fn masquerade(self) -> (String, String) {
        let ros = match self {
            Self::ChangeState => "ChangeState",
            Self::GetState => "GetState",
            Self::GetAvailableStates => "GetAvailableStates",
            Self::GetAvailableTransitions | Self::GetTransitionGraph => "GetAvailableTransitions",
        };
        (format!("::{PACKAGE}::{}", self.name()), format!("{PACKAGE}/srv/{ros}"))
    }

    fn types(self) -> Result<ServiceType, LayoutError> {
        let mut table = Table::of(PACKAGE);
        let (input, output) = match self {
            Self::ChangeState => {
                let (transition, success) = (transition(&mut table), table.add(Kind::Boolean));
                (vec![("transition", transition)], ("success", success))
            }
            Self::GetState => (vec![], ("current_state", state(&mut table))),
            Self::GetAvailableStates => {
                let state = state(&mut table);
                (vec![], ("available_states", table.several(state)))
            }
            Self::GetAvailableTransitions | Self::GetTransitionGraph => {
                let description = description(&mut table);
                (vec![], ("available_transitions", table.several(description)))
            }
        };
        table.service(self.name(), input, vec![output])
    }
}

/// `lifecycle_msgs/msg/TransitionEvent`.
pub(crate) fn event() -> Result<DataType, LayoutError> {
    let mut table = Table::of(PACKAGE);
    let timestamp = table.add(Kind::UnsignedLongLong);
    let (transition, state) = (transition(&mut table), state(&mut table));
    let members = vec![
        ("timestamp", timestamp),
        ("transition", transition),
        ("start_state", state),
        ("goal_state", state),
    ];
    let event = table.message("TransitionEvent", members);
    table.finish(event)
}

/// `Transition` and `State` have the same members.
fn spelled(table: &mut Table, name: &str) -> TypeId {
    let members = vec![("id", table.add(Kind::Octet)), ("label", table.string())];
    table.message(name, members)
}

fn state(table: &mut Table) -> TypeId {
    spelled(table, "State")
}

fn transition(table: &mut Table) -> TypeId {
    spelled(table, "Transition")
}

fn description(table: &mut Table) -> TypeId {
    let (transition, state) = (transition(table), state(table));
    let members = vec![("transition", transition), ("start_state", state), ("goal_state", state)];
    table.message("TransitionDescription", members)
}
