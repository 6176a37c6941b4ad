//! What misbehaving codels can do to the process that they share, as a table: which component does
//! it, in which service, and what must happen.
//!
//! Each row is a codel of `components/faults`. To try one, start a daemon with the demo, load
//! `row.component`, call `row.service` and wait for it to end: [`Fault::provoke`] does everything
//! but the first step and returns what happened. The tests (`tests/all/components/table.rs`)
//! compare that with `row.outcome`, `row.told` and `row.stays`; `cargo faults` prints the same rows
//! as a table for any backend.

use std::fmt;

use crate::{Daemon, component, path};

/// A misbehaviour and its expected effects.
#[derive(Clone, Copy, Debug)]
pub struct Fault {
    /// What the codel does; completes "a codel ...".
    pub what: &'static str,
    /// Folder of the component in `components/faults`.
    pub component: &'static str,
    /// The service that misbehaves. None needs inputs without a default.
    pub service: &'static str,
    /// Effect on the service and the daemon.
    pub outcome: Outcome,
    /// Part of the daemon's message on standard error; empty if there must be none.
    pub told: &'static str,
    /// Whether the library stays mapped after the component is unloaded.
    pub stays: bool,
}

/// Effect of a misbehaving service on itself and on its daemon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The service succeeds, and everything continues.
    GoesOn,
    /// The service ends with this exception, and everything else continues.
    Exception(&'static str),
    /// The daemon stops its components and ends with this status.
    Stops(i32),
    /// The daemon ends at once with this status; `None`: by a signal.
    Ends(Option<i32>),
}

impl Outcome {
    /// Whether the daemon and its other components continue.
    #[must_use]
    pub fn goes_on(self) -> bool {
        matches!(self, Self::GoesOn | Self::Exception(_))
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::GoesOn => f.write_str("goes on"),
            Self::Exception(name) => write!(f, "ends with {name}"),
            Self::Stops(code) => write!(f, "the daemon stops, exit {code}"),
            Self::Ends(Some(code)) => write!(f, "the daemon ends, exit {code}"),
            Self::Ends(None) => f.write_str("the daemon ends by a signal"),
        }
    }
}

const fn row(
    what: &'static str,
    (component, service): (&'static str, &'static str),
    outcome: Outcome,
    told: &'static str,
) -> Fault {
    Fault { what, component, service, outcome, told, stays: false }
}

/// A row after which the library stays mapped.
const fn stays(what: &'static str, service: &'static str, told: &'static str) -> Fault {
    let outcome = Outcome::GoesOn;
    Fault { what, component: "remains", service, outcome, told, stays: true }
}

const UNKEX: Outcome = Outcome::Exception("::genom::unkex");
const BAD: Outcome = Outcome::Exception("::genom::bad_transition");
const ON: Outcome = Outcome::GoesOn;

