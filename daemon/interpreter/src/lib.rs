//! The interpreter of this process, if it is one that runs scripts: what the host asks of it, and
//! where the two meet.

#![forbid(unsafe_code)]

mod given;

pub use given::Given;

use std::path::PathBuf;
use std::sync::OnceLock;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use genom_description::model::Span;
use genom_elf::Contents;
use genom_runtime::plan::Plan;

/// Makes C functions of the codels in a script.
pub trait Interpreter: Send + Sync {
    /// The language of its scripts, as in `lang`.
    fn language(&self) -> &str;

    /// Runs the text of a script, which may take so long, and compares its functions with the codels
    /// of the plan: their names, their parameters, and what they can be seen to return.
    ///
    /// # Errors
    /// All that is wrong, as sentences with the places in the description and in the script.
    fn load(
        &self,
        script: &Contents,
        plan: &Plan,
        within: Duration,
        locate: &dyn Fn(Span) -> String,
    ) -> Result<Given, Vec<String>>;

    /// Directories that it reads, also later on.
    fn reads(&self) -> Vec<PathBuf>;

    /// Tells in the log at which lines this codel is. Waits for code that keeps the interpreter.
    fn tell_where(&self, codel: &str);
}

static OWN: OnceLock<Box<dyn Interpreter>> = OnceLock::new();

/// Says that this process is an interpreter; the first one counts.
pub fn set(interpreter: Box<dyn Interpreter>) {
    let _ = OWN.set(interpreter);
}

/// Whether this process can load scripts.
#[must_use]
pub fn is_there() -> bool {
    OWN.get().is_some()
}

/// Directories that the interpreter of this process reads; none without one.
#[must_use]
pub fn reads() -> Vec<PathBuf> {
    OWN.get().map(|one| one.reads()).unwrap_or_default()
}

/// The interpreter of this process.
#[must_use]
pub fn own() -> Option<&'static dyn Interpreter> {
    OWN.get().map(Box::as_ref)
}

/// How long code may keep the interpreter before that is told.
const KEPT: Duration = Duration::from_secs(1);

/// Tells in the log where a codel is that has not returned, if it is one of a script; does not wait.
pub fn tell_where(codel: &str) {
    let Some(interpreter) = own() else { return };
    let (codel, (done, told)) = (codel.to_owned(), channel::<()>());
    let asked = codel.clone();
    let asks = move || {
        interpreter.tell_where(&asked);
        drop(done);
    };
    let waits = move || {
        if told.recv_timeout(KEPT) == Err(RecvTimeoutError::Timeout) {
            tracing::warn!(
                "codel {codel}: native code keeps the interpreter (its global lock), so the lines \
                 where it is are not known"
            );
        }
    };
    // Of a process that can start no thread, it is not told.
    let _ = thread::Builder::new().name("genomd-where".to_owned()).spawn(asks);
    let _ = thread::Builder::new().name("genomd-where".to_owned()).spawn(waits);
}
