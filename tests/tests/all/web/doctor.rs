//! The page of findings in a real browser: why a port is silent, and what mends it.

use genom_tests::browser::Browser;
use genom_tests::{Daemon, Home, component, path, until, until_answer};
use serde_json::json;

use super::visitor::{Visitor, link, set_speed};

const ENTER: &str = "\u{E007}";

/// An axis, and a mission whose ports fit.
fn daemon() -> Daemon {
    let (demo, mission) = (component("demo"), component("mission"));
    Home::new().start(&["--web", path(&demo.library), path(&mission.library)])
}

fn open(daemon: &Daemon, rights: &[&str], at: &str) -> Browser {
    let browser = Browser::start(1280, 900, &[]);
    browser.open(&link(daemon, rights));
    browser.until_shown("Overview");
    let origin = browser.ask("return location.origin");
    browser.open(&format!("{}{at}", origin.as_str().unwrap()));
    browser
}

#[test]
fn a_silent_port_is_connected_with_the_button_of_its_finding() {
    let daemon = daemon();
    let browser = Browser::start(1280, 900, &[]);
    browser.open(&link(&daemon, &[]));
    browser.click("a[href='/component/mission']");
    browser.click("[data-port='mission/position'] button");
    browser.click("a[href='/doctor?port=mission%2Fposition']");
    browser.until_shown("mission/position is not connected");
    let port = browser.ask("return new URLSearchParams(location.search).get('port')");
    assert_eq!(port, "mission/position", "the address can be shared");
    // Out ports of another type are not offered.
    let offered =
        "return [...document.querySelectorAll('#why select option')].map((one) => one.value)";
    assert_eq!(browser.ask(offered), json!(["demo/position"]));
    browser.press("[data-does='Connect mission/position']", ENTER);
    until_answer(&json!("demo/position"), || {
        daemon.json(&["connections"])["connections"][0]["out"].clone()
    });
    browser.until_shown("Data flows: mission/position was last read");
}

/// Chooses a port in the form.
fn choose(browser: &Browser, port: &str) {
    let there = format!("document.querySelector('#port option[value=\"{port}\"]')");
    browser.until("the port is offered", &there);
    browser.with("document.getElementById('port').value = arguments[0]", vec![json!(port)]);
    browser.ask("document.getElementById('port').dispatchEvent(new Event('change'))");
}

#[test]
fn what_would_write_a_port_is_started_with_the_button_and_what_to_look_at_next_is_a_link() {
    let daemon = daemon();
    daemon.ctl(&["connect", "demo/parameter", "mission/gain"]).expect_code(0);
    let browser = open(&daemon, &[], "/doctor");
    // It is read while the axis moves only.
    choose(&browser, "demo/parameter");
    browser.until_shown("demo/parameter read nothing from mission/gain yet");
    browser.click("a[href='/doctor?port=mission%2Fgain']");
    browser.until_shown("Data flows: mission/gain was last written");
    until("nothing writes it any more", || {
        daemon.json(&["why", "demo/position"])["findings"] != json!([])
    });
    set_speed(&daemon, "0.01");
    choose(&browser, "demo/position");
    browser.until_shown("and no activity runs");
    browser.press("[data-does='Start goto of demo']", ENTER);
    browser.until_shown("Data flows: demo/position was last written");
    assert_eq!(daemon.json(&["activities", "demo"])["activities"][0]["service"], "goto");
}

#[test]
fn a_connection_to_nobody_is_removed_and_a_port_of_the_form_is_chosen() {
    let daemon = daemon();
    daemon.ctl(&["connect", "--wait", "mission/position", "nobody/position"]).expect_code(0);
    let browser = open(&daemon, &[], "/doctor");
    choose(&browser, "mission/position");
    browser.until_shown("nobody publishes nobody/position");
    assert_eq!(browser.ask("return location.search"), "?port=mission%2Fposition");
    // What removes something is asked about once more.
    browser.click("[data-does='Disconnect mission/position']");
    browser.until_shown("press again to do it");
    assert_eq!(daemon.json(&["connections"])["connections"].as_array().unwrap().len(), 1);
    browser.click("[data-does='Disconnect mission/position']");
    browser.until_shown("mission/position is not connected");
    assert_eq!(daemon.json(&["connections"])["connections"], json!([]));
}

