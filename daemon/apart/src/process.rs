//! A daemon, or another program, that is started and ended.

use std::fs::{self, File};
use std::io;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::process::{Pid, PidfdFlags, Signal, kill_process, pidfd_open};

/// How long a daemon may take to stop, beyond what its components may.
const STOPPING: Duration = Duration::from_secs(20);

/// A program that was started; ended when dropped.
#[derive(Debug)]
pub struct Program {
    child: Child,
    log: PathBuf,
}

impl Program {
    /// Starts a program with its output in a file. Signals of the terminal do not reach it.
    ///
    /// # Errors
    /// It cannot be started.
    pub fn start(program: &Path, arguments: &[&str], log: &Path) -> io::Result<Self> {
        let file = File::create(log)?;
        let mut command = Command::new(program);
        command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(file);
        let child = command.process_group(0).spawn()?;
        Ok(Self { child, log: log.to_owned() })
    }

    /// Its process.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Why it ended, if it did: its error message, else the last thing that it logged.
    pub fn ended(&mut self) -> Option<String> {
        let status = self.child.try_wait().ok()??;
        let log = fs::read_to_string(&self.log).unwrap_or_default();
        let lines: Vec<String> = log.lines().map(|line| plain(line).trim().to_owned()).collect();
        let error = lines.iter().find_map(|line| line.strip_prefix("error: "));
        let last = || lines.iter().rev().find(|line| !line.is_empty()).map(String::as_str);
        Some(error.or_else(last).map_or_else(|| status.to_string(), str::to_owned))
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let pid = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw);
        // It is not waited for yet, so that its number is no other process's.
        if let (Some(pid), Ok(None)) = (pid, self.child.try_wait()) {
            let _ = kill_process(pid, Signal::TERM);
        }
        end_within(&mut self.child, STOPPING);
    }
}

/// Waits for the end of a process that was asked to end; after so long it is killed.
pub fn end_within(child: &mut Child, time: Duration) {
    if let Ok(None) = child.try_wait()
        && !matches!(ends_within(Pid::from_child(child), time), Ok(true))
    {
        let _ = child.kill();
    }
    let _ = child.wait();
}

/// Whether a process ends within this time; it was not waited for yet.
fn ends_within(process: Pid, time: Duration) -> io::Result<bool> {
    let process = pidfd_open(process, PidfdFlags::empty())?;
    let end = Instant::now() + time;
    loop {
        let left = end.saturating_duration_since(Instant::now());
        let left = Timespec::try_from(left).map_err(io::Error::other)?;
        match poll(&mut [PollFd::new(&process, PollFlags::IN)], Some(&left)) {
            Err(Errno::INTR) => {}
            ended => return Ok(ended? > 0),
        }
    }
}

/// A line without the escape sequences of colours.
fn plain(line: &str) -> String {
    let mut text = String::new();
    let mut rest = line.chars();
    while let Some(c) = rest.next() {
        if c == '\u{1b}' {
            let _ = rest.by_ref().find(char::is_ascii_alphabetic);
        } else {
            text.push(c);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;

    #[test]
    fn a_program_that_ends_tells_why_by_its_error_or_last_line() {
        let made = tempfile::tempdir().unwrap();
        for (script, expected) in [
            ("printf '\\033[31mrefused\\033[0m: no\\n\\n' >&2; exit 1", "refused: no"),
            ("printf 'error: no\\nhelp: try again\\n' >&2; exit 1", "no"),
            ("exit 7", "exit status: 7"),
        ] {
            let log = made.path().join("log");
            let mut program = Program::start(Path::new("/bin/sh"), &["-c", script], &log).unwrap();
            let end = Instant::now() + Duration::from_secs(60);
            let told = loop {
                match program.ended() {
                    None if Instant::now() < end => thread::yield_now(),
                    told => break told,
                }
            };
            assert_eq!(told.as_deref(), Some(expected));
        }
    }

    #[test]
    fn a_program_is_asked_to_end_when_nobody_needs_it() {
        let made = tempfile::tempdir().unwrap();
        let done = made.path().join("done");
        let script = format!(
            "trap 'touch {0}; exit' TERM; touch {0}.begun; while :; do sleep 0.01; done",
            done.display()
        );
        let log = made.path().join("log");
        let program = Program::start(Path::new("/bin/sh"), &["-c", &script], &log).unwrap();
        let end = Instant::now() + Duration::from_secs(60);
        while !made.path().join("done.begun").exists() && Instant::now() < end {
            thread::yield_now();
        }
        drop(program);
        assert!(done.exists());
    }
}
