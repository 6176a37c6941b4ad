//! Rules of supervision: what is told and done when a component breaks them, in the daemon's own
//! process and in cells.

use std::time::Instant;

use genom_tests::{Daemon, Home, component, path, request, until};
use serde_json::{Value, json};

use super::{cell, mission};
use crate::control_plane::metrics::metrics;

/// `dawdles`, supervised, beside a demo.
fn supervised(of_dawdles: &str, rules: &str) -> String {
    let (demo, dawdles) = (component("demo").library, component("dawdles").library);
    format!(
        "[[component]]\nlibrary = {demo:?}\n\
         [[component]]\nlibrary = {dawdles:?}\n{of_dawdles}\n{rules}"
    )
}

fn rule(text: &str) -> String {
    format!("[[component.supervision]]\n{text}\n")
}

#[track_caller]
fn violation(events: &mut genom_tests::Events) -> Value {
    events.wait_for(|e| e["event"] == "supervision_violated")
}

#[test]
fn an_endless_codel_in_a_cell_is_ended_and_its_component_comes_back_as_it_was_while_others_go_on() {
    let rules = rule("stuck = true\nreaction = \"restart\"");
    let config = supervised("cell = \"arm\"", &rules) + "[cells]\nrestart_delay = 0.0\n";
    let daemon = Home::new().configured(&config).start(&["--set", "stuck_after=1"]);
    daemon.ctl(&["call", "dawdles", "set_pace", "pace=7"]).expect_code(0);
    daemon.ctl(&["start", "demo", "goto", "goal=10"]).expect_code(0);
    let mut events = daemon.events();
    daemon.ctl(&["start", "dawdles", "compute"]).expect_code(0);
    let told = violation(&mut events);
    assert_eq!((&told["component"], &told["kind"]), (&json!("dawdles"), &json!("deadline")));
    let what = told["what"].as_str().unwrap();
    assert!(what.starts_with("codel dawdles_compute of compute has not returned"), "{what}");
    // In any order: the report is written while the cell starts again.
    let (mut ended, mut crashed) = (Value::Null, Value::Null);
    while ended.is_null() || crashed.is_null() {
        let next = events.wait_for(|e| e["event"] == "cell_ended" || e["event"] == "cell_crashed");
        let place = if next["event"] == "cell_ended" { &mut ended } else { &mut crashed };
        *place = next;
    }
    let why = ended["why"].as_str().unwrap();
    assert!(why.contains("ended by its supervision: deadline supervision of dawd"), "{why}");
    assert_eq!(ended["restarts"], true);
    // The report shows where the codel was.
    assert!(crashed["codel"].as_str().unwrap().contains("dawdles_compute"), "{crashed}");
    let report = daemon.json(&["crashes", crashed["report"].as_str().unwrap()]).to_string();
    assert!(report.contains("dawdles_compute"), "{report}");
    until("it is back", || cell(&daemon, "arm")["state"] == "running");
    assert_eq!(daemon.json(&["call", "dawdles", "get_pace"])["result"]["pace"], 7);
    // The activity of its neighbour was not touched.
    let activities = daemon.json(&["activities", "demo"]).to_string();
    assert!(activities.contains("\"running\""), "{activities}");
}

