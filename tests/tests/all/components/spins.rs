//! Activities that never pause: what is reported while they run.

use genom_tests::{Daemon, component, path, until};

fn daemon() -> Daemon {
    let spins = component("spins");
    Daemon::start(&["--set", "stuck_after=1", path(&spins.library)])
}

fn state(daemon: &Daemon) -> String {
    daemon.json(&["list"])["components"][0]["state"].as_str().unwrap().to_owned()
}

#[test]
fn a_codel_that_spins_is_named_wherever_one_looks_until_it_ends() {
    let daemon = daemon();
    let mut events = daemon.events();
    daemon.ctl(&["start", "spins", "spin_steady"]).expect_code(0);
    let told = events.wait_for(|e| e["event"] == "codel_spins");
    assert_eq!((&told["task"], &told["owner"]), (&"steady".into(), &"spin_steady".into()));
    assert_eq!(told["codel"], "spins_spin_steady");
    let named = "codel spins_spin_steady of spin_steady yields without pause for ";
    daemon.process().error_line_where(|line| line.contains(named)).unwrap();
    assert!(state(&daemon).starts_with("spins in spins_spin_steady for "), "{}", state(&daemon));
    let why = daemon.ctl(&["why", "spins/genom_state"]);
    assert!(why.out.contains(&format!("task steady of spins does not pause: {named}")), "{why:?}");
    // The port belongs to another task, which writes it once a second.
    until("it is said first that data flows", || {
        let why = daemon.ctl(&["why", "spins/genom_state"]);
        why.out.starts_with("data flows: spins/genom_state was last written ")
    });
    let doctor = daemon.ctl(&["doctor"]);
    doctor.expect_code(1);
    assert!(doctor.out.contains(named), "{}", doctor.out);
    let top = daemon.ctl(&["top", "--once"]);
    assert!(top.out.starts_with("spins spins in spins_spin_steady for "), "{}", top.out);
    daemon.ctl(&["stats", "spins"]).expect_code(0).expect_err("task steady did not pause for ");
    // The running cycle counts: it is the longest.
    let cycles = || daemon.json(&["stats", "spins"])["tasks"][1]["cycles"].clone();
    let longest = || cycles()["max_ns"].as_u64().unwrap();
    let (first, count) = (longest(), cycles()["count"].as_u64().unwrap());
    assert!(first > 1_000_000_000 && count > 0, "{first} {count}");
    until("it grows", || longest() > first);
    daemon.ctl(&["stop"]).expect_code(0);
    until("it spins no more", || state(&daemon) == "running");
    daemon.stop("TERM").0.expect_code(0);
}

#[test]
fn a_codel_that_waits_for_data_without_a_pause_does_not_spin() {
    let daemon = daemon();
    daemon.ctl(&["start", "spins", "listen"]).expect_code(0);
    let unpaused = || {
        let told = daemon.json(&["stats", "spins"])["tasks"][0]["unpaused"].clone();
        told["for_ns"].as_u64().unwrap_or_default()
    };
    // Enough time for several checks after the limit was reached.
    until("it does not pause for seconds", || unpaused() > 4_000_000_000);
    assert_eq!(state(&daemon), "running");
    daemon.ctl(&["stop"]).expect_code(0);
    daemon.stop("TERM").0.expect_code(0);
}
