//! A whole robot from one file: three components on two middlewares in two daemons, six connections
//! and an activity; from a cold start, and after one of its daemons was killed.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::thread;
use std::time::Instant;

use genom_tests::{Daemon, Home, Memory, fixture};

/// In the sensor's daemon `near` reads it over shared memory; in another one `far` reads it over
/// zenoh.
fn robot(made: &Path) -> String {
    let (sensor, fuser) = (fixture("robot", "sensor", made), fixture("robot", "fuser", made));
    let mut text = format!(
        "backend = \"shm\"\n\
         [[component]]\nlibrary = {sensor:?}\ndaemon = \"base\"\nbackend = [\"shm\", \"zenoh\"]\n\
         [[component]]\nlibrary = {fuser:?}\nname = \"near\"\ndaemon = \"base\"\n\
         [[component]]\nlibrary = {fuser:?}\nname = \"far\"\ndaemon = \"arm\"\nbackend = \"zenoh\"\n"
    );
    for reader in ["near", "far"] {
        for (inport, outport) in [("a", "x"), ("b", "y"), ("c", "z")] {
            let (inport, outport) = (format!("{reader}/{inport}"), format!("sensor/{outport}"));
            write!(text, "[[connection]]\nin = {inport:?}\nout = {outport:?}\n").unwrap();
        }
    }
    text + "[[call]]\ncomponent = \"sensor\"\nservice = \"set\"\ninputs = { value = 2.0 }\n\
            [[activity]]\ncomponent = \"far\"\nservice = \"watch\"\ninputs = { wanted = 6.0 }\n"
}

fn deployed(daemon: &Daemon) {
    let line = daemon.process().error_line_where(|line| line.contains("deployed:"));
    assert!(line.is_some(), "the daemon ended");
}

/// Waits until the three ports of a component have this sum: an activity waits in the component, so
/// nothing is polled.
#[track_caller]
fn sums_up(daemon: &Daemon, reader: &str, wanted: &str) {
    let done = daemon.ctl(&["start", "--wait", reader, "watch", &format!("wanted={wanted}")]);
    done.expect_code(0);
}

#[test]
fn a_robot_comes_up_from_one_file_and_survives_the_death_of_a_daemon() {
    let made = tempfile::tempdir().unwrap();
    let (memory, text) = (Arc::new(Memory::new()), robot(made.path()));
    let home = || Home::with(&memory).configured(&text);
    let (one, other) = (home(), home());

    let begin = Instant::now();
    let (base, arm) = thread::scope(|scope| {
        let base = scope.spawn(|| one.start(&["--daemon", "base"]));
        let arm = other.start(&["--daemon", "arm"]);
        (base.join().expect("it starts"), arm)
    });
    deployed(&base);
    deployed(&arm);
    println!("two daemons, three components, six connections: {:?} from cold", begin.elapsed());
    let backends = |daemon: &Daemon| -> Vec<String> {
        let all = daemon.json(&["connections"])["connections"].clone();
        let all = all.as_array().unwrap().iter();
        all.map(|made| made["backend"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!((backends(&base), backends(&arm)), (vec!["shm".into(); 3], vec!["zenoh".into(); 3]));
    // The activity of the file ends when all three values have arrived.
    let activities = arm.json(&["activities", "far"])["activities"].clone();
    let mut all = activities.as_array().unwrap().iter();
    let watch = all.find(|one| one["service"] == "watch").expect("it was started");
    let number = watch["activity"].to_string();
    arm.ctl(&["wait", "far", &number]).expect_code(0).expect_out("done\n");
    println!("data through all of them: {:?} from cold", begin.elapsed());
    sums_up(&base, "near", "6");

    let (_, home) = base.stop("KILL");
    let begin = Instant::now();
    let base = home.start(&["--daemon", "base"]);
    deployed(&base);
    sums_up(&base, "near", "6");
    base.ctl(&["start", "--wait", "sensor", "set", "value=3"]).expect_code(0);
    sums_up(&arm, "far", "9");
    println!("back after kill -9: {:?}", begin.elapsed());
}
