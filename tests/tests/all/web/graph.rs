//! The graph in a real browser: connections by mouse and by keyboard.

use std::time::Duration;

use genom_tests::browser::Browser;
use genom_tests::{Daemon, Home, component, path, until_answer};
use serde_json::{Value, json};

use super::visitor::link;

const ENTER: &str = "\u{E007}";
const ESCAPE: &str = "\u{E00C}";
const DELETE: &str = "\u{E017}";

/// An axis and a mission, whose ports fit, in a browser that shows their graph.
fn shown(rights: &str) -> (Daemon, Browser) {
    let (demo, mission) = (component("demo"), component("mission"));
    let daemon = Home::new().start(&["--web", path(&demo.library), path(&mission.library)]);
    let browser = Browser::start(1280, 900, &[]);
    browser.open(&link(&daemon, &["--rights", rights]));
    browser.click("a[href='/graph']");
    browser.until("the ports are drawn", "document.querySelectorAll('.port').length >= 4");
    (daemon, browser)
}

fn connections(daemon: &Daemon) -> Value {
    daemon.json(&["connections"])["connections"].clone()
}

fn first_out(daemon: &Daemon) -> String {
    connections(daemon)[0]["out"].as_str().unwrap_or_default().to_owned()
}

#[test]
fn ports_are_connected_by_dragging_and_disconnected_by_choosing_the_connection() {
    let (daemon, browser) = shown("read,wire");
    browser.drag("[data-port='demo/position']", "[data-port='mission/position']");
    browser.until_shown("demo/position → mission/position");
    browser.with("document.getElementById('policy').value = arguments[0]", vec![json!("queue")]);
    browser.ask("document.getElementById('policy').dispatchEvent(new Event('change'))");
    browser.write("#size", "3");
    browser.click("dialog button.main");
    browser.until(
        "the connection is drawn",
        "document.querySelector('[data-edge=\"mission/position\"]')",
    );
    let made = &connections(&daemon)[0];
    assert_eq!((&made["out"], &made["policy"]), (&json!("demo/position"), &json!("queue:3")));
    browser.press("[data-edge='mission/position']", DELETE);
    browser.until_shown("Disconnect");
    browser.click("dialog [type=submit]");
    browser.until("the connection is gone", "!document.querySelector('.edge')");
    assert_eq!(connections(&daemon), json!([]));
}

#[test]
fn ports_are_connected_with_the_keyboard_alone() {
    let (daemon, browser) = shown("read,wire");
    browser.press("[data-port='mission/gain']", ENTER);
    browser.until_shown("mission/gain is chosen");
    browser.press("[data-port='mission/gain']", ESCAPE);
    browser.until_shown("Nothing is chosen");
    browser.press("[data-port='mission/gain']", ENTER);
    browser.press("[data-port='demo/parameter']", ENTER);
    browser.until_shown("mission/gain → demo/parameter");
    browser.press("dialog button.main", ENTER);
    browser.until(
        "the connection is drawn",
        "document.querySelector('[data-edge=\"demo/parameter\"]')",
    );
    until_answer("mission/gain", || first_out(&daemon));
    // One that somebody else removes goes from the page.
    daemon.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
    browser.until("the connection is gone", "!document.querySelector('.edge')");
}

#[test]
fn ports_of_different_types_are_refused_with_the_reason_before_anything_is_asked() {
    let (daemon, browser) = shown("read,wire");
    browser.drag("[data-port='demo/position']", "[data-port='demo/parameter']");
    browser.until_shown(
        "demo/parameter reads demo::gain, and demo/position carries demo::state: only ports of \
         equal types can be connected",
    );
    assert_eq!(browser.ask("return document.querySelectorAll('dialog').length"), 0);
    // Which ports fit shows from the moment when one is chosen.
    browser.press("[data-port='demo/position']", ENTER);
    let marked = browser.ask(
        "return ['.fits', '.unfit'].map((mark) => [...document.querySelectorAll('.port' + mark)]
           .map((one) => one.dataset.port))",
    );
    assert_eq!(marked, json!([["mission/position"], ["demo/parameter", "mission/goto"]]));
    assert_eq!(connections(&daemon), json!([]));
}

#[test]
fn enter_answers_the_question_for_a_connection_and_tab_is_not_needed() {
    let (daemon, browser) = shown("read,wire");
    browser.press("[data-port='demo/position']", ENTER);
    browser.press("[data-port='mission/position']", ENTER);
    browser.until_shown("demo/position → mission/position");
    browser.type_keys(ENTER);
    until_answer("demo/position", || first_out(&daemon));
}

