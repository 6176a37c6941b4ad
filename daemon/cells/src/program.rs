//! What the process of a cell runs: the daemon's own program, or the interpreter of its codels, which
//! loads the same as a library.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use genom_configuration::LoadRequest;
use genom_supervisor::loading::names_script;
use tokio::task::spawn_blocking;

use crate::end::End;
use crate::place::Place;

/// The daemon as a library that an interpreter loads.
const RUNTIME: &str = "libgenom_python.so";

/// The variable by which the package `genom` finds it.
const VARIABLE: &str = "GENOM_RUNTIME";

/// Runs the daemon in an interpreter of Python: arguments to it are those of `genomd`.
#[must_use]
pub fn in_python(interpreter: &OsStr) -> Command {
    let mut command = Command::new(interpreter);
    command.args(["-m", "genom.runner"]);
    // One that is set already is used instead.
    if let Some(runtime) = runtime().filter(|_| std::env::var_os(VARIABLE).is_none()) {
        command.env(VARIABLE, runtime);
    }
    command
}

/// Beside the program, or where packages of genomd install it.
fn runtime() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let directory = program.parent()?;
    let installed = directory.join("../lib/genomd").join(RUNTIME);
    [directory.join(RUNTIME), installed].into_iter().find(|file| file.is_file())
}

/// Why an interpreter that ended at once cannot run codels: it lacks the package `genom`, or does not
/// see it. Waits until it has looked.
#[must_use]
pub fn lacks_package(interpreter: &OsStr) -> Option<String> {
    let mut command = Command::new(interpreter);
    let tried = command.args(["-c", "import genom.runner"]).stdin(Stdio::null()).output().ok()?;
    let lacks = String::from_utf8_lossy(&tried.stderr).contains("No module named 'genom");
    lacks.then(|| {
        format!(
            "codels in Python run in `{}`, which has no package genom {}: install it there, or \
             name another interpreter with cells.python (docs/python.md)",
            interpreter.display(),
            env!("CARGO_PKG_VERSION")
        )
    })
}

/// Why a process that was never ready refused to run, if it did.
pub(crate) async fn refusal(place: &Place, end: &End) -> Option<String> {
    if let Some(why) = place.taken_refusal() {
        return Some(why);
    }
    let interpreter = place.interpreter().filter(|_| *end == End::Exited(1))?;
    spawn_blocking(move || lacks_package(&interpreter)).await.ok().flatten()
}

/// Gives each component with codels in Python that names no cell one of its own: other components
/// never wait for its interpreter.
pub fn isolate_scripts<'a>(
    requests: impl IntoIterator<Item = &'a mut LoadRequest>,
    path: &[PathBuf],
) {
    for request in requests {
        if request.cell.is_none() && names_script(request, path) {
            request.cell = Some(request.instance());
        }
    }
}
