//! Errors of codels in Python end the activity or the request, and are told with their lines.

use genom_tests::until;

use super::{how, started, started_with};

#[test]
fn a_declared_exception_is_raised_with_its_detail() {
    let (daemon, _scratch) = started(&[]);
    let called = daemon.ctl(&["call", "axis", "how", "what=refuse"]);
    called.expect_code(1).expect_err("ended with ::axis::REFUSED {\"code\":7}");
    daemon.ctl(&["call", "axis", "how", "what=no"]).expect_code(0).expect_out("tries = 2\n");
    let (finished, _) = daemon.stop("TERM");
    assert!(
        !finished.err.contains("Traceback") && !finished.err.contains("ERROR"),
        "{}",
        finished.err
    );
}

#[test]
fn an_exception_that_is_not_declared_is_unkex_and_its_lines_are_in_the_log() {
    let (daemon, _scratch) = started(&[]);
    let unkex = "ended with ::genom::unkex {\"what\":\"ZeroDivisionError: ";
    for verb in ["how", "run"] {
        let called = daemon.ctl(&["call", "axis", verb, "what=divide"]);
        called.expect_code(1).expect_err(unkex).expect_err("(axis.py:32)\"}");
    }
    let called = daemon.ctl(&["call", "axis", "how", "what=sys.exit"]);
    called.expect_code(1).expect_err("::genom::unkex {\"what\":\"SystemExit: 3 (axis.py:");
    // The next one is served as if nothing had been.
    daemon.ctl(&["call", "axis", "how", "what=no"]).expect_code(0);
    let logged = || daemon.ctl(&["logs"]).out;
    until("the cell's log is told on", || logged().contains("axis_run"));
    let (finished, _) = daemon.stop("TERM");
    for line in [
        "codel axis_how (",
        "axis.gen:12) of service how raised an exception that the description does not declare:",
        "axis.py\", line 18, in axis_how",
        "n.value = divided(1, 0)",
        "axis.py\", line 32, in divided",
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
        .expect_err("::genom::unkex {\"what\":\"axis_run returned 4 (axis.py:35)\"}");
    let (finished, _) = daemon.stop("TERM");
    finished.expect_err("axis.py:35, returned 4; it may return 'pause::start', 'ether'");
}

#[test]
fn an_exception_in_stop_ends_the_activity() {
    let (daemon, _scratch) = started(&[]);
    let mut events = daemon.events();
    let waiting = daemon.spawn(&["start", "--wait", "axis", "run", "what=stop"]);
    events.wait_for(|e| e["state"] == "start" && e["paused"] == true);
    daemon.ctl(&["abort", "axis", "run"]).expect_code(0);
    let ended = waiting.finish();
    ended
        .expect_code(1)
        .expect_err("::genom::unkex {\"what\":\"ValueError: it does not stop (axis.py:");
}

#[test]
fn what_a_codel_prints_is_no_harm_and_megabytes_are_told_once_with_their_line() {
    let (daemon, _scratch) = started(&[]);
    daemon.ctl(&["call", "axis", "how", "what=print"]).expect_code(0).expect_out("tries = 1\n");
    daemon.ctl(&["call", "axis", "how", "what=print"]).expect_code(0).expect_out("tries = 2\n");
    let (finished, _) = daemon.stop("TERM");
    let told = "more than 1 MiB is printed in a second";
    finished.expect_err("axis.py\", line 26, in axis_how");
    assert_eq!(finished.err.matches(told).count(), 1, "{}", finished.err);
}

#[test]
fn a_codel_that_does_not_return_is_told_with_the_line_where_it_is() {
    let (daemon, _scratch) = started(&["--set", "stuck_after=1"]);
    daemon.ctl(&["start", "axis", "run", "what=block"]).expect_code(0);
    let told = daemon.process().error_line_where(|line| line.contains("time.sleep(3600)"));
    assert!(told.is_some());
    // Its requests are served, too.
    daemon.ctl(&["call", "axis", "how", "what=no"]).expect_code(0);
}

#[test]
fn a_view_that_a_codel_keeps_is_told_once_with_the_line() {
    let (daemon, _scratch) = started(&[]);
    for _ in 0..3 {
        daemon.ctl(&["call", "axis", "run", "what=keep"]).expect_code(0);
    }
    let (finished, _) = daemon.stop("TERM");
    let told = "keeps a view of `at` in `kept` after its call";
    finished
        .expect_err("axis.gen:")
        .expect_err("of service run, ")
        .expect_err("axis.py:43, keeps a view");
    assert_eq!(finished.err.matches(told).count(), 1, "{}", finished.err);
}

#[test]
fn what_is_printed_to_standard_error_counts_and_what_goes_past_python_does_not() {
    let more = "    if what == \"complain\":
        print(\"x\" * 3_000_000, file=sys.stderr)
    if what == \"raw\":
        os.write(1, b\"x\" * 3_000_000)
";
    let (daemon, _scratch) = started_with(&how(more), &[]);
    for what in ["what=raw", "what=complain"] {
        daemon.ctl(&["call", "axis", "how", what]).expect_code(0);
    }
    let (finished, _) = daemon.stop("TERM");
    finished.expect_err("axis.py\", line 16, in axis_how");
    let told = "more than 1 MiB is printed in a second";
    assert_eq!(finished.err.matches(told).count(), 1);
}