#[test]
fn the_menu_changes_the_policy_and_disconnects_by_mouse_and_by_keyboard() {
    let (daemon, browser) = shown("read,wire");
    daemon.ctl(&["connect", "mission/position", "demo/position"]).expect_code(0);
    let edge = "[data-edge='mission/position']";
    browser.until("it is drawn", &format!("document.querySelector(\"{edge}\")"));
    browser.press(edge, "m");
    browser.until_shown("Change policy or middleware…");
    browser.type_keys(ENTER);
    browser.until("it asks", "document.getElementById('policy')");
    browser.with("document.getElementById('policy').value = arguments[0]", vec![json!("ring")]);
    browser.ask("document.getElementById('policy').dispatchEvent(new Event('change'))");
    browser.click("dialog button.main");
    until_answer("ring:10", || {
        connections(&daemon)[0]["policy"].as_str().unwrap_or_default().to_owned()
    });
    browser.until("the question is gone", "!document.querySelector('dialog')");
    browser.click_right("[data-port='mission/position'] .end");
    browser.until_shown("Disconnect…");
    browser.press(".menu .danger", ENTER);
    browser.until("it asks", "document.querySelector('dialog .danger')");
    browser.type_keys(ENTER);
    browser.until("the connection is gone", "!document.querySelector('.edge')");
    assert_eq!(connections(&daemon), json!([]));
}

#[test]
fn a_long_touch_opens_the_menu_and_is_no_click() {
    let (_daemon, browser) = shown("read,wire");
    browser.hold("[data-port='mission/position']");
    browser.until_shown("Read an out port…");
    browser.release();
    browser.until("the menu stays", "document.getElementById('menu')");
    assert_eq!(browser.ask("return document.querySelector('#graph .picked')"), json!(null));
    browser.type_keys(ESCAPE);
    browser.until("it is closed", "!document.getElementById('menu')");
    assert_eq!(
        browser.ask("return document.activeElement.dataset.port"),
        json!("mission/position"),
        "the focus is where it was"
    );
}

#[test]
fn an_end_of_a_connection_is_dragged_to_another_in_port() {
    let (demo, mission) = (component("demo"), component("mission"));
    let instance = |name| {
        format!("[[component]]\nlibrary = {:?}\nname = \"{name}\"\n", path(&mission.library))
    };
    let connection = "[[connection]]\nin = \"first/position\"\nout = \"demo/position\"\n\
                      policy = \"queue:7\"\n";
    let demo = format!("[[component]]\nlibrary = {:?}\n", path(&demo.library));
    let text = [demo, instance("first"), instance("second"), connection.to_owned()].concat();
    let daemon = Home::new().configured(&text).start(&["--web"]);
    let browser = Browser::start(1280, 900, &[]);
    browser.open(&link(&daemon, &["--rights", "read,wire"]));
    browser.click("a[href='/graph']");
    browser.until("it is drawn", "document.querySelector('[data-edge=\"first/position\"]')");
    browser.drag("[data-port='first/position'] .end", "[data-port='second/position']");
    browser.until_shown("instead of first/position");
    browser.type_keys(ENTER);
    browser.until("it is drawn", "document.querySelector('[data-edge=\"second/position\"]')");
    browser
        .until("the old one is gone", "!document.querySelector('[data-edge=\"first/position\"]')");
    let now = connections(&daemon);
    assert_eq!(now.as_array().map(Vec::len), Some(1), "{now}");
    assert_eq!((&now[0]["in"], &now[0]["policy"]), (&json!("second/position"), &json!("queue:7")));
    // To a port of another type it does not go, and stays.
    browser.drag("[data-port='second/position'] .end", "[data-port='demo/parameter']");
    browser.until_shown("only ports of equal types can be connected");
    assert_eq!(connections(&daemon), now);
}

#[test]
fn a_port_is_moved_to_another_middleware_with_its_connection() {
    let (daemon, browser) = shown("read,wire");
    daemon.ctl(&["connect", "mission/position", "demo/position"]).expect_code(0);
    browser.until("it is drawn", "document.querySelector('.edge.m1')");
    browser.press("[data-port='demo/position']", "m");
    browser.until("the menu is open", "document.querySelectorAll('#menu button').length > 2");
    browser.ask(
        "[...document.querySelectorAll('#menu button')].find((one) => one.innerText.includes('middleware')).click()",
    );
    browser.click("#on-local");
    browser.click("#on-shm");
    browser.click("dialog button.main");
    browser.until("it has the colour of the other", "document.querySelector('.edge.m2')");
    assert_eq!(connections(&daemon)[0]["backend"], "shm");
    assert_eq!(daemon.port("demo", "position")["backend"], "shm");
}

