//! The timeline: of the daemon, and of a recording.

use genom_tests::browser::Browser;
use genom_tests::{Daemon, Home, fixture};
use serde_json::{Value, json};
use tempfile::TempDir;

use super::plots::sights;
use super::visitor::{Visitor, demo, link, next, set_speed};

fn opened(daemon: &Daemon, address: &str) -> Browser {
    let browser = Browser::start(1280, 900, &[]);
    browser.open(&link(daemon, &["--rights", "read"]));
    browser.until_shown("Overview");
    go(&browser, address);
    browser
}

fn go(browser: &Browser, address: &str) {
    browser.with(
        "history.pushState(null, '', arguments[0]); dispatchEvent(new Event('popstate'))",
        vec![json!(address)],
    );
    browser.until("the timeline is there", "document.getElementById('timeline')");
}

/// Whether a row of the list has all these texts.
fn listed(texts: &[&str]) -> String {
    format!(
        "[...document.querySelectorAll('#timeline-list tbody tr')].some((row) => \
         {}.every((text) => row.innerText.includes(text)))",
        json!(texts)
    )
}

#[test]
fn changes_have_dates_and_those_of_before_the_page_was_opened_are_there() {
    let daemon = demo(Home::new(), &[]);
    let started = daemon.json(&["call", "demo", "goto", "goal=0.001"]);
    assert!(started["exception"].is_null(), "{started}");
    let owner = Visitor::with_link(&link(&daemon, &[]));
    let mut live = owner.follows("/live?watch=/timeline/stream?component=demo");
    let first = next(&mut live, |told| told["kind"] == "changes");
    let told = &first["told"];
    assert_eq!((&told["first"], &told["missed"]), (&json!(true), &json!(0)));
    let changes = told["changes"].as_array().unwrap();
    let dates: Vec<u64> = changes.iter().map(|one| one["at"].as_u64().unwrap()).collect();
    assert!(dates.is_sorted() && *dates.last().unwrap() <= told["now"].as_u64().unwrap());
    let kinds: Vec<&Value> = changes
        .iter()
        .map(|one| &one["change"])
        .filter(|change| change["service"] == "goto")
        .map(|change| &change["event"])
        .collect();
    assert_eq!(
        (kinds.first().unwrap(), kinds.last().unwrap()),
        (&&json!("activity_started"), &&json!("activity_ended"))
    );
    assert!(kinds.contains(&&json!("transition")), "{kinds:?}");
    daemon.ctl(&["call", "demo", "goto", "goal=0.002"]).expect_code(0);
    let next = next(&mut live, |told| told["kind"] == "changes");
    assert_eq!(next["told"]["first"], false, "{next}");
    // Nothing of another component.
    let mut live = owner.follows("/live?watch=/timeline/stream?component=nobody");
    let other = super::visitor::next(&mut live, |told| told["kind"] == "changes");
    assert!(!other.to_string().contains("goto"), "{other}");
}

#[test]
fn activities_exceptions_missed_periods_and_connections_are_on_the_timeline() {
    let folder = TempDir::new().unwrap();
    let daemon = sights(&folder);
    let demo = genom_tests::component("demo");
    daemon.ctl(&["load", genom_tests::path(&demo.library)]).expect_code(0);
    let many = fixture("many", "many", folder.path());
    daemon.ctl(&["load", &many, "--name", "one"]).expect_code(0);
    daemon.ctl(&["load", &many, "--name", "two"]).expect_code(0);
    daemon.ctl(&["connect", "two/other", "one/current_state"]).expect_code(0);
    let browser = opened(&daemon, "/timeline");
    daemon.ctl(&["call", "sights", "lag", "milliseconds=200"]).expect_code(0);
    browser.until("the activity is there", &listed(&["sights · lag", "done", "rest"]));
    browser.until(
        "so are the periods that it missed",
        &listed(&["sights · main", "missed periods of main"]),
    );
    set_speed(&daemon, "0.01");
    let _ = daemon.json(&["start", "demo", "goto", "goal=0.5"]);
    browser.until("one that runs", &listed(&["demo · goto", "in main", "runs"]));
    daemon.ctl(&["fire", "demo", "emergency"]).expect_code(0);
    browser.until("how it ended", &listed(&["demo · goto", "HALTED of goto"]));
    browser.until(
        "what was connected",
        &listed(&["Connections", "two/other reads one/current_state"]),
    );
    // Only one component.
    browser.with(
        "const of = document.getElementById('timeline-component'); of.value = arguments[0]; \
                  of.dispatchEvent(new Event('change'))",
        vec![json!("sights")],
    );
    browser.until("only its activities are listed", &format!("!{}", listed(&["demo · goto"])));
    browser.until(
        "the address says it",
        "new URLSearchParams(location.search).get('component') === 'sights'",
    );
    assert_eq!(browser.ask("return document.querySelectorAll('script').length"), json!(1));
}

