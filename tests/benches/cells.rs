//! What becomes of others, and of what was in a cell, when the cell's process or the daemon is killed.
//!
//! `cargo bench -p genom-tests --bench cells [-- KILLS]`; 100 kills of each unless told otherwise.
//! A component in a cell that reads a port of another cell is killed again and again; a third one
//! beside them, and one of the daemon's own, have a task of 1 kHz. Printed: the time from the kill
//! until what `on_failure` says was done of components elsewhere, until the cell answers, and until
//! its in port is connected again; periods that the others missed; descriptors of the daemon. Then
//! the daemon is killed as often. The tasks of 1 kHz are real-time where that is permitted
//! (`CAP_SYS_NICE`). The programs are built with `--release`.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::print_stdout, reason = "a benchmark")]

use std::time::{Duration, Instant};

use genom_tests::trial::task_of_1_khz;
use genom_tests::{Footprint, Home, component, release, until};
use rustix::process::{Pid, Signal, kill_process};

fn main() {
    let mut words = std::env::args().skip(1).filter_map(|word| word.parse().ok());
    let kills: usize = words.next().unwrap_or(100);
    let _ = release();
    let mut daemon = Home::new().configured(&configuration()).start(&[]);
    assert_eq!(daemon.home().get("/ready?wait=30&deployed=true")["ready"], true, "all is wired");
    // What the machine itself lets a task miss: nobody in this daemon's processes is killed.
    let apart = Home::new().configured(&task_of_1_khz("apart")).start(&[]);
    let before = [daemon.missed("own"), daemon.missed("beside"), apart.missed("apart")];
    let mut reactions = [Vec::new(), Vec::new()];
    let mut seen = Vec::new();
    let mut answers = Vec::new();
    let mut wired = Vec::new();
    for _ in 0..kills {
        let home = daemon.home();
        let killed = pid(home, "base").expect("a process");
        let mut events = daemon.events();
        let begin = Instant::now();
        kill(killed);
        for _ in 0..2 {
            let told = events.wait_for(|event| event["event"] == "failure_reaction");
            assert!(told["error"].is_null(), "{told}");
            let place = usize::from(told["reaction"] == "call beside/set_speed");
            reactions[place].push(begin.elapsed());
            seen.push(Duration::from_secs_f64(told["seconds"].as_f64().expect("a number")));
        }
        until("the cell runs", || pid(home, "base").is_some_and(|now| now != killed));
        answers.push(begin.elapsed());
        let port = || home.get("/components/demo/ports/parameter");
        until("it is wired", || port()["connected"] == "mission/gain");
        wired.push(begin.elapsed());
    }
    println!("{kills} kills of a cell");
    let [own, beside] = &mut reactions;
    line("  until a service of the daemon's own component was called, and that told", own);
    line("  until a service of a component in another cell was called, and that told", beside);
    line("  of that, since the daemon saw that the process had ended", &mut seen);
    line("  until it answers", &mut answers);
    line("  until it is configured and wired", &mut wired);
    told("  missed by the daemon's own task of 1 kHz", daemon.missed("own") - before[0]);
    told("  missed by the task of another cell", daemon.missed("beside") - before[1]);
    told("  missed by the task of a daemon apart", apart.missed("apart") - before[2]);
    println!("  descriptors of the daemon: {}", Footprint::of(daemon.process().id()).descriptors);
    let before = [daemon.missed("beside"), apart.missed("apart")];
    let cell = pid(daemon.home(), "beside");
    let mut adopted = Vec::new();
    for _ in 0..kills {
        let begin = Instant::now();
        // The next one listens on the same socket as soon as this one is gone.
        daemon = daemon.abandon().start(&[]);
        adopted.push(begin.elapsed());
    }
    println!("{kills} kills of the daemon");
    line("  until the next one answers for its cells", &mut adopted);
    told("  missed by the task of a cell", daemon.missed("beside") - before[0]);
    told("  missed by the task of a daemon apart", apart.missed("apart") - before[1]);
    println!("  the same process all along: {}", pid(daemon.home(), "beside") == cell);
}

/// A writer and a reader in two cells, and two bystanders with tasks of 1 kHz.
fn configuration() -> String {
    let (demo, mission) = (component("demo").library, component("mission").library);
    let (own, beside) = (task_of_1_khz("own"), task_of_1_khz("beside"));
    // The name of the cell goes before the tables of a component.
    let beside = beside.replacen("name", "cell = \"beside\"\nname", 1);
    format!(
        "[cells]\nrestart_most = 1000000\nrestart_delay = 0.0\n{own}{beside}\
         [[component]]\nlibrary = {demo:?}\ncell = \"base\"\n\
         [[component.on_failure]]\ncall = \"own/set_speed\"\ninputs = {{ velocity = 0.5 }}\n\
         [[component.on_failure]]\ncall = \"beside/set_speed\"\ninputs = {{ velocity = 0.5 }}\n\
         [[component]]\nlibrary = {mission:?}\ncell = \"brain\"\n\
         [[connection]]\nin = \"demo/parameter\"\nout = \"mission/gain\"\n\
         [[connection]]\nin = \"mission/goto\"\nout = \"demo/goto\"\n"
    )
}

/// The process of a cell that runs.
fn pid(home: &Home, cell: &str) -> Option<u64> {
    let cells = home.get("/cells");
    let found = cells["cells"].as_array()?.iter().find(|one| one["name"] == cell)?.clone();
    found["pid"].as_u64().filter(|_| found["state"] == "running")
}

/// Without a program of its own, which would take a part of what is measured.
fn kill(pid: u64) {
    let pid = i32::try_from(pid).ok().and_then(Pid::from_raw).expect("a process");
    kill_process(pid, Signal::KILL).expect("it is ours");
}

fn told(what: &str, periods: u64) {
    println!("{what}: {periods} periods");
}

fn line(what: &str, times: &mut [Duration]) {
    times.sort_unstable();
    let at =
        |part: usize| times[(times.len() * part / 100).min(times.len() - 1)].as_secs_f64() * 1e3;
    println!("{what}: p50 {:.1} ms, p99 {:.1} ms", at(50), at(99));
}