#[test]
fn an_endless_codel_in_the_daemon_s_own_process_is_told_and_others_are_served() {
    let rules = rule(
        "codel = \"dawdles_compute\"\nlongest_ms = 20\nreaction = [\"interrupt\", \
                      { call = \"demo/set_speed\", inputs = { velocity = 0.5 } }]",
    );
    let daemon = Home::new().configured(&supervised("", &rules)).start(&[]);
    let mut events = daemon.events();
    daemon.ctl(&["start", "dawdles", "compute"]).expect_code(0);
    let told = violation(&mut events);
    assert_eq!(told["activity"], 3);
    assert_eq!(told["reactions"], json!(["interrupt", "call demo/set_speed"]));
    let done = events.wait_for(|e| e["event"] == "failure_reaction");
    assert_eq!((&done["reaction"], &done["error"]), (&json!("call demo/set_speed"), &Value::Null));
    let speed = daemon.json(&["call", "demo", "get_speed"])["result"]["velocity"].clone();
    assert_eq!(speed, json!(0.5));
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    daemon.ctl(&["call", "dawdles", "set_pace", "pace=3"]).expect_code(0);
    let list = daemon.json(&["list"]);
    let rules = &list["components"][1]["supervision"];
    assert_eq!(rules[0]["rule"], "codel dawdles_compute takes more than 20 ms");
    assert_eq!(rules[0]["violations"], 1);
    daemon.ctl(&["why", "demo/parameter"]).expect_code(0);
    let doctor = daemon.ctl(&["doctor", "--json"]).out;
    assert!(doctor.contains("dawdles broke a rule of its deadline supervision once"), "{doctor}");
    let metrics = metrics(&daemon);
    assert!(metrics.contains("genom_supervision_violations_total{component=\"dawdles\""));
    // It never returns: the daemon leaves it behind.
    let (stopped, _) = daemon.stop("INT");
    stopped.expect_code(4);
}

#[test]
fn a_cell_has_its_daemon_call_others_for_it_and_calls_its_own_components_itself() {
    let rules = rule(
        "codel = \"dawdles_work\"\nwcet = true\nreaction = [{ fire = \"demo/emergency\" }, \
         { call = \"dawdles/set_pace\", inputs = { pace = 9 } }, { call = \"nobody/stop\" }]",
    );
    let daemon = Daemon::demo("local");
    let dawdles = component("dawdles").library;
    let parsed: toml::Value = toml::from_str(&rules).unwrap();
    let rules = &parsed["component"]["supervision"];
    let load = json!({"library": dawdles, "cell": "arm", "supervision": rules});
    let loaded = request(&daemon.home().socket(), "POST", "/components", &load.to_string());
    assert_eq!(loaded.status, 201, "{loaded:?}");
    let mut events = daemon.events();
    daemon.ctl(&["start", "dawdles", "work", "ms=20"]).expect_code(0);
    assert_eq!(violation(&mut events)["rule"], "codel dawdles_work takes more than its wcet");
    let mut done = Vec::new();
    while done.len() < 3 {
        let told = events.wait_for(|e| e["event"] == "failure_reaction");
        let reaction = told["reaction"].as_str().unwrap().to_owned();
        if !done.contains(&(reaction.clone(), told["error"].is_null())) {
            done.push((reaction, told["error"].is_null()));
        }
    }
    done.sort();
    let wanted = ["call dawdles/set_pace", "call nobody/stop", "fire demo/emergency"];
    let wanted: Vec<_> =
        wanted.iter().map(|one| ((*one).to_owned(), !one.contains("nob"))).collect();
    assert_eq!(done, wanted);
    assert_eq!(daemon.json(&["call", "dawdles", "get_pace"])["result"]["pace"], 9);
    daemon.ctl(&["stop"]).expect_code(0);
    // What runs is written with its rules.
    let dumped = daemon.ctl(&["dump"]).out;
    assert!(dumped.contains("[[component.supervision]]") && dumped.contains("wcet = true"));
}

