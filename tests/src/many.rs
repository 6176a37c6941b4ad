//! Many components in one daemon, and the resources that a process uses for them.
//!
//! The component is `tests/fixtures/many`: five ports, nine services, one task at 10 Hz that writes
//! all its out ports. One library is loaded under the names `m0`, `m1`, ...:
//! ```text
//! let made = tempfile::tempdir().unwrap();
//! let text = Many { components: 60, chained: true, cells: 0 }.configuration("shm", made.path());
//! let daemon = Home::new().configured(&text).start(&[]);
//! let held = Footprint::of(daemon.process().id());
//! assert!(held.descriptors < 60 * 6);
//! ```
//! By hand: `cargo run -p genom-tests --bin many -- 500 shm DIRECTORY` writes the configuration and
//! prints how to start it.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::Duration;

use crate::fixture;

/// Components of one kind under different names.
#[derive(Clone, Copy, Debug)]
pub struct Many {
    /// Number of components.
    pub components: usize,
    /// Whether each reads the state and the level of the previous one, and the first those of the
    /// last. If false, no port is connected.
    pub chained: bool,
    /// Number of cells that they are spread over; 0: all are in the process of the daemon.
    pub cells: usize,
}

impl Many {
    /// Builds the component in a directory. Returns the configuration of a daemon that loads it
    /// this many times.
    ///
    /// # Panics
    /// If it cannot be built.
    #[must_use]
    pub fn configuration(self, backend: &str, made: &Path) -> String {
        let library = fixture("many", "many", made);
        let mut text = format!("backend = \"{backend}\"\n");
        let mut add = |more: &str| text.write_str(more).expect("a string takes all");
        for n in 0..self.components {
            add(&format!("[[component]]\nlibrary = {library:?}\nname = \"m{n}\"\n"));
            if let Some(cell) = n.checked_rem(self.cells) {
                add(&format!("cell = \"c{cell}\"\n"));
            }
        }
        for n in (0..self.components).filter(|_| self.chained) {
            let before = (n + self.components - 1) % self.components;
            for (inport, outport) in [("other", "current_state"), ("demand", "current_level")] {
                add(&format!(
                    "[[connection]]\nin = \"m{n}/{inport}\"\nout = \"m{before}/{outport}\"\n"
                ));
            }
        }
        text
    }
}

/// Time that all threads of a process, as far as they still run, spent on processors.
///
/// # Panics
/// If there is no such process.
#[must_use]
pub fn processor_time(process: u32) -> Duration {
    let tasks = Path::new("/proc").join(process.to_string()).join("task");
    let of = |task: fs::DirEntry| -> Option<u64> {
        // Nanoseconds on a processor, then waiting for one.
        let times = fs::read_to_string(task.path().join("schedstat")).ok()?;
        times.split_whitespace().next()?.parse().ok()
    };
    let tasks = fs::read_dir(tasks).expect("the process runs").flatten();
    Duration::from_nanos(tasks.filter_map(of).sum())
}

/// Resources of a process, as the kernel reports them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Footprint {
    /// Open file descriptors.
    pub descriptors: usize,
    /// Mapped segments of shared memory.
    pub segments: usize,
    /// Resident memory in KiB, including shared memory.
    pub resident: u64,
    /// The shared part of the resident memory, in KiB.
    pub shared: u64,
    /// Peak resident memory in KiB.
    pub peak: u64,
    /// Threads.
    pub threads: u64,
}

impl Footprint {
    /// Resources of several processes together; what they share counts for each.
    ///
    /// # Panics
    /// If one of them does not run.
    #[must_use]
    pub fn of_all(processes: &[u32]) -> Self {
        let all = processes.iter().map(|&process| Self::of(process));
        all.reduce(|one, other| Self {
            descriptors: one.descriptors + other.descriptors,
            segments: one.segments + other.segments,
            resident: one.resident + other.resident,
            shared: one.shared + other.shared,
            peak: one.peak + other.peak,
            threads: one.threads + other.threads,
        })
        .expect("a process")
    }

    /// Resources of a process now.
    ///
    /// # Panics
    /// If there is no such process.
    #[must_use]
    pub fn of(process: u32) -> Self {
        let place = Path::new("/proc").join(process.to_string());
        let read = |name: &str| fs::read_to_string(place.join(name)).expect("the process runs");
        let (status, maps) = (read("status"), read("maps"));
        let number = |key: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(key));
            let word = line.and_then(|line| line.split_whitespace().next());
            word.and_then(|word| word.parse().ok()).expect("the kernel tells it")
        };
        Self {
            descriptors: fs::read_dir(place.join("fd")).expect("the process runs").count(),
            segments: maps.lines().filter(|line| line.contains("/dev/shm/")).count(),
            resident: number("VmRSS:"),
            shared: number("RssShmem:"),
            peak: number("VmHWM:"),
            threads: number("Threads:"),
        }
    }
}
