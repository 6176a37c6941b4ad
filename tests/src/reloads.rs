//! Reloads a component with a changing library again and again, while it and others work.
//!
//! Each period of the component follows from the one before (`tests/fixtures/swapped`): a period of
//! its task, its activity or its port that is lost or done twice is found at the end.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

use crate::{Daemon, Footprint, fixture, path, repository, until};

/// Reloads after which the process has what it needs for them.
const FIRST: usize = 10;

/// What many reloads did.
#[derive(Debug)]
pub struct Reloads {
    /// How often the component was reloaded.
    pub times: usize,
    /// How long all took.
    pub elapsed: Duration,
    /// Periods that its task made meanwhile.
    pub periods: u64,
    /// Periods that its task missed meanwhile.
    pub missed: u64,
    /// Periods by its own clock that it did not make, in the whole time; one more or less.
    pub lost: u64,
    /// Periods that the task of the component beside it missed meanwhile.
    pub missed_beside: u64,
    /// The same of both in as much time without a reload.
    pub missed_without: [u64; 2],
    /// Periods that it lost in that time.
    pub lost_without: u64,
    /// The process after the first of them.
    pub before: Held,
    /// The process after all of them.
    pub after: Held,
}

/// What a process holds.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    /// Memory, descriptors, threads.
    pub footprint: Footprint,
    /// Mappings.
    pub maps: usize,
}

impl Held {
    fn by(process: u32) -> Self {
        let maps = fs::read_to_string(format!("/proc/{process}/maps")).expect("the process runs");
        Self { footprint: Footprint::of(process), maps: maps.lines().count() }
    }
}

/// Another library each time, and perhaps another description.
struct Libraries(Vec<Library>);

/// A library with a number in it.
struct Library {
    directory: TempDir,
    bytes: Vec<u8>,
    at: usize,
}

impl Libraries {
    fn make(described: bool) -> Self {
        let mut all = vec![Library::make("swapped")];
        if described {
            // The same codels, with other IDS.
            let source = TempDir::new().expect("a directory can be made");
            for name in ["steady.gen", "steady.c"] {
                let text =
                    fs::read_to_string(repository().join("tests/fixtures/swapped").join(name));
                let text = text.expect("the fixture is there");
                let wider = text.replace("ids { point now;", "ids { double added[16]; point now;");
                fs::write(source.path().join(name), wider).expect("a file can be written");
            }
            all.push(Library::make(path(source.path())));
        }
        Self(all)
    }

    /// The file to load for the time of this number.
    fn change(&mut self, number: usize) -> PathBuf {
        let all = self.0.len();
        let library = &mut self.0[number % all];
        library.change(number);
        library.path()
    }
}

impl Library {
    fn make(folder: &str) -> Self {
        let directory = TempDir::new().expect("a directory can be made");
        let described = fixture(folder, "steady", directory.path());
        let bytes = fs::read(Path::new(&described).with_extension("so")).expect("it was made");
        let mark = b"VARIANT=";
        let at = bytes.windows(mark.len()).position(|window| window == mark).expect("a mark");
        Self { at: at + mark.len(), bytes, directory }
    }

    fn path(&self) -> PathBuf {
        self.directory.path().join("steady.so")
    }

    /// Replaces the file, as a linker does.
    fn change(&mut self, number: usize) {
        let text = format!("{number:08}");
        self.bytes[self.at..self.at + text.len()].copy_from_slice(text.as_bytes());
        let aside = self.directory.path().join("steady.so.new");
        fs::write(&aside, &self.bytes).expect("a file can be written");
        fs::rename(&aside, self.path()).expect("a file can be renamed");
    }
}

