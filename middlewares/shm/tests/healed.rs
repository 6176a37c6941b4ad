//! Incomplete or truncated files do not prevent anything from being opened.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "helpers of tests fail them"
)]

mod world;

use std::fs::{self, OpenOptions, Permissions};
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use genom_conformance::World;
use genom_conformance::samples::{number, numbered, state};
use genom_middleware::{Address, Discovery, Policy, PortSpec, Ports, Reading};
use genom_types::Record;

use world::ShmWorld;
use world::process::Process;

/// Reached only by a test that fails.
const WATCHDOG: Duration = Duration::from_secs(60);

/// Mode of a file that iceoryx2 has not completed.
const UNFINISHED: u32 = 0o200;

fn position() -> Address {
    Address::new("demo", "position")
}

/// Runs `work` on another thread, and fails if it hangs.
#[track_caller]
fn bounded<T: Send + 'static>(what: &str, work: impl FnOnce() -> T + Send + 'static) -> T {
    let (done, wait) = channel();
    thread::spawn(move || drop(done.send(work())));
    wait.recv_timeout(WATCHDOG).unwrap_or_else(|error| panic!("{what}: {error}"))
}

fn started(world: &ShmWorld) -> Process {
    let process = Process::writer(world);
    assert_eq!(process.says(), "ready");
    process
}

/// Segments of a world whose names end in `end`.
fn segments(world: &ShmWorld, end: &str) -> Vec<PathBuf> {
    let all = Path::new("/dev/shm").read_dir().unwrap().flatten().map(|entry| entry.path());
    let own = |path: &PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy();
        name.starts_with(world.prefix()) && name.ends_with(end)
    };
    let mut found: Vec<PathBuf> = all.filter(own).collect();
    found.sort();
    found
}

fn files(folder: PathBuf) -> Vec<PathBuf> {
    folder.read_dir().unwrap().flatten().map(|entry| entry.path()).collect()
}

/// Truncates a file, as a process leaves it that was killed before it set the size.
fn cut(file: &Path) {
    OpenOptions::new().write(true).truncate(true).open(file).unwrap();
    fs::set_permissions(file, Permissions::from_mode(UNFINISHED)).unwrap();
}

/// Checks that a port works from end to end, and leaves nothing behind.
fn works(world: ShmWorld) {
    let world = bounded("it starts and its port works", move || {
        let shm = world.open();
        let mut reader =
            shm.subscription(&PortSpec::new(&position(), &state()), Policy::Latest).unwrap();
        let mut writer = shm.publisher(&PortSpec::new(&position(), &state())).unwrap();
        writer.publish(&numbered(7)).unwrap();
        let mut got = Record::new(&state());
        assert_eq!(reader.read(&mut got), Ok(Reading::New));
        assert_eq!(number(&got), 7);
        shm.discover().unwrap();
        drop((reader, writer, shm));
        world
    });
    assert_eq!(world.leftovers(), Vec::<String>::new());
}

#[test]
#[ignore = "is another process, which the other tests start"]
fn writes_until_it_is_killed() {
    world::writer::run();
}

#[test]
fn segments_that_a_killed_process_did_not_finish_are_removed_by_the_next_start() {
    for end in [".dynamic", ".data", ".connection"] {
        let world = ShmWorld::new();
        let process = started(&world);
        // A second participant, so that there are connections.
        let shm = world.open();
        let reader =
            shm.subscription(&PortSpec::new(&position(), &state()), Policy::Latest).unwrap();
        drop((reader, shm));
        process.kill();
        segments(&world, end).iter().for_each(|file| cut(file));
        works(world);
    }
}

#[test]
fn services_that_a_killed_process_did_not_describe_are_made_anew() {
    let world = ShmWorld::new();
    started(&world).kill();
    let all = files(world.root().join("services"));
    assert!(all.len() > 3);
    all.iter().for_each(|file| cut(file));
    works(world);
}

#[test]
fn services_that_a_killed_process_had_left_already_are_made_anew() {
    let world = ShmWorld::new();
    started(&world).kill();
    // It had removed its node and its tags; its part in services is still there.
    for node in files(world.root().join("nodes")) {
        let _ = fs::remove_dir_all(&node);
        let _ = fs::remove_file(&node);
    }
    for file in segments(&world, ".data") {
        fs::remove_file(file).unwrap();
    }
    for file in segments(&world, ".event_mgmt") {
        fs::remove_file(file).unwrap();
    }
    fs::read_dir(world.root()).unwrap().flatten().for_each(|entry| {
        let _ = fs::remove_file(entry.path());
    });
    works(world);
}

#[test]
fn nodes_of_which_a_part_is_left_are_removed_by_the_next_start() {
    // The files of a node, in the order in which a process creates them (it removes them in
    // another).
    for end in ["_context", "_owner_lock", ".node_monitor"] {
        let world = ShmWorld::new();
        started(&world).kill();
        for file in files(world.root().join("nodes")) {
            let name = file.to_string_lossy().into_owned();
            if name.ends_with(end) {
                fs::remove_file(&file).unwrap();
            }
        }
        works(world);
        let world = ShmWorld::new();
        started(&world).kill();
        for file in files(world.root().join("nodes")) {
            let name = file.to_string_lossy().into_owned();
            if file.is_file() && !name.ends_with(end) {
                fs::remove_file(&file).unwrap();
            } else if file.is_file() {
                cut(&file);
            }
        }
        works(world);
    }
}

#[test]
fn a_counter_of_nodes_that_was_cut_is_made_anew() {
    let unfinished: [fn(&Path); 3] = [
        cut,
        |file| fs::set_permissions(file, Permissions::from_mode(UNFINISHED)).unwrap(),
        |file| OpenOptions::new().write(true).open(file).unwrap().set_len(8).unwrap(),
    ];
    for damage in unfinished {
        let world = ShmWorld::new();
        drop(bounded("it starts", {
            let shm = world.options();
            move || genom_shm::Shm::open(shm).unwrap()
        }));
        let counter = segments(&world, ".global_mgmt");
        damage(&counter[0]);
        works(world);
    }
}

#[test]
fn who_waits_for_a_segment_of_a_living_process_that_was_cut_waits_no_longer_than_bounded() {
    let world = ShmWorld::new();
    let shm = world.open();
    let process = started(&world);
    for file in segments(&world, ".dynamic") {
        OpenOptions::new().write(true).truncate(true).open(file).unwrap();
    }
    let shm = bounded("it looks around", move || {
        let _ = shm.discover();
        let at = Address::new("demo", "parameter");
        let _ = shm.publisher(&PortSpec::new(&at, &state())).map(drop);
        shm
    });
    process.kill();
    bounded("it ends", move || drop(shm));
    works(world);
}

#[test]
fn what_a_process_left_is_removed_while_its_peer_runs() {
    let world = ShmWorld::new();
    let shm = world.open();
    let own: Vec<String> = world.leftovers();
    started(&world).kill();
    let end = std::time::Instant::now() + WATCHDOG;
    while world.leftovers() != own {
        assert!(std::time::Instant::now() < end, "{:?}", world.leftovers());
    }
    drop(shm);
}