#[test]
fn orders_periods_and_times_of_activities_are_supervised_and_told_no_more_than_once_a_second() {
    let rules = rule("codel = \"dawdles_drive\"\nafter = \"dawdles_calibrate\"")
        + &rule("task = \"steady\"\nmissed = 3\nwithin_ms = 500\nreaction = \"log\"")
        + &rule("activity = \"idle\"\nlongest_ms = 50\nreaction = \"interrupt\"")
        + &rule("codel = \"dawdles_work\"\nlongest_ms = 1");
    let daemon = Home::new().configured(&supervised("", &rules)).start(&[]);
    let mut events = daemon.events();
    daemon.ctl(&["call", "dawdles", "drive"]).expect_code(0);
    let early = violation(&mut events);
    assert_eq!(
        early["what"],
        "codel dawdles_drive of drive was called before codel dawdles_calibrate"
    );
    daemon.ctl(&["call", "dawdles", "calibrate"]).expect_code(0);
    daemon.ctl(&["call", "dawdles", "drive"]).expect_code(0);
    let idle = daemon.ctl(&["call", "dawdles", "idle"]);
    idle.expect_code(0);
    let late = violation(&mut events);
    assert_eq!((&late["kind"], &late["index"]), (&json!("deadline"), &json!(2)));
    let began = Instant::now();
    daemon.ctl(&["start", "dawdles", "work", "ms=11"]).expect_code(0);
    daemon.process().error_line_where(|line| line.contains("alive supervision")).unwrap();
    let counts = || {
        let listed = daemon.json(&["list"]);
        let rules = listed["components"][1]["supervision"].as_array().unwrap().clone();
        rules.iter().map(|rule| rule["violations"].as_u64().unwrap()).collect::<Vec<_>>()
    };
    until("the codel was late many times", || counts()[3] >= 20);
    assert_eq!((counts()[0], counts()[2]), (1, 1));
    daemon.ctl(&["unload", "dawdles"]).expect_code(0);
    let all = events.until(|e| e["event"] == "component_unloaded");
    let told = all.iter().filter(|e| e["index"] == 3).count();
    let most = 2 + usize::try_from(began.elapsed().as_secs()).unwrap();
    assert!((1..=most).contains(&told), "{told}, and {most} at most");
}

#[test]
fn rules_that_fit_no_component_are_refused_with_what_was_meant_before_anything_runs() {
    for (of_dawdles, text, why) in [
        ("", "task = \"stedy\"\nmissed = 3", "dawdles has no task `stedy`; did you mean `steady`?"),
        ("", "task = \"aside\"\nmissed = 3", "task aside has no period"),
        ("", "codel = \"dawdles_wrok\"\nlongest_ms = 1", "did you mean `dawdles_work`?"),
        ("", "activity = \"drive\"\nlongest_ms = 1", "dawdles has no activity `drive`"),
        ("", "codel = \"dawdles_rest\"\nwcet = true", "say `longest_ms`"),
        ("", "codel = \"dawdles_drive\"\nafter = \"dawdles_drive\"", "cannot come after itself"),
        ("", "codel = \"dawdles_idle\"\nnever_while = \"idle\"", "is a codel of idle itself"),
        ("", "activity = \"idle\"\nfrom = \"strat\"\nto = \"main\"", "did you mean `start`?"),
        ("", "activity = \"idle\"\nfrom = \"main\"\nto = \"start\"", "allows no such step"),
        ("", "activity = \"idle\"\nfrom = \"main\"\nto = \"main\"", "takes no step"),
        ("", "codel = \"dawdles_drive\"\nlongest_ms = 1\nreaction = \"interrupt\"", "no activity"),
        ("", "stuck = true\nreaction = \"restart\"", "put it into a cell (cell = \"dawdles\")"),
        (
            "cell = \"arm\"",
            "stuck = true\nreaction = { call = \"demo/stpo\" }",
            "no service `stpo`",
        ),
    ] {
        let home = Home::new().configured(&supervised(of_dawdles, &rule(text)));
        home.refused(&["--check"]).expect_code(1).expect_err(why);
        home.refused(&[]).expect_code(2).expect_err("component.supervision").expect_err(why);
    }
    for (text, why) in [
        ("longest_ms = 1", "supervision says no rule"),
        ("codel = \"a\"\nlongest_ms = 0", "`longest_ms` is 0"),
        ("task = \"steady\"\nmissed = 1001", "from 1 to 1000"),
        ("stuck = true\nreaction = \"restrat\"", "did you mean `restart`?"),
    ] {
        let home = Home::new().configured(&supervised("", &rule(text)));
        home.refused(&[]).expect_code(2).expect_err(why);
    }
    let many = rule("stuck = true").repeat(33);
    let home = Home::new().configured(&supervised("", &many));
    home.refused(&[]).expect_code(2).expect_err("33 rules, and 32 are the most");
    // Over the control plane.
    let daemon = Daemon::start(&[]);
    let library = component("dawdles").library;
    let load = json!({"library": library, "supervision": {"task": "steady", "longest_stop_ms": 3}});
    let refused = request(&daemon.home().socket(), "POST", "/components", &load.to_string());
    assert_eq!((refused.status, refused.code()), (422, "bad_input"), "{refused:?}");
    let load = json!({"library": library, "supervision": {"task": "stedy", "missed": 3}});
    let refused = request(&daemon.home().socket(), "POST", "/components", &load.to_string());
    assert!(
        refused.code() == "bad_input" && refused.body.to_string().contains("/supervision"),
        "{refused:?}"
    );
    daemon.ctl(&["load", path(&library)]).expect_code(0);
}

