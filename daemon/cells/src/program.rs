//! What the process of a cell runs: the daemon's own program, or the runner of its codels, which loads
//! the same as a library.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use genom_configuration::LoadRequest;
use genom_supervisor::loading::names_script;
use tokio::task::spawn_blocking;

use crate::end::End;
use crate::place::Place;

/// The daemon as a library that a runner loads.
const RUNTIME: &str = "libgenom_runner.so";

/// The variable by which a runner finds it.
const VARIABLE: &str = "GENOM_RUNTIME";

/// Runs the daemon in a runner, given by its command: arguments to it are those of `genomd`.
#[must_use]
pub fn in_runner<W: Into<OsString> + Clone>(words: &[W]) -> Command {
    let mut words = words.iter().cloned().map(Into::into);
    let program: OsString = words.next().unwrap_or_default();
    // One that comes with the daemon stands beside it.
    let own = (program == OWN).then(|| with_daemon(OWN)).flatten();
    let mut command = Command::new(own.map_or(program, PathBuf::into_os_string));
    command.args(words);
    // One that is set already is used instead.
    if let Some(runtime) = with_daemon(RUNTIME).filter(|_| std::env::var_os(VARIABLE).is_none()) {
        command.env(VARIABLE, runtime);
    }
    command
}

/// The runner that comes with the daemon.
const OWN: &str = "genom-lua";

/// A file beside the program, or where packages of genomd install it.
fn with_daemon(name: &str) -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let directory = program.parent()?;
    let installed = directory.join("../lib/genomd").join(name);
    [directory.join(name), installed].into_iter().find(|file| file.is_file())
}

/// Why an interpreter of Python that ended at once cannot run codels: it lacks the package `genom`, or
/// does not see it. Waits until it has looked. `None` for other runners.
#[must_use]
pub fn lacks_package<W: Into<OsString> + Clone>(words: &[W]) -> Option<String> {
    let words: Vec<OsString> = words.iter().cloned().map(Into::into).collect();
    let (interpreter, runner) = words.split_first()?;
    if runner != ["-m", "genom.runner"] {
        return None;
    }
    let mut command = Command::new(interpreter);
    let tried = command.args(["-c", "import genom.runner"]).stdin(Stdio::null()).output().ok()?;
    let lacks = String::from_utf8_lossy(&tried.stderr).contains("No module named 'genom");
    lacks.then(|| {
        format!(
            "codels in Python run in `{}`, which has no package genom {}: install it there, or \
             name another interpreter with cells.python (docs/python.md)",
            Path::new(interpreter).display(),
            env!("CARGO_PKG_VERSION")
        )
    })
}

/// Why a process that was never ready refused to run, if it did.
pub(crate) async fn refusal(place: &Place, end: &End) -> Option<String> {
    if let Some(why) = place.taken_refusal() {
        return Some(why);
    }
    let runner = place.runner().filter(|_| *end == End::Exited(1))?;
    spawn_blocking(move || lacks_package(&runner)).await.ok().flatten()
}

/// Gives each component with codels in a script that names no cell one of its own: other components
/// never wait for its interpreter.
pub fn isolate_scripts<'a>(
    requests: impl IntoIterator<Item = &'a mut LoadRequest>,
    path: &[PathBuf],
) {
    for request in requests {
        if request.cell.is_none() && names_script(request, path).is_some() {
            request.cell = Some(request.instance());
        }
    }
}
