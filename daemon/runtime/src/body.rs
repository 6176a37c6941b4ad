//! What the runtime needs of a component's code and memory.
//!
//! The host implements it over a loaded library; tests implement it over closures. The runtime
//! guarantees the exclusion rules (genom3.md 4.5): while it calls a codel or a transfer, nothing
//! that conflicts runs, and one frame is used by one thread at a time.

use genom_description::model::{Owner, PortIx};
use genom_middleware::{Publisher, Subscription};
use genom_types::Record;
use serde_json::Value;

/// An event by its rank in [`Plan::events`](crate::plan::Plan::events): a state, a paused state
/// or an exception, by full name (`::demo::main`, `::demo::pause::main`, `::demo::SERVO_ERROR`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EventId(pub u16);

/// What a codel returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Returned {
    /// `genom_ok`.
    Ok,
    /// An event of the plan.
    Event(EventId),
    /// A string the plan does not know; [`Frame::returned`] tells it.
    Unknown,
    /// The codel did not return: a C++ exception escaped, or an argument has no place. This is
    /// `genom::unkex`, with what [`Frame::detail`] tells.
    Failed,
}

/// One instance's code and memory.
pub trait Body: Send + Sync {
    /// Makes the memory for one run of a service, or of a task's permanent activity.
    fn frame(&self, owner: Owner) -> Box<dyn Frame>;

    /// Gives an out port (or one element of a multiple one) its publisher, or takes it away.
    ///
    /// Called with all codels excluded.
    fn bind_out(&self, port: PortIx, element: Option<&str>, publisher: Option<Box<dyn Publisher>>);

    /// Connects an in port (or one element of a multiple one), or disconnects it.
    ///
    /// Called with all codels excluded (genom3.md 7.8).
    fn bind_in(
        &self,
        port: PortIx,
        element: Option<&str>,
        subscription: Option<Box<dyn Subscription>>,
    );

    /// Connects a remote, or disconnects it. Called with all codels excluded.
    fn bind_remote(&self, remote: usize, call: Option<Box<dyn RemoteCall>>);

    /// How a codel's `open(id)` on a multiple out port gets its publisher.
    fn set_opener(&self, opener: Box<dyn Opener>);

    /// Last value written (out) or read (in) by the codels; `None` before the first.
    ///
    /// Safe at any time: the body keeps a copy that it exchanges without blocking codels.
    fn port_value(&self, port: PortIx, element: Option<&str>) -> Option<Value>;

    /// The same, bit by bit; `None` also when no copy of the last value was kept, as of large ones
    /// that nobody looks at.
    fn last_value(&self, port: PortIx, element: Option<&str>) -> Option<Record> {
        let _ = (port, element);
        None
    }

    /// The same as a CDR message; `None` also of what cannot be one.
    fn port_message(&self, port: PortIx, element: Option<&str>) -> Option<Vec<u8>> {
        let _ = (port, element);
        None
    }

    /// Where codels wrote past the memory they were given, in words, once that was found.
    fn damage(&self) -> Option<String> {
        None
    }

    /// Publishes `value` on an out port that no codel writes, such as `genom_state`.
    fn write_port(&self, port: PortIx, value: &Record);
}

/// An element of a multiple out port could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum ElementError {
    /// The component has no such port, or one without a type.
    #[error("{instance} has no port number {port}")]
    NoSuchPort {
        /// The component.
        instance: String,
        /// What was asked for.
        port: PortIx,
    },
    /// A part of the name is empty.
    #[error("`{element}` cannot name an element of {port}")]
    Name {
        /// The name that was given.
        element: String,
        /// Of which port.
        port: String,
    },
    /// A middleware of the port is not there, or refused.
    #[error(transparent)]
    Open(Box<dyn std::error::Error + Send + Sync>),
}

/// Opens publishers for elements of multiple out ports, on behalf of codels.
pub trait Opener: Send + Sync {
    /// A publisher for element `element` of `port`.
    ///
    /// # Errors
    /// The port is none, the element cannot have such a name, or no middleware takes it.
    fn open(&self, port: PortIx, element: &str) -> Result<Box<dyn Publisher>, ElementError>;

    /// The component closed an element; its publisher is gone.
    fn close(&self, port: PortIx, element: &str);
}

/// Calls a service of another component, for a codel that waits.
pub trait RemoteCall: Send {
    /// Sends `input`, waits, and fills `output`; on an exception its name and detail come back.
    ///
    /// # Errors
    /// The exception the service ended with, or one that says why it could not be reached.
    fn call(&mut self, input: &Record, output: &mut Record) -> Result<(), (String, Value)>;
}

/// Parameters and locals of one run of a service, with its codels bound to them.
pub trait Frame: Send {
    /// Takes the request's inputs (a record of the service's input struct), copies `inout`
    /// parameters to the outputs, and clears outputs and locals (genom3.md 7.3.4).
    fn begin(&mut self, input: &Record);

    /// Copies the `in` and `inout` parameters of an attribute (or of a service of the papers'
    /// dialects) into the IDS (genom3.md 7.3.6).
    fn store(&mut self);

    /// Copies the `out` and `inout` parameters from the IDS to the outputs.
    fn fetch(&mut self);

    /// Copies what the IDS hold in the places of the `in` and `inout` parameters of an attribute
    /// into a record of its inputs. Bodies without IDS have nothing to copy.
    fn current(&mut self, _inputs: &mut Record) {}

    /// Calls the codel with this index in [`Component::codels`](genom_description::model::Component::codels).
    ///
    /// `context` is the rank of the `genom_context` to give it (genom3.md 5.4): below the number
    /// of tasks, the task's own; from there to [`Plan::contexts`](crate::plan::Plan::contexts),
    /// one for each control worker, because requests that do not conflict are served side by
    /// side. One context is used by one thread at a time.
    fn call(&mut self, codel: usize, context: usize) -> Returned;

    /// Full name of what the last call returned when it was [`Returned::Unknown`].
    fn returned(&self) -> String;

    /// Detail the last call raised with its exception, as JSON; `None` when it has none.
    ///
    /// The runtime may ask later and on another thread than the call's: keep it in the frame.
    fn detail(&self) -> Option<Value>;

    /// The outputs: a record of the service's output struct.
    fn output(&self) -> &Record;
}