#[test]
fn components_that_keep_their_rules_are_not_told_of() {
    let calm = mission("").replacen(
        "cell = \"base\"\n",
        "cell = \"base\"\nsupervision = [{ wcet = false, stuck = true, reaction = \"restart\" }, \
         { task = \"main\", missed = 1000, within_ms = 1000 }]\n",
        1,
    );
    let daemon = Home::new().configured(&calm).start(&[]);
    daemon.ctl(&["wait-ready", "--deployed"]).expect_code(0);
    daemon.ctl(&["call", "mission", "patrol", "rounds=1"]).expect_code(0);
    let listed = daemon.json(&["list"]).to_string();
    assert!(
        listed.contains("\"violations\":0") && !listed.contains("\"violations\":1"),
        "{listed}"
    );
    assert_eq!(cell(&daemon, "base")["starts"], 1);
}

#[test]
fn a_codel_that_takes_no_signal_does_not_keep_its_cell_either() {
    let rules = rule("codel = \"dawdles_deaf\"\nlongest_ms = 20\nreaction = \"restart\"");
    let config = supervised("cell = \"arm\"", &rules) + "[cells]\nrestart_delay = 0.0\n";
    let daemon = Home::new().configured(&config).start(&[]);
    let mut events = daemon.events();
    daemon.ctl(&["start", "dawdles", "deaf"]).expect_code(0);
    let ended = events.wait_for(|e| e["event"] == "cell_ended");
    assert!(ended["why"].as_str().unwrap().contains("codel dawdles_deaf of deaf has not returned"));
    until("it is back", || cell(&daemon, "arm")["state"] == "running");
}

#[test]
fn a_cell_whose_daemon_is_gone_ends_an_endless_codel_itself_and_the_next_daemon_starts_it() {
    let rules = rule("stuck = true\nreaction = \"restart\"");
    let config = supervised("cell = \"arm\"", &rules);
    let home = Home::new().configured(&config);
    let daemon = home.start(&["--set", "stuck_after=1"]);
    let pid = cell(&daemon, "arm")["pid"].as_u64().unwrap();
    daemon.ctl(&["start", "dawdles", "compute"]).expect_code(0);
    let home = daemon.abandon();
    let gone = || {
        let status = std::fs::read_to_string(format!("/proc/{pid}/status"));
        status.is_ok_and(|status| status.contains("State:\tZ"))
            || !std::path::Path::new(&format!("/proc/{pid}")).exists()
    };
    until("the process has ended", gone);
    let daemon = home.start(&[]);
    let back = cell(&daemon, "arm");
    assert!(back["state"] == "running" && back["pid"] != pid, "{back}");
    daemon.ctl(&["call", "dawdles", "get_pace"]).expect_code(0);
}
