//! Another process, for tests that kill one: their own program once more.

use std::process::Command;

/// The command that runs one test of this test program in a process of its own.
///
/// The test is marked `#[ignore]`, so that it does not run with the others, and does nothing when
/// it is not told by a variable of its environment what it is to do:
///
/// ```no_run
/// let mut peer = genom_conformance::again("writes_until_it_is_killed")
///     .env("MY_WRITER_PLACE", "/tmp/here")
///     .stdin(std::process::Stdio::piped())
///     .spawn()?;
/// peer.kill()?;
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Panics
/// When the system does not say which program this is.
#[must_use]
pub fn again(test: &str) -> Command {
    let program = std::env::current_exe().expect("the path of this program");
    let mut command = Command::new(program);
    // With one thread, the harness would put its words on the line of the first output.
    command.args(["--exact", test, "--ignored", "--nocapture", "--test-threads=2"]);
    command
}
