//! A running program whose output is read line by line, under a watchdog.

use std::io::{BufRead as _, BufReader, Read};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::signal;

/// A test step that takes longer counts as hanging.
pub const WATCHDOG: Duration = Duration::from_secs(60);

/// A running program; killed when dropped.
#[derive(Debug)]
pub struct Running {
    child: Child,
    what: String,
    lines: Receiver<String>,
    errors: Option<JoinHandle<String>>,
    /// Lines of standard error, for tests that wait for one.
    error_lines: Receiver<String>,
}

/// A program that has ended.
#[derive(Debug)]
pub struct Finished {
    /// Exit status; `None` if a signal ended it.
    pub code: Option<i32>,
    /// Standard output, without lines that were read before.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Running {
    /// Starts a program.
    #[must_use]
    pub fn start(command: &mut Command) -> Self {
        let what = format!("{command:?}");
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        let (sender, lines) = channel();
        let out = child.stdout.take().expect("piped");
        thread::spawn(move || {
            for line in BufReader::new(out).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        let (sender, error_lines) = channel();
        let err = child.stderr.take().expect("piped");
        let errors = thread::spawn(move || {
            let mut all = String::new();
            let mut reader = BufReader::new(err);
            let mut line = Vec::new();
            while reader.read_until(b'\n', &mut line).is_ok_and(|read| read > 0) {
                let text = String::from_utf8_lossy(&line).into_owned();
                all.push_str(&text);
                // Fails if nobody waits for lines.
                let _ = sender.send(text.trim_end().to_owned());
                line.clear();
            }
            let mut rest = String::new();
            let _ = reader.read_to_string(&mut rest);
            all + &rest
        });
        Self { child, what, lines, errors: Some(errors), error_lines }
    }

    /// Its process id.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Waits for the next line of standard output.
    pub fn line(&self) -> String {
        self.lines.recv_timeout(WATCHDOG).unwrap_or_else(|error| panic!("{}: {error}", self.what))
    }

    /// Discards the lines of standard output that are available now, then waits for the next one.
    pub fn line_from_now(&self) -> String {
        while self.lines.try_recv().is_ok() {}
        self.line()
    }

    /// Waits for the next line of standard output that `wanted` accepts.
    pub fn line_where(&self, wanted: impl Fn(&str) -> bool) -> String {
        let end = Instant::now() + WATCHDOG;
        let mut seen = Vec::new();
        loop {
            match self.lines.recv_timeout(end.saturating_duration_since(Instant::now())) {
                Ok(line) if wanted(&line) => return line,
                Ok(line) => seen.push(line),
                Err(error) => panic!("{}: {error}; lines so far: {seen:#?}", self.what),
            }
        }
    }

    /// Waits for the next line of standard error that `wanted` accepts; `None` if the program ended
    /// first.
    pub fn error_line_where(&self, wanted: impl Fn(&str) -> bool) -> Option<String> {
        self.error_line_within(WATCHDOG, wanted)
            .unwrap_or_else(|()| panic!("{}: says nothing", self.what))
    }

    /// Waits for such a line for a limited time.
    ///
    /// # Errors
    /// Neither the line nor the end came within this time.
    #[allow(clippy::result_unit_err, reason = "there is nothing to say of it")]
    pub fn error_line_within(
        &self,
        longest: Duration,
        wanted: impl Fn(&str) -> bool,
    ) -> Result<Option<String>, ()> {
        let end = Instant::now() + longest;
        loop {
            match self.error_lines.recv_timeout(end.saturating_duration_since(Instant::now())) {
                Ok(line) if wanted(&line) => return Ok(Some(line)),
                Ok(_) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(None),
                Err(RecvTimeoutError::Timeout) => return Err(()),
            }
        }
    }

    /// Sends a signal by its name: `TERM`, `INT`, `KILL`.
    #[track_caller]
    pub fn signal(&self, name: &str) {
        assert!(signal(self.child.id(), name), "{}: could not be signalled", self.what);
    }

    /// Waits for its end.
    #[must_use]
    pub fn finish(self) -> Finished {
        self.finish_within(WATCHDOG)
    }

    /// Waits for its end; fails if it takes longer than `longest`.
    #[must_use]
    pub fn finish_within(self, longest: Duration) -> Finished {
        let what = self.what.clone();
        self.finish_or(longest).unwrap_or_else(|| panic!("{what}: hangs"))
    }

    /// Waits for its end; `None` if it had to be killed after `longest`.
    #[must_use]
    pub fn finish_or(mut self, longest: Duration) -> Option<Finished> {
        let status = self.wait(longest)?;
        let mut out = String::new();
        while let Ok(line) = self.lines.recv_timeout(WATCHDOG) {
            out.push_str(&line);
            out.push('\n');
        }
        let err = self.errors.take().map(|errors| errors.join().unwrap_or_default());
        Some(Finished { code: status.code(), out, err: err.unwrap_or_default() })
    }

    fn wait(&mut self, longest: Duration) -> Option<ExitStatus> {
        let pid = self.child.id();
        let (ended, watched) = channel::<()>();
        // The watchdog kills a hanging program, so that `wait` returns; dropping `ended` stops the
        // watchdog.
        let watchdog = thread::spawn(move || {
            if watched.recv_timeout(longest) == Err(RecvTimeoutError::Timeout) {
                signal(pid, "KILL");
                return true;
            }
            false
        });
        let status = self.child.wait().expect("a child can be waited for");
        drop(ended);
        let hung = watchdog.join().unwrap_or(true);
        (!hung).then_some(status)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Finished {
    /// Fails unless this was the exit status.
    #[track_caller]
    pub fn expect_code(&self, code: i32) -> &Self {
        assert_eq!(self.code, Some(code), "out: {}\nerr: {}", self.out, self.err);
        self
    }

    /// Fails unless standard error contains this text.
    #[track_caller]
    pub fn expect_err(&self, text: &str) -> &Self {
        assert!(self.err.contains(text), "expected `{text}` in:\n{}", self.err);
        self
    }

    /// Fails unless standard output is exactly this text.
    #[track_caller]
    pub fn expect_out(&self, text: &str) -> &Self {
        assert_eq!(self.out, text, "err: {}", self.err);
        self
    }
}
