//! Reports of crashes: what is known when the process of a cell has ended without being asked to.
//!
//! The dying process writes what only it knows to a file in the cell's directory (`note`); the
//! daemon adds what it heard of the cell before (`known`), has the functions of the backtrace named
//! from the libraries' symbols (`images`, `reader`, `symbols`), and keeps it all in a directory of its own
//! (`store`). Nothing waits for it: the cell is started again meanwhile.

mod dump;
mod images;
mod known;
mod memory;
mod names;
mod note;
mod reader;
mod store;
mod symbols;

use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use genom_configuration::{CrashesSection, LoadRequest};
use genom_protocol::{Crash, CrashReport, Crashes};
use rustix::process::Signal;

use crate::end::End;
use crate::shelf::date;
use crate::theirs;
pub(crate) use dump::{Dump, DumpError};
use images::Images;
pub(crate) use known::{Known, learn};
use memory::Shortage;
use note::Note;
pub use reader::read_symbols;
use store::Store;
pub use store::StoreError;

/// The reports of a daemon's cells.
#[derive(Debug)]
pub struct Reports {
    store: Store,
    /// Whether cells leave core dumps.
    core: bool,
    shortage: Shortage,
    socket: PathBuf,
}

/// The end of a process, with what was there to be seen of it right after.
#[derive(Debug)]
pub(crate) struct Ended {
    report: CrashReport,
    raw: Vec<u8>,
    note: Option<Note>,
    images: Images,
}

impl Reports {
    /// Those of the daemon that listens on this socket; nothing is made yet.
    #[must_use]
    pub fn new(section: &CrashesSection, socket: &Path) -> Self {
        let shortage = Shortage::new();
        Self { store: Store::new(section), core: section.core, shortage, socket: socket.to_owned() }
    }

    /// All that are kept.
    #[must_use]
    pub fn list(&self) -> Crashes {
        Crashes { directory: self.store.0.directory.clone(), crashes: self.store.list() }
    }

    /// The report of this name.
    ///
    /// # Errors
    /// There is none, or it cannot be read.
    pub fn read(&self, name: &str) -> Result<CrashReport, StoreError> {
        self.store.read(name)
    }

    /// Takes what the next process of the cell would remove: the note, and the private copies of
    /// libraries, by opening them. `None` if no report is wanted.
    pub(crate) fn look(
        &self,
        (cell, pid): (&str, Option<u32>),
        end: &End,
        note: &Path,
        held: &[LoadRequest],
        known: &Known,
    ) -> Option<Ended> {
        if !self.store.is_kept() {
            return None;
        }
        let raw = take(note);
        let now = SystemTime::now();
        let since = now.duration_since(UNIX_EPOCH).unwrap_or_default();
        let name = format!("crash-{}-{cell}", date(now));
        let components: Vec<_> = held.iter().map(|one| known.component(one)).collect();
        let libraries: Vec<_> = components.iter().map(|one| one.library.clone()).collect();
        let note = note::read(&raw);
        let codel = note.as_ref().and_then(|note| note.fault.words.as_deref()).and_then(codel);
        // The kernel kills with this signal; so do others, when there is no shortage.
        let killed = *end == End::Signal(Signal::KILL.as_raw());
        Some(Ended {
            report: CrashReport {
                crash: Crash {
                    name,
                    time: since.as_secs_f64(),
                    cell: cell.to_owned(),
                    end: end.to_string(),
                    codel: codel.map(str::to_owned),
                },
                genomd: env!("CARGO_PKG_VERSION").to_owned(),
                socket: self.socket.clone(),
                pid,
                out_of_memory: killed.then(|| self.shortage.came()).flatten(),
                components,
                fault: None,
                blackbox: None,
                minidump: None,
                core: core(end, self.core),
                log: known.log(),
            },
            images: Images::open(note.as_ref(), &libraries),
            note,
            raw,
        })
    }

    /// Completes a report, and keeps it with the files that `more` puts into its directory. Takes a
    /// while: it has this program, the daemon's own, read symbols.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub(crate) fn write(
        &self,
        ended: Ended,
        program: &Path,
        more: impl FnOnce(&Path, &mut CrashReport),
    ) -> Result<Crash, StoreError> {
        let Ended { mut report, raw, note, mut images } = ended;
        let told: Vec<(u64, bool)> = note.as_ref().map(addresses).unwrap_or_default();
        if let Err(error) = images.look_up(program, &told) {
            let name = &report.crash.name;
            tracing::warn!("{name}: functions and build ids are not told: {error}");
        }
        for component in &mut report.components {
            component.build_id = images.build_id(&component.library);
        }
        if let Some(Note { mut fault, pc, callers, guesses, .. }) = note {
            fault.guessed = callers.is_empty() && !guesses.is_empty();
            fault.frames = images.name(&told);
            if pc.is_none() {
                // It was a function of the daemon's program that noted the end.
                let own = fault.frames.first().and_then(|frame| frame.file.clone());
                let foreign = fault.frames.iter().position(|frame| frame.file != own);
                fault.frames.drain(..foreign.unwrap_or(0));
            }
            report.fault = Some(fault);
        }
        self.store.add(&mut report, &raw, more)?;
        Ok(report.crash)
    }
}

