//! A process of a test that is told what to do line by line, such as a peer of another make.
//!
//! Commands and replies are JSON, one line each. A peer that says nothing fails the test: it never
//! waits for ever.

#![allow(clippy::expect_used, clippy::panic, reason = "part of tests: a failed step ends the test")]

use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use serde_json::Value;

/// Only a failing test waits this long.
const WATCHDOG: Duration = Duration::from_secs(60);

/// A running peer; killed when dropped.
#[derive(Debug)]
pub struct Peer {
    child: Child,
    input: ChildStdin,
    lines: Receiver<String>,
}

impl Peer {
    /// Starts it, and waits until it says that it is up.
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
        let peer = Self { child, input, lines };
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
        writeln!(self.input, "{command}").expect("the peer has not ended");
    }

    /// The reply to what it was told.
    ///
    /// # Panics
    /// It replies nothing, or no JSON.
    #[track_caller]
    pub fn reply(&self, to: &str) -> Value {
        match self.lines.recv_timeout(WATCHDOG) {
            Ok(line) => serde_json::from_str(&line).unwrap_or_else(|_| panic!("no JSON: {line}")),
            Err(RecvTimeoutError::Timeout) => panic!("the peer says nothing to {to}"),
            Err(RecvTimeoutError::Disconnected) => panic!("the peer ended at {to}"),
        }
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
