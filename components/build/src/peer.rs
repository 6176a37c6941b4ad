//! Child processes that tests control line by line, such as peers that are not genomd.
//!
//! [`Lines`] exchanges any lines; a [`Peer`] exchanges commands and replies as JSON, one per line.
//! If a process does not answer, the test fails under a watchdog.

#![allow(clippy::expect_used, clippy::panic, reason = "part of tests: a failed step ends the test")]

use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use serde_json::Value;

/// Only a failing test waits this long.
const WATCHDOG: Duration = Duration::from_secs(60);

/// A running process; killed when dropped.
#[derive(Debug)]
pub struct Lines {
    child: Child,
    input: ChildStdin,
    lines: Receiver<String>,
}

impl Lines {
    /// Starts the process.
    ///
    /// # Panics
    /// The process cannot be started.
    #[must_use]
    #[track_caller]
    pub fn start(command: &mut Command) -> Self {
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("{command:?}: {error}"));
        let output = BufReader::new(child.stdout.take().expect("it is piped"));
        let input = child.stdin.take().expect("it is piped");
        let (sender, lines) = channel();
        thread::spawn(move || {
            output.lines().map_while(Result::ok).try_for_each(|line| sender.send(line))
        });
        Self { child, input, lines }
    }

    /// Sends a line.
    ///
    /// # Panics
    /// The process has ended.
    #[track_caller]
    pub fn tell(&mut self, line: &str) {
        writeln!(self.input, "{line}").expect("the peer has not ended");
    }

    /// Waits for the next line; `to` names what it answers, for the message of the panic.
    ///
    /// # Panics
    /// No line arrives in time.
    #[track_caller]
    pub fn line(&self, to: &str) -> String {
        match self.lines.recv_timeout(WATCHDOG) {
            Ok(line) => line,
            Err(RecvTimeoutError::Timeout) => panic!("the peer says nothing to {to}"),
            Err(RecvTimeoutError::Disconnected) => panic!("the peer ended at {to}"),
        }
    }

    /// The next line, if one has arrived already.
    #[must_use]
    pub fn heard(&self) -> Option<String> {
        self.lines.try_recv().ok()
    }

    /// Checks that the next line is `expected`.
    ///
    /// # Panics
    /// Another line arrives, or none.
    #[track_caller]
    pub fn says(&self, expected: &str) {
        assert_eq!(self.line(expected), expected);
    }
}

impl Drop for Lines {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A process that replies to commands.
#[derive(Debug)]
pub struct Peer(Lines);

impl Peer {
    /// Starts the process, and waits until it reports that it is ready.
    ///
    /// # Panics
    /// The process cannot be started.
    #[must_use]
    #[track_caller]
    pub fn start(command: &mut Command) -> Self {
        let peer = Self(Lines::start(command));
        assert_eq!(peer.reply("its start"), "up");
        peer
    }

    /// Sends a command and waits for its reply.
    ///
    /// # Panics
    /// There is no reply, or it is not JSON.
    #[track_caller]
    pub fn ask(&mut self, command: &Value) -> Value {
        self.tell(command);
        self.reply(&command.to_string())
    }

    /// Sends a command whose reply is read later with [`Peer::reply`].
    ///
    /// # Panics
    /// The process has ended.
    #[track_caller]
    pub fn tell(&mut self, command: &Value) {
        self.0.tell(&command.to_string());
    }

    /// Waits for the reply to a command.
    ///
    /// # Panics
    /// There is no reply, or it is not JSON.
    #[track_caller]
    pub fn reply(&self, to: &str) -> Value {
        let line = self.0.line(to);
        serde_json::from_str(&line).unwrap_or_else(|_| panic!("no JSON: {line}"))
    }
}
