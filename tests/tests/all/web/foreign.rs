//! The graph and what other programs have on the middlewares.

use std::net::UdpSocket;
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::time::Duration;

use crate::forger::{Forger, announcement_ports};
use genom_tests::browser::Browser;
use genom_tests::{Home, Memory, component, path, until_answer};
use serde_json::json;

use super::visitor::link;

const ENTER: &str = "\u{E007}";

#[test]
fn ports_of_another_daemon_are_shown_connected_and_refused_by_type() {
    let memory = Arc::new(Memory::new());
    let (demo, mission) = (component("demo"), component("mission"));
    let far = Home::with(&memory).start(&[
        "--web",
        "--backend",
        "shm",
        "--name",
        "far",
        path(&demo.library),
    ]);
    let own = Home::with(&memory).start(&[
        "--web",
        "--backend",
        "shm",
        path(&demo.library),
        path(&mission.library),
    ]);
    let browser = Browser::start(1280, 900, &[]);
    browser.open(&link(&own, &["--rights", "read,wire"]));
    browser.click("a[href='/graph']");
    browser.until(
        "the other daemon's port is there",
        "document.querySelector('[data-port=\"far/position\"]')",
    );
    browser.until_shown("other programs");
    // Its type is not known here: the daemon finds out, and says why it refuses.
    browser.drag("[data-port='far/position']", "[data-port='demo/parameter']");
    browser.until_shown("far/position → demo/parameter");
    browser.type_keys(ENTER);
    browser.until(
        "the reason is told",
        "['demo::gain', 'demo::state'].every((type) => document.querySelector('dialog .error').innerText.includes(type))",
    );
    assert_eq!(own.json(&["connections"])["connections"], json!([]));
    browser.ask("document.querySelector('dialog').close()");
    browser.drag("[data-port='far/position']", "[data-port='mission/position']");
    browser.until_shown("far/position → mission/position");
    browser.type_keys(ENTER);
    until_answer("far/position", || {
        let made = own.json(&["connections"])["connections"][0]["out"].clone();
        made.as_str().unwrap_or_default().to_owned()
    });
    browser.until("it is drawn", "document.querySelector('[data-edge=\"mission/position\"]')");
    // From the other side, whoever reads is not known by name.
    browser.open(&link(&far, &["--rights", "read"]));
    browser.click("a[href='/graph']");
    browser.until(
        "a reader elsewhere is drawn",
        "document.querySelector('.edge.foreign')?.getAttribute('aria-label') \
         === 'a reader of far/position in other programs, on shm'",
    );
}

#[test]
fn whatever_a_peer_calls_its_topics_is_shown_as_text() {
    let home = Home::new();
    let domain = u16::try_from(home.memory().domain()).unwrap();
    let demo = component("demo");
    let daemon = home.start(&["--web", "--backend", "ros2", path(&demo.library)]);
    let browser = Browser::start(1280, 900, &[]);
    browser.open(&link(&daemon, &["--rights", "read,wire"]));
    browser.click("a[href='/graph']");
    browser.until("the demo is drawn", "document.querySelector('[data-port=\"demo/position\"]')");
    let _peer = hostile_peer(domain);
    browser.until(
        "it is drawn",
        "[...document.querySelectorAll('.node.peer .what')].some((one) => one.textContent.startsWith('<img src=x'))",
    );
    browser.click_right(".node.peer .port .end");
    browser.until(
        "its menu is open",
        "document.getElementById('menu')?.innerText.includes('⟨U+202E⟩')",
    );
    // Nor does a tooltip or a label for screen readers turn its direction.
    let turned = browser.ask(
        "return [...document.querySelectorAll('#graph *')].some((one) => one.textContent.includes('\\u202e') \
         || [...one.attributes].some(({ name, value }) => !name.startsWith('data-') && value.includes('\\u202e')))",
    );
    assert_eq!(turned, json!(false));
    let made =
        browser.ask("return document.querySelectorAll('main img, script:not([src]), b, i').length");
    assert_eq!((made, browser.ask("return window.hacked ?? null")), (json!(0), json!(null)));
}

/// A participant of a ROS 2 domain that has a writer with a hostile topic and type; it announces
/// both again and again, until it is dropped.
fn hostile_peer(domain: u16) -> Sender<()> {
    let (peer, ended) = mpsc::channel();
    let socket = UdpSocket::bind(("127.0.0.1", 0)).unwrap();
    let port = socket.local_addr().unwrap().port();
    let forger = Forger(*b"\x01\x10forged....");
    let topic = "rt/<img src=x onerror=window.hacked=1>\u{202e}/<b>scan";
    let messages = [
        forger.announcement(1, port, 100),
        forger.writer(topic, "std_msgs::msg::dds_::<i>Float64_"),
    ];
    let announces = move || {
        while ended.recv_timeout(Duration::from_millis(50)) == Err(RecvTimeoutError::Timeout) {
            for (to, message) in announcement_ports(domain).flat_map(|to| [(to, 0), (to, 1)]) {
                let _ = socket.send_to(&messages[message], ("127.0.0.1", to));
            }
        }
    };
    std::thread::spawn(announces);
    peer
}
