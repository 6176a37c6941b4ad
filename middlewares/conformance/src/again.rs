//! Starts the test program again as another process, for tests that kill one.

use std::process::Command;

/// The command that runs one test of this test program in a separate process.
///
/// That test is marked `#[ignore]`, so that it does not run with the others, and does nothing
/// unless environment variables tell it what to do:
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
/// When the path of the running program is unknown.
#[must_use]
pub fn again(test: &str) -> Command {
    let program = std::env::current_exe().expect("the path of this program");
    let mut command = Command::new(program);
    // With a single thread, the harness would print on the same line as the test's first output.
    command.args(["--exact", test, "--ignored", "--nocapture", "--test-threads=2"]);
    command
}