/// All rows.
pub const FAULTS: &[Fault] = &[
    // Codels that leave something behind at unload, which is when the message comes.
    stays("leaves a thread that spins", "spin", "threads that it started run on"),
    stays("leaves a thread that spins and masks signals", "spin_masked", "cannot be looked at"),
    stays("leaves a timer that calls it in a thread", "tick_by_thread", "a timer still calls it"),
    stays("leaves a destructor for a thread's end", "keep_value", "a destructor of it"),
    row("leaves a signal handler", ("remains", "handle_signal"), ON, "SIGUSR2"),
    row("leaves a timer that signals", ("remains", "tick_by_signal"), ON, "SIGRTMIN+5"),
    row("forks a child that lives on", ("remains", "child"), ON, ""),
    row("forks a child that returns", ("remains", "child_returns"), ON, "a child"),
    // Codels that end their thread or their process.
    row("calls pthread_exit", ("leaves", "exit_thread"), UNKEX, "pthread_exit"),
    row("calls syscall(SYS_exit)", ("leaves", "exit_thread_by_call"), UNKEX, "SYS_exit"),
    row("cancels its own thread", ("leaves", "cancel_thread"), UNKEX, "pthread_cancel"),
    row(
        "calls pthread_exit in a function",
        ("leaves", "exit_thread_of_control"),
        UNKEX,
        "pthread_exit",
    ),
    row(
        "calls _exit(0)",
        ("leaves", "exit_process"),
        Outcome::Ends(Some(1)),
        "_exit called by codel `leaves_exit_process`",
    ),
    row(
        "calls syscall(SYS_exit_group, 0)",
        ("leaves", "exit_process_by_call"),
        Outcome::Ends(Some(1)),
        "codel `leaves_exit_process_by_call`",
    ),
    row(
        "calls exit(0)",
        ("crashes", "leave"),
        Outcome::Ends(Some(1)),
        "exit called by codel `crashes_leave`",
    ),
    row(
        "starts a thread that calls exit(0)",
        ("leaves", "exit_later"),
        Outcome::Ends(Some(1)),
        "exit, outside codels",
    ),
    row(
        "raises SIGTERM",
        ("leaves", "terminate"),
        Outcome::Stops(1),
        "SIGTERM raised by codel `leaves_terminate`",
    ),
    row(
        "raises SIGHUP",
        ("leaves", "hang_up"),
        Outcome::Stops(1),
        "SIGHUP raised by codel `leaves_hang_up`",
    ),
    row(
        "writes where nothing is",
        ("crashes", "segfault"),
        Outcome::Ends(None),
        "SIGSEGV in codel `crashes_segfault`",
    ),
    row(
        "calls abort",
        ("crashes", "abort"),
        Outcome::Ends(None),
        "SIGABRT in codel `crashes_abort`",
    ),
    row("jumps by longjmp within the codel", ("leaves", "jump_within"), ON, ""),
    row("returns a pointer to nothing", ("leaves", "wild"), UNKEX, "leaves_wild"),
    row("returns a small number as its event", ("leaves", "small"), UNKEX, "leaves_small"),
    // Codels that take away from the process what the daemon needs.
    row("allows 8 files", ("grabs", "limit_files"), ON, "RLIMIT_NOFILE"),
    row("allows 1 MB of memory", ("grabs", "limit_memory"), ON, "RLIMIT_AS"),
    row("allows files of a byte", ("grabs", "limit_file_size"), ON, "RLIMIT_FSIZE"),
    row("closes descriptors 0 to 2", ("grabs", "close_standard"), ON, "standard"),
    row("closes stdout and stderr by fclose", ("grabs", "close_streams"), ON, "standard"),
    row("raises SIGALRM", ("grabs", "alarm"), ON, "SIGALRM"),
    row("raises SIGUSR1", ("grabs", "user_signal"), ON, "SIGUSR1"),
    row("puts SIGALRM back to its default", ("grabs", "default_signal"), ON, "SIGALRM"),
    // Codels that write beyond their memory.
    row("writes past the ids", ("overwrites", "past_ids"), UNKEX, "past the end of the ids"),
    row("writes before the ids", ("overwrites", "before_ids"), UNKEX, "the beginning of the ids"),
    row("writes past an output", ("overwrites", "past_output"), UNKEX, "past the end of"),
    row("writes past a port's data", ("overwrites", "past_port"), UNKEX, "port `samples`"),
    row("writes past an argument", ("overwrites", "past_argument"), UNKEX, "past the end of"),
    row("writes all that it may write", ("overwrites", "within"), ON, ""),
    row("writes past the ids and goes on", ("overwrites", "past_ids_and_on"), UNKEX, "the ids"),
    // Return values that are wrong but harmless.
    row("returns an event that does not exist", ("strays", "unknown"), BAD, ""),
    row("lets a C++ exception escape", ("escapes", "fail"), UNKEX, "the motor is on fire"),
];

/// What a fault did.
#[derive(Debug)]
pub struct Seen {
    /// Exit status of the call; 3 if the daemon was gone.
    pub code: Option<i32>,
    /// Output of the call, results and errors.
    pub said: String,
}

impl Fault {
    /// The row of this component and service.
    ///
    /// # Panics
    /// If there is none.
    #[must_use]
    pub fn of(component: &str, service: &str) -> &'static Self {
        let is = |row: &&Self| (row.component, row.service) == (component, service);
        FAULTS.iter().find(is).unwrap_or_else(|| panic!("no row {component}/{service}"))
    }

    /// Loads the component into a daemon and calls the service.
    #[must_use]
    #[track_caller]
    pub fn provoke(&self, daemon: &Daemon) -> Seen {
        daemon.ctl(&["load", path(&component(self.component).library)]).expect_code(0);
        let called = daemon.ctl(&["call", self.component, self.service]);
        Seen { code: called.code, said: called.out + &called.err }
    }
}
