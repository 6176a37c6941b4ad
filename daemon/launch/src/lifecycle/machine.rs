//! The states of a managed node, and what leads from one to the next. Numbers and labels are those of
//! `lifecycle_msgs` and of ROS's own nodes (`rcl_lifecycle`, `default_state_machine.c`).

use serde_json::{Value, json};

/// A state in which a node stays until it is asked to leave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// The component is not loaded.
    Unconfigured,
    /// It is loaded, and its tasks run; what the deployment starts is not started.
    Inactive,
    /// What the deployment starts runs.
    Active,
    /// It is unloaded for good: until the daemon is started again.
    Finalized,
}

/// What a node can be asked to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Transition {
    Configure,
    CleanUp,
    Activate,
    Deactivate,
    Shutdown,
}

use State::{Active, Finalized, Inactive, Unconfigured};
use Transition::{Activate, CleanUp, Configure, Deactivate, Shutdown};

/// All transitions, with the states that they are possible in.
const ALL: [(State, Transition); 7] = [
    (Unconfigured, Configure),
    (Inactive, CleanUp),
    (Inactive, Activate),
    (Active, Deactivate),
    (Unconfigured, Shutdown),
    (Inactive, Shutdown),
    (Active, Shutdown),
];

fn spelled(id: u8, label: &str) -> Value {
    json!({"id": id, "label": label})
}

impl State {
    const ALL: [Self; 4] = [Unconfigured, Inactive, Active, Finalized];

    pub(crate) const fn label(self) -> &'static str {
        match self {
            Unconfigured => "unconfigured",
            Inactive => "inactive",
            Active => "active",
            Finalized => "finalized",
        }
    }

    /// As `lifecycle_msgs/msg/State`.
    pub(crate) fn message(self) -> Value {
        let id = match self {
            Unconfigured => 1,
            Inactive => 2,
            Active => 3,
            Finalized => 4,
        };
        spelled(id, self.label())
    }

    /// What a node in this state can be asked to do.
    pub(crate) fn transitions(self) -> impl Iterator<Item = Transition> {
        ALL.into_iter().filter(move |(from, _)| *from == self).map(|(_, transition)| transition)
    }
}

impl Transition {
    /// What is asked of a node in this state: by the label, or where that is empty by the number.
    pub(crate) fn asked(id: u64, label: &str, from: State) -> Option<Self> {
        from.transitions().find(|one| match label {
            "" => u64::from(one.id(from)) == id,
            label => one.label() == label,
        })
    }

    pub(crate) const fn label(self) -> &'static str {
        match self {
            Configure => "configure",
            CleanUp => "cleanup",
            Activate => "activate",
            Deactivate => "deactivate",
            Shutdown => "shutdown",
        }
    }

    /// There are three of `shutdown`, one for each state.
    const fn id(self, from: State) -> u8 {
        match (self, from) {
            (Configure, _) => 1,
            (CleanUp, _) => 2,
            (Activate, _) => 3,
            (Deactivate, _) => 4,
            (Shutdown, Unconfigured) => 5,
            (Shutdown, Inactive) => 6,
            (Shutdown, Active | Finalized) => 7,
        }
    }

    /// As `lifecycle_msgs/msg/Transition`.
    fn message(self, from: State) -> Value {
        spelled(self.id(from), self.label())
    }

    /// The state in which a node is meanwhile.
    pub(crate) fn meanwhile(self) -> Value {
        match self {
            Configure => spelled(10, "configuring"),
            CleanUp => spelled(11, "cleaningup"),
            Shutdown => spelled(12, "shuttingdown"),
            Activate => spelled(13, "activating"),
            Deactivate => spelled(14, "deactivating"),
        }
    }

    /// The state that follows. A node that fails to do it stays what it was, except that there is no
    /// way back from a shutdown.
    pub(crate) const fn leads(self, from: State, success: bool) -> State {
        match (self, success) {
            (Shutdown, _) => Finalized,
            (_, false) => from,
            (Configure | Deactivate, true) => Inactive,
            (CleanUp, true) => Unconfigured,
            (Activate, true) => Active,
        }
    }

    /// What follows by itself when it is done, as `lifecycle_msgs/msg/Transition`.
    fn outcome(self, success: bool) -> Value {
        let tens = match self {
            Configure => 10,
            CleanUp => 20,
            Activate => 30,
            Deactivate => 40,
            Shutdown => 50,
        };
        let label = if success { "transition_success" } else { "transition_failure" };
        spelled(tens + u8::from(!success), label)
    }

    /// Its begin, as `lifecycle_msgs/msg/TransitionDescription`.
    pub(crate) fn begin(self, from: State) -> Value {
        described(&self.message(from), &from.message(), &self.meanwhile())
    }

    /// Its end, as `lifecycle_msgs/msg/TransitionDescription`.
    pub(crate) fn end(self, from: State, success: bool) -> Value {
        let to = self.leads(from, success).message();
        described(&self.outcome(success), &self.meanwhile(), &to)
    }
}

fn described(transition: &Value, start: &Value, goal: &Value) -> Value {
    json!({"transition": transition, "start_state": start, "goal_state": goal})
}

/// All states, also those in between: `lifecycle_msgs/msg/State[]`.
pub(crate) fn states() -> Vec<Value> {
    let between = [Configure, CleanUp, Shutdown, Activate, Deactivate];
    let stay = State::ALL.into_iter().map(State::message);
    stay.chain(between.into_iter().map(Transition::meanwhile)).collect()
}

/// All that leads from a state to another: `lifecycle_msgs/msg/TransitionDescription[]`.
pub(crate) fn graph() -> Vec<Value> {
    let mut graph = Vec::new();
    for (from, transition) in ALL {
        let all = [transition.begin(from), transition.end(from, true), transition.end(from, false)];
        for one in all {
            // The three shutdowns end alike.
            if !graph.contains(&one) {
                graph.push(one);
            }
        }
    }
    graph
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_asked_by_label_or_number_is_possible_in_that_state_only() {
        assert_eq!(Transition::asked(1, "", Unconfigured), Some(Configure));
        assert_eq!(Transition::asked(0, "configure", Unconfigured), Some(Configure));
        // The label decides, as in ROS's own nodes.
        assert_eq!(Transition::asked(1, "shutdown", Unconfigured), Some(Shutdown));
        assert_eq!(Transition::asked(1, "", Inactive), None);
        assert_eq!(Transition::asked(0, "activate", Active), None);
        for (from, id) in [(Unconfigured, 5), (Inactive, 6), (Active, 7)] {
            assert_eq!(Transition::asked(id, "", from), Some(Shutdown));
        }
        assert_eq!(Transition::asked(5, "", Active), None);
        assert_eq!(Finalized.transitions().count(), 0);
        assert_eq!(Transition::asked(u64::MAX, "", Active), None);
    }

    #[test]
    fn a_failure_leaves_a_node_as_it_was_and_a_shutdown_is_the_end() {
        assert_eq!(Configure.leads(Unconfigured, true), Inactive);
        assert_eq!(Configure.leads(Unconfigured, false), Unconfigured);
        assert_eq!(Activate.leads(Inactive, false), Inactive);
        assert_eq!(Deactivate.leads(Active, false), Active);
        assert_eq!(CleanUp.leads(Inactive, true), Unconfigured);
        assert_eq!(Shutdown.leads(Active, false), Finalized);
    }

    #[test]
    fn the_graph_has_each_way_once() {
        // 7 begins; 2 ends of each of the 4 others; and of shutdown one success and one failure.
        assert_eq!(graph().len(), 7 + 4 * 2 + 2);
        assert_eq!(states().len(), 9);
    }
}