#[test]
fn a_range_is_chosen_by_keyboard_and_its_address_shows_it_again() {
    let daemon = demo(Home::new(), &[]);
    daemon.ctl(&["call", "demo", "goto", "goal=0.001"]).expect_code(0);
    let browser = opened(&daemon, "/timeline?last=7200");
    browser.until("it is there", &listed(&["demo · goto", "done"]));
    let query = |name: &str| format!("new URLSearchParams(location.search).get('{name}')");
    browser.press("#timeline", "+");
    browser.until("it is half as long", &format!("{} === '3600'", query("last")));
    // Home shows everything, and the range is fixed.
    browser.press("#timeline", "\u{E011}");
    browser.until("a range from the first to the last", &format!("{} > 0", query("from")));
    let wide = browser.ask(&format!("return {} - {}", query("to"), query("from")));
    browser.press("#timeline", "+");
    browser.until("it is shorter", &format!("{} - {} < {wide}", query("to"), query("from")));
    browser.press("#timeline", "-\u{E014}\u{E012}");
    browser.press("#timeline", "\u{E011}");
    browser.until("everything again", &format!("{} - {} >= {wide}", query("to"), query("from")));
    // From one thing to the next.
    browser.press("#timeline", "\u{E007}");
    browser.until("it is told", "document.getElementById('timeline-detail').innerText.length > 10");
    browser.until(
        "the address has settled",
        &format!("{} - {} >= {wide}", query("to"), query("from")),
    );
    let address = browser.ask("return location.pathname + location.search");
    let address = address.as_str().unwrap();
    go(&browser, "/timeline?last=0.01");
    browser.until("nothing is in this range", &format!("!{}", listed(&["demo · goto"])));
    go(&browser, address);
    browser.until("the same range again", &listed(&["demo · goto", "done"]));
    browser.press("#timeline", "\u{E010}");
    browser.until(
        "End follows",
        "document.getElementById('timeline-follow').getAttribute('aria-pressed') === 'true'",
    );
}

#[test]
fn missed_periods_of_a_task_are_one_entry_and_hide_no_connection() {
    let daemon = Daemon::start(&["--web"]);
    let browser = opened(&daemon, "/timeline");
    let listed = browser.ask(
        "return import('/assets/lanes.js').then(({ Lanes, entries }) => { \
           const lanes = new Lanes(); \
           const late = (at, task) => lanes.add(at, { event: 'overrun', component: 'arm', task, ticks: 2 }); \
           lanes.add(1, { event: 'connected', in: 'arm/goal', out: 'eye/goal', backend: 'local' }); \
           for (let at = 2; at < 500; at += 2) { late(at, 'main'); late(at + 1, 'slow'); } \
           lanes.add(500, { event: 'disconnected', in: 'arm/goal' }); \
           late(501, 'main'); \
           const of = (most) => entries([], lanes.marks, most).map((one) => [one.at, one.what]); \
           return [of(100), of(3), of(2)]; })",
    );
    let one = |at: u32, what: &str| json!([at, what]);
    let [connected, disconnected] =
        [one(1, "arm/goal reads eye/goal on local"), one(500, "arm/goal was disconnected")];
    let last = one(501, "2 missed periods of main");
    let main = one(2, "498 missed periods of main, 249 times");
    let slow = one(3, "498 missed periods of slow, 249 times");
    assert_eq!(
        listed,
        json!([
            [last, disconnected, slow, main, connected],
            [last, disconnected, connected],
            [disconnected, connected]
        ])
    );
}

