//! Errors of codels in Lua end the activity or the request, and are told with their lines.

use genom_tests::until;

use super::started;

#[test]
fn a_declared_exception_is_raised_with_its_detail() {
    let (daemon, _scratch) = started(&[]);
    let called = daemon.ctl(&["call", "axis", "how", "what=refuse"]);
    called.expect_code(1).expect_err("ended with ::axis::REFUSED {\"code\":7}");
    daemon.ctl(&["call", "axis", "how", "what=no"]).expect_code(0).expect_out("tries = 2\n");
    let (finished, _) = daemon.stop("TERM");
    assert!(!finished.err.contains("ERROR"), "{}", finished.err);
}

#[test]
fn an_error_that_is_not_declared_is_unkex_and_its_lines_are_in_the_log() {
    let (daemon, _scratch) = started(&[]);
    for (what, told) in [
        ("divide", "attempt to divide by zero (axis.lua:6)"),
        ("exit", "os.exit would end the cell: a codel returns its event (axis.lua:20)"),
        ("range", "2147483648 is no long: -2147483648 to 2147483647 (axis.lua:21)"),
        ("member", "::axis::REFUSED has no member `cod` (axis.lua:23)"),
    ] {
        let called = daemon.ctl(&["call", "axis", "how", &format!("what={what}")]);
        called.expect_code(1).expect_err(&format!("::genom::unkex {{\"what\":\"{told}\"}}"));
    }
    // The next one is served as if nothing had been, and a script may catch its errors.
    daemon.ctl(&["call", "axis", "how", "what=caught"]).expect_code(0).expect_out("tries = 5\n");
    let logged = || daemon.ctl(&["logs"]).out;
    until("the cell's log is told on", || logged().contains("has no member `cod`"));
    let (finished, _) = daemon.stop("TERM");
    for line in [
        "codel axis_how (",
        "axis.gen:12) of service how raised an error that the description does not declare:",
        "axis.lua:6: in upvalue 'divided'",
        "axis.lua:19: in function",
    ] {
        finished.expect_err(line);
    }
}

#[test]
fn what_is_no_event_ends_the_activity_and_is_told() {
    let (daemon, _scratch) = started(&[]);
    let called = daemon.ctl(&["call", "axis", "run", "what=type"]);
    called
        .expect_code(1)
        .expect_err("::genom::unkex {\"what\":\"axis_run returned 4 (axis.lua:30)\"}");
    let called = daemon.ctl(&["call", "axis", "run", "what=yield"]);
    called.expect_code(1).expect_err("::genom::unkex {\"what\":\"attempt to yield from outside");
    let (finished, _) = daemon.stop("TERM");
    finished.expect_err("axis.lua:30, returned 4; it may return `pause::start`, `ether`");
}

#[test]
fn an_error_in_stop_ends_the_activity() {
    let (daemon, _scratch) = started(&[]);
    let mut events = daemon.events();
    let waiting = daemon.spawn(&["start", "--wait", "axis", "run", "what=stop"]);
    events.wait_for(|e| e["state"] == "start" && e["paused"] == true);
    daemon.ctl(&["abort", "axis", "run"]).expect_code(0);
    waiting
        .finish()
        .expect_code(1)
        .expect_err("::genom::unkex {\"what\":\"it does not stop (axis.lua:");
}

#[test]
fn what_a_codel_prints_is_no_harm() {
    let (daemon, _scratch) = started(&[]);
    daemon.ctl(&["call", "axis", "how", "what=print"]).expect_code(0).expect_out("tries = 1\n");
}

#[test]
fn a_view_that_a_codel_kept_cannot_be_used() {
    let (daemon, _scratch) = started(&[]);
    daemon.ctl(&["call", "axis", "run", "what=keep"]).expect_code(0);
    let used = daemon.ctl(&["call", "axis", "run", "what=kept"]);
    used.expect_code(1)
        .expect_err("has returned: keep values, not views (genom.copy) (axis.lua:34)");
}

#[test]
fn a_codel_that_does_not_return_is_told() {
    let (daemon, _scratch) = started(&["--set", "stuck_after=1"]);
    daemon.ctl(&["start", "axis", "run", "what=block"]).expect_code(0);
    let told = daemon.process().error_line_where(|line| line.contains("axis.lua:32: in function"));
    assert!(told.is_some());
}