/// Reloads a component so often, in a cell or in the daemon's own process; `described`: with another
/// description each time.
///
/// # Panics
/// Something is not as it would be without.
#[must_use]
pub fn reloads(times: usize, in_cell: bool, described: bool) -> Reloads {
    let mut libraries = Libraries::make(described);
    let daemon = Daemon::start(&["--backend", "shm"]);
    let file = libraries.change(0);
    let cell: &[&str] = if in_cell { &["--cell", "arm"] } else { &[] };
    for name in ["steady", "beside"] {
        let load = ["load", path(&file), "--name", name];
        daemon.ctl(&[&load[..], cell].concat()).expect_code(0);
    }
    for (one, other) in [("steady", "beside"), ("beside", "steady")] {
        daemon.ctl(&["connect", &format!("{one}/other"), &format!("{other}/state")]).expect_code(0);
    }
    daemon.ctl(&["call", "steady", "set_note", "note=as it was"]).expect_code(0);
    let activity = daemon.json(&["start", "steady", "run"])["activity"].to_string();
    let process = || match in_cell {
        true => number(&daemon.json(&["cells"])["cells"][0]["pid"]),
        false => u64::from(daemon.process().id()),
    };
    let pid = u32::try_from(process()).expect("a process");
    let missed = || ["steady", "beside"].map(|name| daemon.missed(name));
    let working = Working::begin(&daemon);
    let mut before = Held::by(pid);
    let (begin, began, mut had) = (Instant::now(), count(&daemon), missed());
    let first_lost = lost(&get(&daemon));
    let mut own = 0;
    for time in 1..=times {
        let file = libraries.change(time);
        if described {
            // Its statistics begin anew.
            own += missed()[0] - std::mem::take(&mut had[0]);
        }
        let told = daemon.json(&["reload", "steady", path(&file)]);
        assert!(told["old_stays"].is_null(), "{told}");
        assert_eq!(told["restarted"] == true, described, "{told}");
        until("the new code runs", || number(&get(&daemon)["variant"]) == time as u64);
        if time == FIRST.min(times) {
            before = Held::by(pid);
        }
    }
    let (elapsed, periods) = (begin.elapsed(), count(&daemon) - began);
    let now = missed();
    let (own, beside) = (own + now[0] - had[0], now[1] - had[1]);
    let now_lost = lost(&get(&daemon));
    let (end, had) = (Instant::now() + elapsed, missed());
    while Instant::now() < end {
        let _ = get(&daemon);
    }
    let now = missed();
    let missed_without = [now[0] - had[0], now[1] - had[1]];
    let lost_without = lost(&get(&daemon)).saturating_sub(now_lost);
    drop(working);
    let after = Held::by(pid);
    // All follows from the periods before.
    let now = get(&daemon);
    assert_eq!(number(&now["wrong"]), 0, "{now}");
    assert_eq!(number(&now["now"]["chain"]), chain_at(number(&now["now"]["count"])), "{now}");
    assert_eq!(now["note"], "as it was");
    assert_eq!(number(&daemon.json(&["call", "beside", "get"])["result"]["wrong"]), 0);
    let running = daemon.json(&["activities", "steady"])["activities"][0].clone();
    assert_eq!((running["activity"].to_string(), &running["state"]), (activity, &"main".into()));
    daemon.ctl(&["abort", "steady", "run"]).expect_code(0);
    until("it ends", || {
        daemon.json(&["activities", "steady"])["activities"][0]["status"] != "running"
    });
    assert_eq!(process(), u64::from(pid), "the process is the same one");
    let missed_beside = beside;
    let (missed, lost) = (own, now_lost.saturating_sub(first_lost));
    Reloads {
        times,
        elapsed,
        periods,
        missed,
        lost,
        missed_beside,
        missed_without,
        lost_without,
        before,
        after,
    }
}

fn get(daemon: &Daemon) -> Value {
    daemon.json(&["call", "steady", "get"])["result"].clone()
}

/// Periods since the first one that the component did not make.
fn lost(now: &Value) -> u64 {
    let time = number(&now["made"]["last"]) - number(&now["made"]["first"]);
    ((time + 500_000) / 1_000_000 + 1).saturating_sub(number(&now["now"]["count"]))
}

fn count(daemon: &Daemon) -> u64 {
    number(&get(daemon)["now"]["count"])
}

fn number(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// The same as in the component.
fn chain_at(count: u64) -> u64 {
    (0..count).fold(1, |chain: u64, _| {
        chain.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407)
    })
}

/// Requests that go on all the time.
struct Working {
    over: Arc<AtomicBool>,
    thread: Option<thread::JoinHandle<()>>,
}

impl Working {
    fn begin(daemon: &Daemon) -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let (flag, socket) = (Arc::clone(&over), daemon.home().socket());
        let ask = move || {
            while !flag.load(Ordering::Relaxed) {
                let asked = crate::request(&socket, "GET", "/components/steady/ports/state", "");
                assert_eq!(asked.status, 200, "{}", asked.body);
            }
        };
        Self { over, thread: Some(thread::spawn(ask)) }
    }
}

impl Drop for Working {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        let ended = self.thread.take().map(thread::JoinHandle::join);
        if !thread::panicking() {
            assert!(ended.is_none_or(|ended| ended.is_ok()), "a request failed");
        }
    }
}