#[test]
fn times_have_the_digits_that_they_have() {
    let daemon = Daemon::start(&["--web"]);
    let browser = opened(&daemon, "/timeline");
    let times = [0_u64, 7, 10, 1_000, 1_050, 1_254, 20_000_000, 160_000_000, 600_000_000_000];
    let told = browser.with(
        "return import('/assets/units.js').then(({ duration }) => arguments[0].map(duration))",
        vec![json!(times)],
    );
    assert_eq!(
        told,
        json!(["0 ns", "7 ns", "10 ns", "1 µs", "1.05 µs", "1.25 µs", "20 ms", "160 ms", "600 s"])
    );
}

/// Where the last chunk of a recording ends.
fn end_of_data(bytes: &[u8]) -> usize {
    const CHUNK: u8 = 6;
    let (mut at, mut end) = (8, None);
    while let Some(length) = bytes.get(at + 1..at + 9) {
        let next =
            at + 9 + usize::try_from(u64::from_le_bytes(length.try_into().unwrap())).unwrap();
        if bytes[at] == CHUNK {
            end = Some(next);
        }
        at = next;
    }
    end.expect("a recording has chunks")
}

#[test]
fn the_timeline_of_a_recording_is_read_in_the_browser() {
    let daemon = demo(Home::new(), &[]);
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("run.mcap");
    let recording = daemon.spawn(&["record", "-o", genom_tests::path(&file)]);
    recording.error_line_where(|line| line.contains("recording to")).expect("it records");
    daemon.ctl(&["call", "demo", "goto", "goal=0.002"]).expect_code(0);
    let _ = daemon.ctl(&["call", "demo", "goto", "goal=1000000"]);
    recording.signal("INT");
    recording.finish().expect_code(0);
    // Another daemon, which knows nothing of it.
    let other = Daemon::start(&["--web"]);
    let browser = opened(&other, "/timeline");
    browser.write("#timeline-file", genom_tests::path(&file));
    browser.until("its activities are there", &listed(&["demo · goto", "done: "]));
    browser.until("so are exceptions", &listed(&["OUT_OF_RANGE"]));
    browser.until_shown("Of run.mcap");
    // Of a recorder that was killed in the middle of a sample.
    let bytes = std::fs::read(&file).unwrap();
    let cut = folder.path().join("cut.mcap");
    std::fs::write(&cut, &bytes[..end_of_data(&bytes) - 1]).unwrap();
    browser.write("#timeline-file", genom_tests::path(&cut));
    browser.until_shown("which ends early");
    browser.until("what is there is shown", &listed(&["demo · goto", "done: "]));
    for (name, content) in [
        ("none.mcap", &b"#!/bin/sh"[..]),
        ("empty.mcap", &bytes[..8]),
        // A record that is said to be longer than any.
        ("long.mcap", &[&bytes[..8], &[4], &[0xFF; 8], &[0; 64]].concat()),
        // A chunk whose texts reach beyond it.
        ("odd.mcap", &[&bytes[..8], &[6, 40, 0, 0, 0, 0, 0, 0, 0], &[0xFF; 40]].concat()),
    ] {
        let file = folder.path().join(name);
        std::fs::write(&file, content).unwrap();
        browser.write("#timeline-file", genom_tests::path(&file));
        browser.until_shown(&format!("{name}: "));
    }
    browser.click("#timeline-back");
    browser.until("the daemon's own again", &format!("!{}", listed(&["demo · goto"])));
}
