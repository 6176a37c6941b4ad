//! The graph in a real browser: connections by mouse and by keyboard.

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
    browser.click("dialog button.main");
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
    until_answer("mission/gain", || {
        connections(&daemon)[0]["out"].as_str().unwrap_or_default().to_owned()
    });
    // One that somebody else removes goes from the page.
    daemon.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
    browser.until("the connection is gone", "!document.querySelector('.edge')");
}

#[test]
fn ports_of_different_types_are_refused_with_the_reason() {
    let (daemon, browser) = shown("read,wire");
    browser.drag("[data-port='demo/position']", "[data-port='demo/parameter']");
    browser.until_shown("demo/position → demo/parameter");
    browser.click("dialog button.main");
    browser.until(
        "the reason is told",
        "document.querySelector('dialog .error').innerText.includes('type')",
    );
    assert_eq!(connections(&daemon), json!([]));
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
