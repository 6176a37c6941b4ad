//! A program in Rust.

use std::fs;
use std::path::Path;
use std::time::Duration;

use genom_client::{AskError, Daemon, In, OpenError, Out, PortError, StartError};
use genom_tests::{component, signal};

use super::{ctl, options, said};

const STEP: Duration = Duration::from_millis(5);

/// A daemon with the demo.
fn with_demo() -> Daemon {
    Daemon::start(&options().argument(component("demo").library)).unwrap()
}

/// A daemon with the demo in a cell.
fn with_demo_in_cell() -> Daemon {
    let options = options().argument("--cell").argument("arm").argument(component("demo").library);
    Daemon::start(&options).unwrap()
}

/// What the axis does on its way to 1 m, if the program sets this gain when it is at 0.5 m.
fn run_of(mut daemon: Daemon, gain_later: f64) -> Vec<([f64; 2], u64)> {
    let mut gain = In::open(&mut daemon, "demo/parameter").unwrap();
    let position = Out::open(&mut daemon, "demo/position").unwrap();
    let memory = (gain.as_ptr(), position.as_ptr());
    *gain.value_mut::<f64>().unwrap() = 1.0;
    gain.write().unwrap();
    ctl(&daemon.socket(), &["start", "demo", "goto", "goal=1"]);
    let mut seen = Vec::new();
    let mut at = 0.0;
    while at < 1.0 {
        daemon.step(STEP).unwrap();
        let state: &[f64; 2] = position.value(&daemon).unwrap();
        assert_eq!(std::ptr::from_ref(state).cast(), memory.1, "it is no copy");
        at = state[0];
        seen.push((*state, position.count()));
        *gain.value_mut::<f64>().unwrap() = if at < 0.5 { 1.0 } else { gain_later };
        gain.write().unwrap();
    }
    assert_eq!((gain.as_ptr(), position.as_ptr()), memory, "the memory stays where it is");
    assert_eq!(gain.count(), 1 + seen.len() as u64);
    assert!(daemon.stop().unwrap().success());
    seen
}

#[test]
fn a_program_in_rust_steps_a_component_and_equal_values_give_equal_runs() {
    let first = run_of(with_demo(), 0.5);
    assert_eq!(first, run_of(with_demo(), 0.5));
    // The axis hears what the program says of what it sees.
    assert!(first.len() > run_of(with_demo(), 1.0).len());
}

#[test]
fn a_program_in_rust_sees_the_same_of_a_component_in_a_cell() {
    assert_eq!(run_of(with_demo_in_cell(), 0.5), run_of(with_demo(), 0.5));
}

#[test]
fn ports_of_a_cell_keep_their_memory_in_its_next_process() {
    let mut daemon = with_demo_in_cell();
    let mut gain = In::open(&mut daemon, "demo/parameter").unwrap();
    let position = Out::open(&mut daemon, "demo/position").unwrap();
    let memory = (gain.as_ptr(), position.as_ptr());
    ctl(&daemon.socket(), &["start", "demo", "goto", "goal=1"]);
    for _ in 0..20 {
        daemon.step(STEP).unwrap();
    }
    let made = said(&daemon.socket(), &["connections"]);
    assert!(!made.contains("demo/parameter"), "nothing was published: {made}");
    let before = position.count();
    *gain.value_mut::<f64>().unwrap() = 0.25;
    gain.write().unwrap();
    ctl(&daemon.socket(), &["cells", "--restart", "arm"]);
    assert_eq!(daemon.step(STEP).unwrap(), 21 * STEP);
    assert!((1..before).contains(&position.count()), "{} of {before}", position.count());
    assert_eq!((gain.as_ptr(), position.as_ptr()), memory);
    let made = said(&daemon.socket(), &["connections"]);
    assert!(made.contains("demo/parameter"), "published in the next process: {made}");
    ctl(&daemon.socket(), &["unload", "demo"]);
    daemon.step(STEP).unwrap();
    assert!(matches!(gain.write(), Err(PortError::Gone(_))));
    assert!(matches!(position.bytes(&daemon), Err(PortError::Gone(_))));
    drop((gain, position));
    assert_eq!(memory_of_ports(daemon.id()), 0);
}

