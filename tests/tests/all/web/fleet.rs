//! Other daemons, as the overview shows them.

use std::sync::Arc;

use genom_tests::browser::Browser;
use genom_tests::{Home, Memory};

use super::visitor::link;

#[test]
fn daemons_that_are_seen_over_zenoh_are_listed_and_those_that_went_are_told() {
    let memory = Arc::new(Memory::new());
    let named = |name| ["--backend", "zenoh", "--daemon", name];
    let robot = Home::with(&memory).start(&named("robot"));
    let desk = Home::with(&memory).start(&[&["--web"][..], &named("desk")].concat());
    let browser = Browser::start(1280, 900, &[]);
    browser.open(&link(&desk, &["--rights", "read"]));
    let state = |name| {
        format!("document.querySelector('[data-daemon={name}] [data-label=State]')?.innerText")
    };
    browser.until("the robot is seen", &format!("{} === 'visible'", state("robot")));
    browser.until("the desk is itself", &format!("{} === 'this daemon'", state("desk")));
    browser.until_shown("genomctl --host zenoh:robot web");
    robot.stop("TERM").0.expect_code(0);
    browser.until("it is gone", &format!("{}.startsWith('gone since')", state("robot")));
}
