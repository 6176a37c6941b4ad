//! Many components in one daemon: work that is done once for all of them, and limits of the system
//! that they may reach.

use genom_tests::{Footprint, Many};
use genom_tests::{Home, path};

/// More components than a daemon with 64 file descriptors can have.
const ALL: Many = Many { components: 20, chained: false, cells: 0 };

#[test]
fn one_library_under_many_names_is_read_and_compared_once_until_it_changes() {
    let made = tempfile::tempdir().unwrap();
    let few = Many { components: 12, chained: false, cells: 0 };
    let text = few.configuration("local", made.path());
    let daemon = Home::new().configured(&text).start(&["--log", "debug"]);
    let (library, description) = (made.path().join("many.so"), made.path().join("many.gen"));
    let load = |name: &str| daemon.ctl(&["load", path(&description), "--name", name]);
    load("again").expect_code(0);
    // Rewritten with the same contents it counts as the same; with other contents it does not.
    std::fs::copy(&library, made.path().join("copy")).unwrap();
    std::fs::rename(made.path().join("copy"), &library).unwrap();
    load("copied").expect_code(0);
    let source = std::fs::read_to_string(&description).unwrap();
    std::fs::write(&description, source.replace("double gain;", "float gain;")).unwrap();
    load("refused").expect_code(1).expect_err("gain");
    std::fs::write(&description, source).unwrap();
    load("restored").expect_code(0);
    let (stopped, _) = daemon.stop("TERM");
    stopped.expect_code(0);
    let said = |what: &str| stopped.err.lines().filter(|line| line.contains(what)).count();
    assert_eq!(said("many.gen: read"), 3, "at first, changed, and changed back");
    assert_eq!(said("many.so: compared with its description"), 3);
}

#[test]
fn as_many_files_are_open_as_the_administrator_allows() {
    let made = tempfile::tempdir().unwrap();
    let text = ALL.configuration("shm", made.path());
    let by = ["prlimit", "--nofile=64:"];
    let daemon = Home::new().configured(&text).start_by(&by, &[]);
    assert!(Footprint::of(daemon.process().id()).descriptors > 64);
    daemon.stop("TERM").0.expect_code(0);
}

#[test]
fn a_limit_of_files_that_is_reached_is_named_with_the_way_out() {
    let made = tempfile::tempdir().unwrap();
    let text = ALL.configuration("shm", made.path());
    let home = Home::new().configured(&text);
    let refused = home.spawn_by(&["prlimit", "--nofile=96:96"], &[]).finish();
    refused.expect_code(1).expect_err("this process may have 96 files open");
    refused.expect_err("LimitNOFILE=");
}