#[test]
fn what_is_wrong_with_a_port_is_told_to_a_program_in_rust() {
    let (mut daemon, mut other) = (with_demo(), with_demo());
    let position = Out::open(&mut daemon, "demo/position").unwrap();
    let of_other = Out::open(&mut other, "demo/position").unwrap();
    assert!(matches!(of_other.bytes(&daemon), Err(PortError::OtherDaemon(_))));
    let told = position.value::<f64>(&daemon).unwrap_err().to_string();
    assert!(told.contains("16 bytes, and f64 has 8"), "{told}");
    for (address, told) in [
        ("demo/positon", "position"),
        ("dmo/position", "demo"),
        ("", ""),
        ("demo/parameter", "demo/parameter is an in port"),
        (&"x".repeat(5000), "4096"),
    ] {
        let error = Out::open(&mut daemon, address).unwrap_err().to_string();
        assert!(error.contains(told), "{error}");
    }
    assert!(matches!(In::open(&mut daemon, "demo/position"), Err(OpenError::OutPort(_))));
    // Who was refused holds nothing.
    assert_eq!(memory_of_ports(daemon.id()), 1);
    drop(position);
    assert_eq!(memory_of_ports(daemon.id()), 0);

    let mut gain = In::open(&mut daemon, "demo/parameter").unwrap();
    gain.write().unwrap();
    ctl(&daemon.socket(), &["unload", "demo"]);
    let refused = daemon.step(STEP).unwrap_err().to_string();
    assert!(refused.contains("demo/parameter is gone"), "{refused}");
    assert!(matches!(gain.write(), Err(PortError::Gone(_))));
    assert_eq!(daemon.step(STEP).unwrap(), STEP, "of the step that was refused there is nothing");
}

/// How many files of a process are memory of ports.
fn memory_of_ports(process: u32) -> usize {
    let files = fs::read_dir(format!("/proc/{process}/fd")).unwrap();
    let names = files.filter_map(|file| fs::read_link(file.unwrap().path()).ok());
    names.filter(|name| name.to_string_lossy().contains("genom-port")).count()
}

#[test]
fn a_program_in_rust_is_told_how_its_daemon_ended_and_leaves_nothing_of_it() {
    let mut daemon = with_demo();
    let (id, place) = (daemon.id(), daemon.socket().parent().unwrap().to_owned());
    let mut position = Out::open(&mut daemon, "demo/position").unwrap();
    assert!(matches!(daemon.step(Duration::from_secs(3601)), Err(AskError::Refused(_))));
    assert_eq!(daemon.step(STEP).unwrap(), STEP);
    let before = position.bytes(&daemon).unwrap().to_vec();
    assert!(signal(id, "KILL"));
    for _ in 0..2 {
        let Err(AskError::Ended(ended)) = daemon.step(STEP) else { panic!("it has ended") };
        assert!(ended.to_string().contains("SIGKILL"), "{ended}");
    }
    assert!(matches!(
        Out::open(&mut daemon, "demo/position"),
        Err(OpenError::Ask(AskError::Ended(_)))
    ));
    // Memory stays as long as somebody has it.
    assert_eq!(position.bytes(&daemon).unwrap(), before);
    drop(daemon);
    assert!(!place.exists() && !Path::new(&format!("/proc/{id}")).exists());
    let segments = fs::read_dir("/dev/shm").unwrap().map(|one| one.unwrap().file_name());
    let name = place.file_name().unwrap().to_string_lossy().replace('-', "");
    let left: Vec<_> = segments.filter(|one| one.to_string_lossy().starts_with(&name)).collect();
    assert_eq!(left, Vec::<std::ffi::OsString>::new());
    // A daemon that is started afterwards has nothing to do with it.
    let other = with_demo();
    assert!(matches!(position.bytes(&other), Err(PortError::OtherDaemon(_))));
    position = Out::open(&mut { other }, "demo/position").unwrap();
    assert_eq!(position.size(), 16);
}

#[test]
fn a_daemon_that_does_not_start_tells_a_program_in_rust_why() {
    let refused = Daemon::start(&options().program("/nowhere/genomd")).unwrap_err();
    assert!(matches!(refused, StartError::Program { .. }), "{refused}");
    for (argument, told) in
        [("--nonsense", "exit status: 2"), ("/nowhere/arm.so", "/nowhere/arm.so")]
    {
        let refused = Daemon::start(&options().argument(argument)).unwrap_err().to_string();
        assert!(refused.contains(told), "{refused}");
    }
}
