//! Another process, controlled by lines of text.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

use super::ShmWorld;

/// Starts each line of the writer, because the test harness in that process prints lines of its
/// own.
pub(crate) const MARK: &str = "> ";

/// Environment variables that tell the writer prefix and root.
pub(crate) const PREFIX: &str = "GENOM_SHM_WRITER_PREFIX";
pub(crate) const ROOT: &str = "GENOM_SHM_WRITER_ROOT";

/// The test, in each program that starts a [writer](Process::writer), that acts as the writer.
const WRITER: &str = "writes_until_it_is_killed";

/// A process that takes longer counts as hanging.
const WATCHDOG: Duration = Duration::from_secs(60);

pub(crate) struct Process {
    child: Child,
    input: Option<ChildStdin>,
    lines: Receiver<String>,
}

impl Process {
    /// Starts a program with prefix, root and further arguments.
    pub(crate) fn start(program: &str, world: &ShmWorld, arguments: &[&str]) -> Self {
        let mut command = Command::new(program);
        Self::run(command.arg(world.prefix()).arg(world.root()).args(arguments), "")
    }

    /// Starts this test program again as the [writer](super::writer).
    pub(crate) fn writer(world: &ShmWorld) -> Self {
        let mut command = genom_conformance::again(WRITER);
        Self::run(command.env(PREFIX, world.prefix()).env(ROOT, world.root()), MARK)
    }

    fn run(command: &mut Command, mark: &'static str) -> Self {
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the process starts");
        let output = BufReader::new(child.stdout.take().expect("its output"));
        let (send, lines) = channel();
        thread::spawn(move || {
            let lines = output.lines().map_while(Result::ok);
            let mut said = lines.filter_map(|line| line.strip_prefix(mark).map(str::to_owned));
            said.try_for_each(|line| send.send(line))
        });
        Self { input: child.stdin.take(), child, lines }
    }

    /// The next line that it prints.
    pub(crate) fn says(&self) -> String {
        self.lines.recv_timeout(WATCHDOG).expect("the process says something")
    }

    /// Sends it a line.
    pub(crate) fn tell(&mut self, line: &str) {
        let input = self.input.as_mut().expect("its input");
        writeln!(input, "{line}").expect("the process listens");
    }

    /// Kills it with SIGKILL.
    pub(crate) fn kill(mut self) {
        self.child.kill().expect("killed");
        self.child.wait().expect("ended");
    }

    /// Closes its input and waits for it to end.
    pub(crate) fn end(mut self) {
        drop(self.input.take());
        assert!(self.child.wait().expect("ended").success());
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