#[test]
fn a_cell_that_is_down_is_a_finding_whose_button_starts_it_again() {
    let demo = component("demo");
    let daemon = Home::new().start(&["--web"]);
    let loaded = ["load", path(&demo.library), "--cell", "arm", "--restart", "never"];
    daemon.ctl(&loaded).expect_code(0);
    let pid = || daemon.json(&["cells"])["cells"][0]["pid"].clone();
    assert!(genom_tests::signal(pid(), "KILL"));
    until("the cell is down", || daemon.json(&["cells"])["cells"][0]["state"] == "failed");
    let browser = open(&daemon, &[], "/doctor");
    browser.until_shown("cell arm is down");
    let told = daemon.ctl(&["doctor"]);
    assert!(told.out.contains("problem  cells: cell arm is down: signal 9"), "{}", told.out);
    browser.click("[data-does='Start cell arm again']");
    until("it runs", || daemon.json(&["cells"])["cells"][0]["state"] == "running");
    browser.until("the finding is gone", "!document.body.innerText.includes('cell arm is down')");
}

#[test]
fn findings_are_those_of_genomctl_doctor() {
    let daemon = daemon();
    let browser = open(&daemon, &["--rights", "read"], "/doctor");
    browser.until("it was examined", "document.querySelector('#findings details')");
    let visitor = Visitor::with_link(&link(&daemon, &["--rights", "read"]));
    let own = visitor.gets("/api/doctor?daemon_only=true").json();
    assert_eq!(own["machine"], json!([]));
    // Ticks are missed all the while on a busy machine: how many does not count.
    let plain = |text: &str| text.replace(|sign: char| sign.is_ascii_digit(), "");
    let told = plain(&daemon.ctl(&["doctor"]).out);
    for finding in own["daemon"].as_array().unwrap() {
        let what = plain(finding["what"].as_str().unwrap());
        assert!(told.contains(&what), "{what} is not in {told}");
    }
    let whole = visitor.gets("/api/doctor").json();
    let machine: Vec<_> =
        whole["machine"].as_array().unwrap().iter().map(|one| one["about"].clone()).collect();
    for about in ["shared memory", "loopback", "multicast", "clock"] {
        assert!(machine.contains(&json!(about)), "{machine:?}");
    }
    browser.click("#findings summary");
    browser.until_shown("clock source");
}

#[test]
fn whoever_may_only_read_is_told_and_offered_nothing() {
    let daemon = daemon();
    let browser = open(&daemon, &["--rights", "read"], "/doctor?port=mission/position");
    browser.until_shown("mission/position is not connected");
    browser.until_shown("genomctl connect mission/position COMPONENT/PORT");
    assert_eq!(browser.ask("return document.querySelectorAll('[data-does]').length"), 0);
    // The same request, made without the button.
    let visitor = Visitor::with_link(&link(&daemon, &["--rights", "read"]));
    let why = visitor.gets("/api/components/mission/ports/position/why").json();
    let remedy = &why["findings"][0]["remedies"][0];
    assert_eq!(remedy["right"], "wire", "{why}");
    let path = format!("/api{}", remedy["path"].as_str().unwrap());
    let body = json!({"in": "mission/position", "out": "demo/position"}).to_string();
    let refused = visitor.sends(remedy["method"].as_str().unwrap(), &path, &body);
    assert_eq!((refused.status, refused.code().as_str()), (403, "right_missing"));
    let nobody = Visitor::with_link(&link(&daemon, &["--rights", "call"]));
    assert_eq!(nobody.gets("/api/doctor").status, 403);
}

#[test]
fn a_request_to_examine_is_of_its_form_and_a_port_of_the_address_is_shown_as_text() {
    let daemon = daemon();
    let visitor = Visitor::with_link(&link(&daemon, &[]));
    for query in
        ["daemon_only=maybe", "root=/etc", "daemon_only=true&daemon_only=false", "x=1", "%00"]
    {
        let refused = visitor.gets(&format!("/api/doctor?{query}"));
        assert!(matches!(refused.status, 400 | 422), "{query}: {refused:?}");
    }
    // Many at once wait for each other, and each is answered.
    let many = std::thread::scope(|scope| {
        let all: Vec<_> = (0..8)
            .map(|_| scope.spawn(|| visitor.gets("/api/doctor?daemon_only=true").status))
            .collect();
        all.into_iter().map(|one| one.join().unwrap()).collect::<Vec<_>>()
    });
    assert_eq!(many, [200; 8]);
    let browser =
        open(&daemon, &[], "/doctor?port=%3Cimg%20src=x%20onerror=window.hacked=1%3E/%E2%80%AEa");
    browser.until("it was examined", "document.querySelector('#findings details')");
    let seen =
        browser.ask("return [window.hacked ?? null, document.querySelectorAll('main img').length]");
    assert_eq!(seen, json!([null, 0]));
    browser.until_shown("<img src=x onerror=window.hacked=1>");
}
