//! Many components in one daemon.

use std::path::Path;
use std::time::Duration;

use genom_tests::{Footprint, Home, Many};

#[test]
fn one_library_runs_under_many_names_and_values_go_through_all_of_them() {
    let made = tempfile::tempdir().unwrap();
    let text = Many { components: 20, chained: true, cells: 0 }.configuration("local", made.path());
    let daemon = Home::new().configured(&text).start(&[]);
    assert_eq!(daemon.json(&["list"])["components"].as_array().map(Vec::len), Some(20));
    for reader in ["m0", "m1", "m19"] {
        daemon.ctl(&["start", "--wait", reader, "hear"]).expect_code(0);
    }
}

/// Resources of a daemon with this many components on shared memory, while all of them write.
fn on_shm(components: usize, chained: bool) -> (Footprint, usize) {
    let made = tempfile::tempdir().unwrap();
    let text = Many { components, chained, cells: 0 }.configuration("shm", made.path());
    // Both the soft and the hard limit, so that the daemon cannot raise it.
    let daemon = Home::new().configured(&text).start_by(&["prlimit", "--nofile=1024:1024"], &[]);
    let last = format!("m{}", components - 1);
    let activity = if chained { "hear" } else { "reach" };
    daemon.ctl(&["start", "--wait", &last, activity, "steps=3"]).expect_code(0);
    let held = Footprint::of(daemon.process().id());
    let segments = daemon.home().memory().files();
    let segments =
        segments.iter().filter(|file| file.parent() == Some(Path::new("/dev/shm"))).count();
    let (_, home) = daemon.stop("TERM");
    assert_eq!(home.memory().files(), Vec::<std::path::PathBuf>::new());
    (held, segments)
}

/// Cost of each component: descriptors, segments and KiB.
fn each(components: usize, chained: bool) -> (f64, f64, u64) {
    let ((few, few_segments), (many, many_segments)) =
        (on_shm(2, chained), on_shm(components, chained));
    let more = components - 2;
    let of = |few: usize, many: usize| (many - few) as f64 / more as f64;
    let (files, segments) =
        (of(few.descriptors, many.descriptors), of(few_segments, many_segments));
    (files, segments, (many.resident - few.resident) / more as u64)
}

#[test]
fn sixty_components_on_shm_fit_a_limit_of_1024_files() {
    // Each has four out ports, including that of its state, and thirteen services.
    let (files, segments, resident) = each(60, false);
    assert!(files < 10., "{files} descriptors a component");
    assert!(segments < 5., "{segments} segments a component");
    assert!(resident < 1024, "{resident} KiB a component");
}

#[test]
fn components_that_read_each_other_on_shm_hold_what_their_connections_need() {
    let (files, segments, resident) = each(16, true);
    assert!(files < 22., "{files} descriptors a component");
    assert!(segments < 9., "{segments} segments a component");
    assert!(resident < 1024, "{resident} KiB a component");
}

#[test]
fn a_limit_of_files_that_is_too_low_is_named_with_the_way_out() {
    let made = tempfile::tempdir().unwrap();
    let text = Many { components: 60, chained: false, cells: 0 }.configuration("shm", made.path());
    let home = Home::new().configured(&text);
    let daemon = home.spawn_by(&["prlimit", "--nofile=256:256"], &[]).finish();
    daemon.expect_code(1).expect_err("this process may have 256 files open, and has them");
    assert_eq!(home.memory().files(), Vec::<std::path::PathBuf>::new());
}

#[test]
fn components_stop_side_by_side() {
    // Each has a task at 10 Hz; waiting for their ticks one after the other would take 0.2 s for
    // each.
    let made = tempfile::tempdir().unwrap();
    for chained in [false, true] {
        let text = Many { components: 100, chained, cells: 0 }.configuration("local", made.path());
        let daemon = Home::new().configured(&text).start(&[]);
        daemon.process().signal("TERM");
        let (stopped, _) = daemon.finish_within(Duration::from_secs(10));
        stopped.expect_code(0);
    }
}
