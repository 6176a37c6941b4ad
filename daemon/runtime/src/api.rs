//! Types in the interface of an instance: requests, outcomes, connections.

use std::fmt;

use genom_description::model::ServiceIx;
use genom_types::{JsonError, Record};
use serde_json::{Map, Value};

use crate::plan::Plan;

/// Receives the progress of a request: [`Progress::Accepted`] at most once, for activities, then
/// [`Progress::Ended`] once. Never called by a real-time thread, nor with a lock held.
pub type Reply = Box<dyn FnMut(Progress) + Send>;

/// Called once, by any thread, when a shutdown is complete: no codel of the instance runs, or will.
pub type OnShutdown = Box<dyn FnOnce() + Send>;

/// Phases of an activity's life (genom3.md 7.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActivityPhase {
    /// Accepted, not started.
    Init,
    /// Running.
    Run,
    /// Asked to stop; runs its `stop` codel, or a later one.
    Stop,
    /// Ended; its client will be informed next.
    Ether,
}

/// A step of a request.
#[derive(Debug)]
pub enum Progress {
    /// The activity was accepted; it starts once the activities that it interrupts have ended.
    Accepted {
        /// Its id, for [`Instance::abort`](crate::Instance::abort).
        activity: u32,
    },
    /// The end of the request.
    Ended(Outcome),
}

/// How a service ended.
///
/// Tasks return a `RunOutcome`, which consists of numbers; control turns it into this, with the
/// outputs as a record and the exception by name. Middlewares carry `genom_middleware::Outcome`,
/// which can also be `Lost` with the connection, and the control plane an outcome as JSON.
#[derive(Debug)]
pub enum Outcome {
    /// With its outputs.
    Success(Record),
    /// With an exception.
    Exception(Exception),
}

/// An exception, with its detail.
#[derive(Clone, Debug, PartialEq)]
pub struct Exception {
    /// Its full name: `::demo::OUT_OF_RANGE`.
    pub name: String,
    /// Its members; null when it has none.
    pub detail: Value,
}

impl fmt::Display for Exception {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.detail {
            Value::Null => f.write_str(&self.name),
            detail => write!(f, "{} {detail}", self.name),
        }
    }
}

/// Inputs of a request.
pub enum Inputs {
    /// All inputs: a record of the service's input struct.
    Whole(Record),
    /// Some inputs of an attribute: the others keep their values in the IDS.
    Partial(Partial),
    /// No inputs: reads what the IDS hold where an attribute stores its inputs. The outcome is a
    /// record of these; no codel runs.
    Look,
}

/// Sets the inputs that are given in a record that holds the values of the IDS; called again when
/// codels changed the IDS before the request was done. If it returns an exception, the request ends
/// with that and nothing is changed.
pub type Partial = Box<dyn FnMut(&mut Record) -> Result<(), Exception> + Send>;

impl fmt::Debug for Inputs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Inputs::Whole(record) => record.fmt(f),
            Inputs::Partial(_) => f.write_str("partial"),
            Inputs::Look => f.write_str("look"),
        }
    }
}

/// What the supervisor does for the standard services (genom3.md 4.8).
///
/// Called by a control worker that holds no exclusion; connections are made within
/// [`Instance::exclusively`](crate::Instance::exclusively).
pub trait Supervision: Send + Sync {
    /// Connects in port `local` (`port` or `port/element`) to out port `remote`.
    ///
    /// # Errors
    /// One of them does not exist, or the middleware fails.
    fn connect_port(&self, local: &str, remote: &str) -> Result<(), ConnectionError>;

    /// Connects remote `local` to service `remote` of another component.
    ///
    /// # Errors
    /// One of them does not exist, or the middleware fails.
    fn connect_service(&self, local: &str, remote: &str) -> Result<(), ConnectionError>;

    /// Asks the supervisor to shut the instance down: for service `kill`, or because a permanent
    /// activity failed.
    ///
    /// The caller is a thread of the instance, so the shutdown must not be waited for here.
    fn kill(&self);
}

/// Why something could not be connected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConnectionError {
    /// The component has no such in port.
    #[error("there is no in port `{0}`")]
    NoSuchInport(String),
    /// There is no such out port.
    #[error("there is no out port `{0}`")]
    NoSuchOutport(String),
    /// The middleware failed.
    #[error("the port cannot be connected: {0}")]
    PortIo(String),
    /// The component has no such remote.
    #[error("there is no remote `{0}`")]
    NoSuchRemote(String),
    /// There is no such service.
    #[error("there is no service `{0}`")]
    NoSuchService(String),
    /// The middleware failed, or the service is another one than the remote expects.
    #[error("the remote cannot be connected: {0}")]
    RemoteIo(String),
}

impl ConnectionError {
    /// Full name of the exception that reports it (genom3.md 4.8).
    #[must_use]
    pub fn exception(&self) -> &'static str {
        match self {
            ConnectionError::NoSuchInport(_) => "::genom::no_such_inport",
            ConnectionError::NoSuchOutport(_) => "::genom::no_such_outport",
            ConnectionError::PortIo(_) => "::genom::port_io",
            ConnectionError::NoSuchRemote(_) => "::genom::no_such_remote",
            ConnectionError::NoSuchService(_) => "::genom::no_such_service",
            ConnectionError::RemoteIo(_) => "::genom::remote_io",
        }
    }
}

/// The inputs of a service with the defaults of the `.gen` filled in (genom3.md 4.10); inputs
/// without a default are zero.
///
/// # Errors
/// A default value that does not fit its parameter.
pub fn input_record(plan: &Plan, service: ServiceIx) -> Result<Option<Record>, JsonError> {
    let Some(compiled) = plan.services().get(service) else { return Ok(None) };
    let mut record = Record::new(&compiled.input);
    for parameter in &plan.component().services[service].parameters {
        let given = parameter.default.as_ref().and_then(|default| default.value.as_ref());
        let is_input = compiled.input.member_index(&parameter.name).is_some();
        if let (Some(value), true) = (given, is_input) {
            let member = Map::from_iter([(parameter.name.clone(), value.clone())]);
            record.merge_json(&Value::Object(member))?;
        }
    }
    Ok(Some(record))
}