/// Where the process was, the innermost frame first; each with whether it is a return address.
fn addresses(note: &Note) -> Vec<(u64, bool)> {
    let callers = if note.callers.is_empty() { &note.guesses } else { &note.callers };
    let callers = callers.iter().map(|at| (*at, true));
    note.pc.map(|at| (at, false)).into_iter().chain(callers).collect()
}

/// Where the core dump of a process is that a signal ended, if it was to leave one: the system
/// decides.
fn core(end: &End, wanted: bool) -> Option<String> {
    let End::Signal(signal) = end else { return None };
    let dumps = [
        Signal::QUIT,
        Signal::ILL,
        Signal::TRAP,
        Signal::ABORT,
        Signal::BUS,
        Signal::FPE,
        Signal::SEGV,
        Signal::XCPU,
        Signal::XFSZ,
        Signal::SYS,
    ];
    if !wanted || !dumps.iter().any(|one| one.as_raw() == *signal) {
        return None;
    }
    let pattern = fs::read_to_string("/proc/sys/kernel/core_pattern").unwrap_or_default();
    let directory = std::env::current_dir().unwrap_or_default();
    Some(core_place(pattern.trim(), &directory))
}

fn core_place(pattern: &str, directory: &Path) -> String {
    match pattern.strip_prefix('|') {
        Some(program) => format!("given to `{program}`, as core_pattern says"),
        None if pattern.starts_with('/') => format!("`{pattern}`, as core_pattern says"),
        None => format!("`{pattern}` in {}, as core_pattern says", directory.display()),
    }
}

/// The note of a process that has ended, removed: the next process writes its own.
fn take(path: &Path) -> Vec<u8> {
    let mut raw = Vec::new();
    // The cell may write in its directory: a link could lead to any file of the user.
    if let Ok(file) = theirs::open(path) {
        let _ = file.take(note::MOST).read_to_end(&mut raw);
        let _ = fs::remove_file(path);
    }
    raw
}

/// The name in ``codel `NAME` of ...``.
fn codel(words: &str) -> Option<&str> {
    words.strip_prefix("codel `")?.split('`').next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_codel_is_the_one_that_the_process_named() {
        assert_eq!(codel("codel `go` of /opt/a.so"), Some("go"));
        assert_eq!(codel("a constructor of /opt/a.so"), None);
    }

    #[test]
    fn where_a_core_dump_is_is_what_the_system_says() {
        let place = |pattern| core_place(pattern, Path::new("/robot"));
        assert_eq!(place("core.%p"), "`core.%p` in /robot, as core_pattern says");
        assert_eq!(place("/var/core/%e"), "`/var/core/%e`, as core_pattern says");
        assert_eq!(place("|/bin/coredump %P"), "given to `/bin/coredump %P`, as core_pattern says");
        assert!(core(&End::Signal(11), false).is_none() && core(&End::Exited(1), true).is_none());
        assert!(core(&End::Signal(9), true).is_none() && core(&End::Signal(11), true).is_some());
    }

    #[test]
    fn a_note_that_is_a_link_or_a_pipe_is_not_read() {
        let scratch = tempfile::tempdir().unwrap();
        let (secret, link, pipe) = (
            scratch.path().join("secret"),
            scratch.path().join("link"),
            scratch.path().join("pipe"),
        );
        fs::write(&secret, "what x").unwrap();
        std::os::unix::fs::symlink(&secret, &link).unwrap();
        let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, mode, 0).unwrap();
        assert_eq!((take(&link), take(&pipe)), (Vec::new(), Vec::new()));
        assert!(images::regular(&pipe).is_none());
        assert_eq!(take(&secret), b"what x");
        assert!(!secret.exists());
    }

    #[test]
    fn an_end_that_told_nothing_is_reported_with_what_is_known() {
        let scratch = tempfile::tempdir().unwrap();
        let directory = Some(scratch.path().join("crashes"));
        let section = CrashesSection { directory, ..CrashesSection::default() };
        let reports = Reports::new(&section, Path::new("/run/s"));
        let held = [LoadRequest { library: "/no/demo.so".into(), ..LoadRequest::default() }];
        let note = scratch.path().join("note");
        let cell = ("arm", Some(42));
        let ended = reports.look(cell, &End::Signal(9), &note, &held, &Known::default());
        let crash = reports.write(ended.unwrap(), Path::new("/no/genomd"), |_, _| {}).unwrap();
        assert_eq!(reports.list().crashes, std::slice::from_ref(&crash));
        let report = reports.read(&crash.name).unwrap();
        assert_eq!((report.crash.end.as_str(), report.fault), ("signal 9 (SIGKILL)", None));
        assert_eq!(report.components[0].name, "demo");
        let none = Reports::new(&CrashesSection { most: 0, ..section }, Path::new("/run/s"));
        let ended = none.look(cell, &End::Signal(9), &note, &held, &Known::default());
        assert!(ended.is_none());
    }
}
