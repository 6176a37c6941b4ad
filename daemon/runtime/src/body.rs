//! A component's code and memory, as the runtime uses them.
//!
//! The host implements these traits with a loaded library; tests implement them with closures. The
//! runtime guarantees the exclusion rules (genom3.md 4.5): while it calls a codel or a transfer,
//! nothing that conflicts with it runs, and one frame is used by one thread at a time.

use genom_description::model::{CodelIx, Owner, PortIx, RemoteIx};
use genom_middleware::{Publisher, Subscription};
use genom_types::Record;
use serde_json::Value;

/// Index of an event in [`Plan::events`](crate::plan::Plan::events): a state, a paused state or an
/// exception, by full name (`::demo::main`, `::demo::pause::main`, `::demo::SERVO_ERROR`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EventId(pub u16);

/// What a codel returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Returned {
    /// `genom_ok`.
    Ok,
    /// An event of the plan.
    Event(EventId),
    /// A string that is not an event of the plan; [`Frame::returned`] gives it.
    Unknown,
    /// The codel did not return: a C++ exception left it, or there was no address for an argument.
    /// Reported as `genom::unkex` with [`Frame::detail`].
    Failed,
}

/// One instance's code and memory.
pub trait Body: Send + Sync {
    /// Makes the memory for one run of a service, or of a task's permanent activity.
    fn frame(&self, owner: Owner) -> Box<dyn Frame>;

    /// Sets the publisher of an out port (or of an element of a multiple one), or removes it.
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
    fn bind_remote(&self, remote: RemoteIx, call: Option<Box<dyn RemoteCall>>);

    /// Sets what opens a publisher when a codel calls `open(id)` on a multiple out port.
    fn set_opener(&self, opener: Box<dyn Opener>);

    /// Last value that codels wrote (out port) or read (in port), as JSON; `None` before the first.
    ///
    /// May be called at any time: the body keeps a copy, which it exchanges without blocking
    /// codels.
    fn port_value(&self, port: PortIx, element: Option<&str>) -> Option<Value>;

    /// The last value as a record, bit by bit; `None` also when no copy was kept, as for large
    /// values while nobody asks for them.
    fn last_value(&self, port: PortIx, element: Option<&str>) -> Option<Record> {
        let _ = (port, element);
        None
    }

    /// The last value as a CDR message; `None` also when its type has no CDR form.
    fn port_message(&self, port: PortIx, element: Option<&str>) -> Option<Vec<u8>> {
        let _ = (port, element);
        None
    }

    /// How many values codels have written on an out port so far. Called by the thread that has just
    /// run one.
    fn written(&self, port: PortIx) -> u64 {
        let _ = port;
        0
    }

    /// A description of where codels wrote past their memory, if that was detected.
    fn damage(&self) -> Option<String> {
        None
    }

    /// A copy of the IDS; `None` without. Called with all codels excluded.
    fn ids(&self) -> Option<Record> {
        None
    }

    /// Sets the IDS to a record of their type. Called with all codels excluded.
    fn set_ids(&self, ids: &Record) {
        let _ = ids;
    }

    /// Puts back the last value of a port: an out port publishes it, an in port shows it as what
    /// was read last. Called with all codels excluded.
    fn restore_port(&self, port: PortIx, element: Option<&str>, value: &Record) {
        let _ = (port, element, value);
    }

    /// Publishes `value` on an out port that the runtime writes, such as `genom_state`.
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
        /// The requested port.
        port: PortIx,
    },
    /// A part of the name is empty.
    #[error("`{element}` cannot name an element of {port}")]
    Name {
        /// The requested name.
        element: String,
        /// The port.
        port: String,
    },
    /// A middleware of the port is not available, or refused.
    #[error(transparent)]
    Open(Box<dyn std::error::Error + Send + Sync>),
}

/// Opens publishers for elements of multiple out ports when codels ask for them.
pub trait Opener: Send + Sync {
    /// A publisher for element `element` of `port`.
    ///
    /// # Errors
    /// There is no such port, the name is not allowed, or no middleware accepts the element.
    fn open(&self, port: PortIx, element: &str) -> Result<Box<dyn Publisher>, ElementError>;

    /// The codel closed an element, and its publisher was dropped.
    fn close(&self, port: PortIx, element: &str);
}

/// Calls a service of another component, on behalf of a codel that waits for it.
pub trait RemoteCall: Send {
    /// Sends `input`, waits, and fills `output`. An exception is returned as its name and detail.
    ///
    /// # Errors
    /// The exception that the service ended with, or one that says why it could not be called.
    fn call(&mut self, input: &Record, output: &mut Record) -> Result<(), (String, Value)>;
}

/// The records of one run of a service.
#[derive(Clone, Debug)]
pub struct Memory {
    /// The `in` and `inout` parameters, as requested.
    pub input: Record,
    /// The `out` and `inout` parameters.
    pub output: Record,
    /// The local variables.
    pub local: Record,
}

/// Parameters and locals of one run of a service, with its codels bound to them.
pub trait Frame: Send {
    /// Takes the inputs of a request (a record of the service's input struct), copies `inout`
    /// parameters to the outputs, and clears outputs and locals (genom3.md 7.3.4).
    fn begin(&mut self, input: &Record);

    /// Takes the number of the activity that this run is, from 1 on. A body that does not tell it
    /// in a report ignores it.
    fn number(&mut self, _activity: u32) {}

    /// Copies the `in` and `inout` parameters of an attribute (or of a service of the papers'
    /// dialects) into the IDS (genom3.md 7.3.6).
    fn store(&mut self);

    /// Copies the `out` and `inout` parameters from the IDS to the outputs.
    fn fetch(&mut self);

    /// A copy of its records; `None` if it has none. Not called while a codel of it runs.
    fn save(&self) -> Option<Memory> {
        None
    }

    /// Sets its records, in place of [`begin`](Self::begin). Values of another type are ignored.
    fn restore(&mut self, memory: &Memory) {
        let _ = memory;
    }

    /// Copies the values that the IDS hold for the `in` and `inout` parameters of an attribute into
    /// a record of its inputs. A body without IDS copies nothing.
    fn current(&mut self, _inputs: &mut Record) {}

    /// Calls a codel of the service.
    ///
    /// `context` is the index of the `genom_context` to pass (genom3.md 5.4). Indices below the
    /// number of tasks are those of the tasks; the others, up to
    /// [`Plan::contexts`](crate::plan::Plan::contexts), are those of the control workers, which
    /// serve requests in parallel if they do not conflict. One context is used by one thread at a
    /// time.
    fn call(&mut self, codel: CodelIx, context: usize) -> Returned;

    /// Full name of what the last call returned, if it was [`Returned::Unknown`].
    fn returned(&self) -> String;

    /// Detail of the exception that the last call returned, as JSON; `None` if it has none.
    ///
    /// May be called later and on another thread than the codel was: keep it in the frame.
    fn detail(&self) -> Option<Value>;

    /// The outputs: a record of the service's output struct.
    fn output(&self) -> &Record;
}
