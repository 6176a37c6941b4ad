//! Two components whose own modules define equal types under different names.

use genom_tests::{Daemon, Home, fixture};

fn hears(daemon: &Daemon, value: &str) {
    daemon.ctl(&["start", "--wait", "left", "tell", &format!("value={value}")]).expect_code(0);
    daemon.ctl(&["start", "--wait", "right", "hear", &format!("wanted={value}")]).expect_code(0);
}

#[test]
fn equal_types_of_other_names_connect_and_move_on_every_middleware() {
    let made = tempfile::tempdir().unwrap();
    let (left, right) =
        (fixture("twins", "left", made.path()), fixture("twins", "right", made.path()));
    let daemon = Home::new().start(&["--backend", "shm", &left, &right]);
    daemon.ctl(&["connect", "right/heard", "left/told"]).expect_code(0);
    hears(&daemon, "1");
    for (n, backend) in ["local", "shm", "zenoh", "ros2", "shm"].into_iter().enumerate() {
        for component in ["right", "left"] {
            daemon.ctl(&["backend", component, backend]).expect_code(0);
        }
        assert_eq!(daemon.json(&["connections"])["connections"][0]["backend"], backend);
        hears(&daemon, &format!("{}", n + 2));
    }
    // In another daemon, with the reader first: the port has the name of the reader's type.
    let reader =
        Home::with(daemon.home().memory()).start(&["--backend", "shm", "--name", "far", &right]);
    reader.ctl(&["connect", "--wait", "far/heard", "shm:late/told"]).expect_code(0);
    daemon.ctl(&["load", &left, "--name", "late"]).expect_code(0);
    daemon.ctl(&["start", "--wait", "late", "tell", "value=9"]).expect_code(0);
    reader.ctl(&["start", "--wait", "far", "hear", "wanted=9"]).expect_code(0);
}
