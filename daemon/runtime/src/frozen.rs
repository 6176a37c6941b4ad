//! What an instance is between two passes of its tasks, and how another one goes on from there.

use std::fmt;

use genom_description::model::{Owner, PortIx, ServiceIx, StateIx};
use genom_types::Record;

use crate::api::{ActivityPhase, Reply};
use crate::body::Memory;

/// What an instance is between two passes of its tasks.
///
/// Requests that are being served are not in it: their senders are answered by the instance itself.
#[derive(Debug)]
pub struct Frozen {
    /// The IDS; pointers of `native` members are valid in this process only.
    pub ids: Option<Record>,
    /// Services that were executed successfully, for `before` and `after` (genom3.md 7.6).
    pub executed: Vec<ServiceIx>,
    /// Permanent activities, and activities of services; those of one task in the order in which it
    /// runs their codels.
    pub activities: Vec<FrozenActivity>,
}

/// An activity between two of its codels.
#[derive(Clone, Debug)]
pub struct FrozenActivity {
    /// Its number.
    pub id: u32,
    /// Its service; a task for the permanent activity of one.
    pub owner: Owner,
    /// [`Init`](ActivityPhase::Init), [`Run`](ActivityPhase::Run) or [`Stop`](ActivityPhase::Stop); of a
    /// permanent one that has ended [`Ether`](ActivityPhase::Ether).
    pub phase: ActivityPhase,
    /// Accepted, and waits for the end of those that it interrupts (genom3.md 7.6).
    pub pending: bool,
    /// Who asked it to stop, if anybody did.
    pub stopped_by: Option<String>,
    /// The states where it is; none before it starts, and none of a permanent one that has ended.
    pub tokens: Vec<FrozenToken>,
    /// Its inputs, outputs and local variables; none of a permanent activity.
    pub memory: Option<Memory>,
}

impl FrozenActivity {
    /// A permanent activity that has ended.
    pub(crate) fn over(owner: Owner) -> Self {
        Self {
            id: 0,
            owner,
            phase: ActivityPhase::Ether,
            pending: false,
            stopped_by: None,
            tokens: Vec::new(),
            memory: None,
        }
    }
}

/// A state where an activity is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrozenToken {
    /// The state.
    pub state: StateIx,
    /// What its codel waits for.
    pub waits: Waiting,
}

/// What the codel of a state waits for (genom3.md 7.5, dialects.md A).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waiting {
    /// The next pass.
    Ready,
    /// The next tick, or an event in the component.
    Paused,
    /// An external event, or a stop request.
    Asleep,
}

/// The last value of a port.
#[derive(Debug)]
pub struct FrozenPort {
    /// The port.
    pub port: PortIx,
    /// The element of a multiple port.
    pub element: Option<String>,
    /// The value.
    pub value: Record,
}

/// Changes the IDS, once.
pub type ChangeIds = Box<dyn FnOnce(&mut Record) + Send>;

/// Where an instance is to go on.
///
/// Start codels run as at every start, since they open what only the process has: devices, memory of
/// `native` members. After the first codel of each task nothing runs until the IDS, the ports and
/// the activities are as they were. No codel validates the inputs again, and no resumed activity
/// interrupts another one, since both was done when they were accepted.
pub struct Resume {
    /// Changes the IDS, from what start codels made of them.
    pub ids: Option<ChangeIds>,
    /// Last values of ports. Those of in ports are put back only after [`hold`](Self::hold), since a
    /// new connection has no value before the first that is read.
    pub ports: Vec<FrozenPort>,
    /// Services that were executed successfully.
    pub executed: Vec<ServiceIx>,
    /// Permanent activities and those of services, as of [`Frozen::activities`]. A permanent one that
    /// is not among them stays where its start codel led it.
    pub activities: Vec<Resumed>,
    /// Whether the tasks wait for [`Instance::go_on`](crate::Instance::go_on).
    pub hold: bool,
}

impl fmt::Debug for Resume {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Resume")
            .field("ids", &self.ids.is_some())
            .field("activities", &self.activities)
            .field("hold", &self.hold)
            .finish_non_exhaustive()
    }
}

/// An activity that is to go on.
pub struct Resumed {
    /// Where it was. Its number stays the same if it is free.
    pub activity: FrozenActivity,
    /// Hears that it was accepted, and how it ended; not for permanent ones.
    pub reply: Option<Reply>,
    /// Who waits for it in the instance that [hands it over](crate::Instance::hand_over) goes on to
    /// wait here, and hears nothing of that; `reply` is not used.
    pub goes_on: bool,
}

impl fmt::Debug for Resumed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.activity.fmt(f)
    }
}
