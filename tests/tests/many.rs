//! Many components in one daemon.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::unwrap_used, reason = "helpers of tests fail them")]

use genom_tests::{Home, Many};

#[test]
fn one_library_runs_under_many_names_and_values_go_through_all_of_them() {
    let made = tempfile::tempdir().unwrap();
    let text = Many { components: 20, chained: true }.configuration("local", made.path());
    let daemon = Home::new().configured(&text).start(&[]);
    assert_eq!(daemon.json(&["list"])["components"].as_array().map(Vec::len), Some(20));
    for reader in ["m0", "m1", "m19"] {
        daemon.ctl(&["start", "--wait", reader, "hear"]).expect_code(0);
    }
}
