//! A process of a test that is told what to do line by line, such as a peer of another make.
//!
//! [`Lines`] are any lines; of a [`Peer`], commands and replies are JSON, one line each. A process
//! that says nothing fails the test: it never waits for ever.

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
    /// Starts it.
    ///
    /// # Panics
    /// It does not start.
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

    /// Tells it a line.
    ///
    /// # Panics
    /// It has ended.
    #[track_caller]
    pub fn tell(&mut self, line: &str) {
        writeln!(self.input, "{line}").expect("the peer has not ended");
    }

    /// The next line it says; `to` what, for the message when it says nothing.
    ///
    /// # Panics
    /// It says nothing.
    #[track_caller]
    pub fn line(&self, to: &str) -> String {
        match self.lines.recv_timeout(WATCHDOG) {
            Ok(line) => line,
            Err(RecvTimeoutError::Timeout) => panic!("the peer says nothing to {to}"),
            Err(RecvTimeoutError::Disconnected) => panic!("the peer ended at {to}"),
        }
    }

    /// The next line it says, if it has said one already.
    #[must_use]
    pub fn heard(&self) -> Option<String> {
        self.lines.try_recv().ok()
    }

    /// It says this line next.
    ///
    /// # Panics
    /// It says another one, or nothing.
    #[track_caller]
    pub fn says(&self, expected: &str) {
        assert_eq!(self.line(expected), expected);
    }
}

impl Drop for Lines {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A process that takes commands and replies to each.
#[derive(Debug)]
pub struct Peer(Lines);

impl Peer {
    /// Starts it, and waits until it says that it is up.
    ///
    /// # Panics
    /// It does not start.
    #[must_use]
    #[track_caller]
    pub fn start(command: &mut Command) -> Self {
        let peer = Self(Lines::start(command));
        assert_eq!(peer.reply("its start"), "up");
        peer
    }

    /// Has it do something; what it replies.
    ///
    /// # Panics
    /// It replies nothing, or no JSON.
    #[track_caller]
    pub fn ask(&mut self, command: &Value) -> Value {
        self.tell(command);
        self.reply(&command.to_string())
    }

    /// Has it do something whose reply is taken later, with [`Peer::reply`].
    ///
    /// # Panics
    /// It has ended.
    #[track_caller]
    pub fn tell(&mut self, command: &Value) {
        self.0.tell(&command.to_string());
    }

    /// The reply to what it was told.
    ///
    /// # Panics
    /// It replies nothing, or no JSON.
    #[track_caller]
    pub fn reply(&self, to: &str) -> Value {
        let line = self.0.line(to);
        serde_json::from_str(&line).unwrap_or_else(|_| panic!("no JSON: {line}"))
    }
}