#[test]
fn a_remote_is_connected_to_a_service_by_dragging_it_onto_a_component() {
    let (daemon, browser) = shown("read,wire");
    browser.drag("[data-port='mission/goto']", "[data-id='component demo'] .body");
    browser.until_shown("Call a service");
    // The service of the name of the remote is the first.
    browser.type_keys(ENTER);
    browser.until_shown("demo/goto → mission/goto");
    browser.type_keys(ENTER);
    browser.until("the call is drawn", "document.querySelector('.edge.call')");
    let made = &connections(&daemon)[0];
    assert_eq!(
        (&made["kind"], &made["in"], &made["out"]),
        (&json!("service"), &json!("mission/goto"), &json!("demo/goto"))
    );
    browser.until_shown("calls of remotes");
    browser.press("[data-port='mission/goto']", DELETE);
    browser.until_shown("Disconnect");
    browser.type_keys(ENTER);
    browser.until("the call is gone", "!document.querySelector('.edge')");
}

#[test]
fn arrow_keys_go_along_ports_and_connections() {
    let (daemon, browser) = shown("read");
    daemon.ctl(&["connect", "mission/position", "demo/position"]).expect_code(0);
    browser.until("it is drawn", "document.querySelector('.edge')");
    let (up, down, right) = ("\u{E013}", "\u{E015}", "\u{E014}");
    browser.ask("document.querySelector('[data-key=\"component demo\"]').focus()");
    let mut seen = Vec::new();
    for key in [down, right, right, right, up] {
        browser.type_keys(key);
        let at = browser.ask("return document.activeElement.dataset.key");
        seen.push(at.as_str().unwrap_or_default().to_owned());
    }
    let edge = "edge out demo/position > in mission/position local port";
    assert_eq!(
        seen,
        [
            "in demo/parameter",
            "out demo/position",
            edge,
            "in mission/position",
            "component mission"
        ]
    );
}

#[test]
fn a_mouse_that_waits_before_it_moves_drags() {
    let (_daemon, browser) = shown("read,wire");
    let long = Duration::from_millis(600);
    browser.drag_after(long, "[data-port='demo/position']", "[data-port='mission/position']");
    browser.until_shown("demo/position → mission/position");
}

#[test]
fn whoever_may_not_connect_is_not_offered_to() {
    let (daemon, browser) = shown("read");
    browser.until_shown("Your rights do not allow to connect.");
    browser.drag("[data-port='demo/position']", "[data-port='mission/position']");
    browser.press("[data-port='demo/position']", ENTER);
    browser.press("[data-port='mission/position']", ENTER);
    browser.until_shown("mission/position is not connected");
    assert_eq!(browser.ask("return document.querySelectorAll('dialog').length"), 0);
    assert_eq!(connections(&daemon), json!([]));
}

#[test]
fn the_graph_comes_back_by_itself_when_the_daemon_does() {
    let (demo, mission) = (component("demo"), component("mission"));
    let start = |home: Home| home.start(&["--web", path(&demo.library), path(&mission.library)]);
    let daemon = start(Home::new());
    let browser = Browser::start(1280, 900, &[]);
    browser.open(&link(&daemon, &["--rights", "read,wire"]));
    browser.click("a[href='/graph']");
    daemon.ctl(&["connect", "mission/position", "demo/position"]).expect_code(0);
    browser.until("the connection is drawn", "document.querySelector('.edge')");
    browser.ask("window.sameDocument = true");
    let home = daemon.abandon();
    browser.until_shown("daemon away");
    let daemon = start(home);
    browser.until(
        "the new daemon's graph is drawn",
        "document.getElementById('state').innerText === 'live' && !document.querySelector('.edge') \
         && document.querySelectorAll('.port').length === 5",
    );
    browser.drag("[data-port='demo/position']", "[data-port='mission/position']");
    browser.until_shown("demo/position → mission/position");
    browser.click("dialog button.main");
    browser.until("what the new daemon connects is drawn", "document.querySelector('.edge')");
    assert_eq!(first_out(&daemon), "demo/position");
    assert_eq!(browser.ask("return window.sameDocument"), true);
}
