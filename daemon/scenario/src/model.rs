//! What a file of scenarios says.

use std::collections::BTreeMap;
use std::path::PathBuf;

use genom_protocol::{Address, ConnectionEntry, ConnectionRequest, LoadRequest, TaskEntry};
use genom_stage::Script;
use serde::Deserialize;
use serde_json::Value;

use crate::source::Place;

/// The scenarios of a file.
#[derive(Clone, Debug)]
pub struct Suite {
    /// The file, as it was named.
    pub file: PathBuf,
    /// In the order of the file.
    pub scenarios: Vec<Scenario>,
    /// Whether it is a script, which an interpreter lists and plays.
    pub script: bool,
}

impl Suite {
    /// A script, of which nothing is known yet.
    #[must_use]
    pub fn script(file: PathBuf) -> Self {
        Self { file, scenarios: Vec::new(), script: true }
    }
}

impl Scenario {
    /// A scenario of a script, from what its interpreter lists: a line of JSON.
    ///
    /// # Errors
    /// It is something else.
    pub fn listed(line: &str) -> serde_json::Result<Self> {
        let Listed { name, line } = serde_json::from_str(line)?;
        let place = Place { line, column: 1 };
        Ok(Self { name, place, setup: Setup::default(), steps: Vec::new(), run: None })
    }
}

#[derive(Deserialize)]
struct Listed {
    name: String,
    line: usize,
}

/// A scenario: it begins with a daemon of its own, at time zero.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// What it shows, as a sentence.
    pub name: String,
    /// Where it is in the file.
    pub place: Place,
    /// What runs when it begins.
    pub setup: Setup,
    /// What is done, in order, up to the first step that fails.
    pub steps: Vec<Step>,
    /// In place of all that: a run of a component without its library.
    pub run: Option<Run>,
}

/// A run of one component without its library: codels take and yield what the run says.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The files of its description.
    pub description: Vec<PathBuf>,
    /// Directories of included files.
    pub include: Vec<PathBuf>,
    /// Definitions for the preprocessor.
    pub define: Vec<String>,
    /// The component, if several are described.
    pub component: Option<String>,
    /// What is overridden of its tasks.
    pub tasks: BTreeMap<String, TaskEntry>,
    /// Activities of services that one task may have at the same time.
    pub max_activities: Option<usize>,
    /// What happens.
    pub script: Script,
    /// Where each step is in the file.
    pub places: Vec<Place>,
}

/// What runs when a scenario begins. Paths are absolute, or names that are searched for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Setup {
    /// A configuration or deployment.
    pub deployment: Option<PathBuf>,
    /// Components to load after those of the deployment.
    pub components: Vec<LoadRequest>,
    /// Connections to make.
    pub connections: Vec<ConnectionEntry>,
    /// Middleware of components that name none; `local` if nothing is said.
    pub backend: Option<String>,
    /// Directories in which components are searched.
    pub path: Vec<PathBuf>,
}

/// A step of a scenario.
#[derive(Clone, Debug)]
pub struct Step {
    /// Where it is in the file.
    pub place: Place,
    /// What it is.
    pub action: Action,
}

/// What a step does, or what it expects.
#[derive(Clone, Debug)]
pub enum Action {
    /// Loads a component.
    Load(Box<LoadRequest>),
    /// Unloads one.
    Unload(String),
    /// Connects an in port or a remote.
    Connect(ConnectionRequest),
    /// Disconnects an in port.
    Disconnect(Address),
    /// Advances the clock by so many nanoseconds.
    Advance(u64),
    /// Publishes a value to an in port.
    Publish {
        /// The port.
        port: Address,
        /// The value; members that are left out keep what was published last.
        value: Value,
    },
    /// Calls a service; steps the clock until it has ended.
    Call {
        /// The service.
        service: Address,
        /// Inputs by name.
        inputs: Value,
        /// How it has to end.
        ended: Ended,
    },
    /// Starts an activity.
    Start {
        /// The service.
        service: Address,
        /// Inputs by name.
        inputs: Value,
        /// What later steps call it.
        label: String,
    },
    /// Asks an activity to stop.
    Abort(String),
    /// Steps the clock until an activity has ended.
    Wait {
        /// The activity.
        of: String,
        /// How it has to end.
        ended: Ended,
    },
    /// Fires an external event.
    Fire {
        /// The component.
        component: String,
        /// The event.
        event: String,
    },
    /// Compares something with what it has to be.
    Expect(Expected),
    /// From now on something harms the samples that an in port reads.
    Fault(Fault),
    /// That ends.
    Repair(Address),
    /// Kills the process of a cell.
    Kill(String),
}

/// How a service has to end, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Ended {
    /// Nanoseconds that it may take.
    pub within: u64,
    /// Outputs; those left out may have any value.
    pub result: Option<Value>,
    /// Full name of the exception that it has to end with.
    pub throws: Option<String>,
    /// Members of the exception; those left out may have any value.
    pub detail: Option<Value>,
    /// Greatest difference of numbers.
    pub tolerance: f64,
    /// Time from its start to its end.
    pub takes: Option<Takes>,
}

/// Bounds of a time, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Takes {
    /// At least.
    pub least: u64,
    /// At most.
    pub most: u64,
}

/// What something has to be.
#[derive(Clone, Debug, PartialEq)]
pub enum Expected {
    /// A port.
    Port {
        /// Its address.
        port: Address,
        /// Its last value; members left out may have any value.
        value: Option<Value>,
        /// Greatest difference of numbers.
        tolerance: f64,
        /// Whether it has no value yet.
        absent: bool,
        /// Samples written, or new ones read.
        samples: Option<u64>,
    },
    /// An activity.
    Activity {
        /// The activity.
        of: String,
        /// The states that it entered, in order; one that leads to itself counts once.
        states: Option<Vec<String>>,
        /// Whether it has not ended.
        running: Option<bool>,
    },
    /// A component.
    Component {
        /// Its name.
        name: String,
        /// Codels that ran.
        codels: Option<Codels>,
        /// Ticks that its tasks missed, together.
        missed: Option<u64>,
        /// Its state, such as `running` or `down`.
        state: Option<String>,
    },
}

/// Codels that ran since their component was loaded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Codels {
    /// These ran at least once.
    Ran(Vec<String>),
    /// These ran so often.
    Counts(Vec<(String, u64)>),
}

/// What happens to the samples of a connection.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// The in port.
    pub port: Address,
    /// What happens to each sample that is hit.
    pub harm: Harm,
    /// The sample of this number, and its multiples, is hit, from 1.
    pub every: u64,
    /// So many are hit, and no more.
    pub samples: Option<u64>,
}

/// What happens to a sample.
#[derive(Clone, Debug, PartialEq)]
pub enum Harm {
    /// It is lost.
    Drop,
    /// It comes so many nanoseconds later.
    Delay(u64),
    /// Members of it, or all of it, are replaced.
    Corrupt(Value),
}
