//! The pages in a real browser.

use genom_tests::browser::Browser;
use genom_tests::{Daemon, Home, component, fixture, path, request};
use serde_json::json;
use tempfile::TempDir;

use super::visitor::{demo, link, set_speed};

/// A browser in which somebody with these rights is signed in.
fn signed_in(daemon: &Daemon, rights: &str) -> Browser {
    let browser = Browser::start(1280, 900, &[]);
    browser.open(&link(daemon, &["--rights", rights]));
    browser.until_shown("Overview");
    browser
}

#[test]
fn a_motion_is_started_seen_and_aborted_on_the_page_of_its_component() {
    let daemon = demo(Home::new(), &[]);
    let browser = signed_in(&daemon, "read,call");
    browser.until("the demo runs", "document.querySelector('[data-component=demo] .pill.good')");
    let address = browser.ask("return location.href");
    assert!(!address.as_str().unwrap().contains('#'), "the secret stays in the history: {address}");
    browser.click("a[href='/component/demo']");
    browser.click("[data-port='demo/position'] button");
    set_speed(&daemon, "0.01");
    browser.write("[data-service=goto] input", "0.5");
    browser.click("[data-service=goto] button[type=submit]");
    browser.until(
        "its state is lit",
        "document.querySelector('[data-service=goto] [data-state=main].lit')",
    );
    set_speed(&daemon, "1");
    browser
        .until("it is done", "document.querySelector('[data-service=goto] li[data-status=done]')");
    browser.until("no state is lit", "!document.querySelector('.lit')");
    browser.until(
        "the plot is at the goal",
        "[...document.querySelectorAll('[data-detail=\"demo/position\"] .legend li')].some((line) => \
         line.innerText.startsWith('position') \
         && Math.abs(parseFloat(line.querySelector('output').innerText) - 0.5) < 1e-3)",
    );
    // One that is aborted brakes first.
    set_speed(&daemon, "0.01");
    browser.write("[data-service=goto] input", "-2");
    browser.click("[data-service=goto] button[type=submit]");
    browser.click("[data-service=goto] li[data-status=running] button");
    browser.until(
        "it is over",
        "!document.querySelector('[data-service=goto] li[data-status=running]')",
    );
    let activities = daemon.json(&["activities", "demo"]);
    assert_eq!(activities["activities"].as_array().unwrap().len(), 2, "{activities}");
    // What a component refuses is told with its reason, here and in the overview.
    browser.write("[data-service=goto] input", "1000000");
    browser.click("[data-service=goto] button[type=submit]");
    browser.until_shown("demo::OUT_OF_RANGE");
    browser.write("[data-service=goto] input", "2");
    browser.click("[data-service=goto] button[type=submit]");
    browser
        .until("it moves", "document.querySelector('[data-service=goto] li[data-status=running]')");
    browser.ask("[...document.querySelectorAll('button')].find((one) => one.innerText.includes('Fire')).click()");
    browser.until_shown("demo::HALTED");
    browser.click("a[href='/']");
    browser.until_shown("demo::HALTED of goto");
}

#[test]
fn an_attribute_is_set_in_a_form_with_its_value_range_and_doc() {
    let daemon = demo(Home::new(), &[]);
    assert_eq!(daemon.json(&["call", "demo", "set_speed", "velocity=0.75"])["result"], json!({}));
    let browser = signed_in(&daemon, "read,call");
    browser.click("a[href='/component/demo']");
    browser.until(
        "the present value is there",
        "document.querySelector('[data-service=set_speed] input')?.value === '0.75'",
    );
    browser.until_shown("Greatest speed, m/s");
    browser.write("[data-service=set_speed] input", "fast");
    browser.click("[data-service=set_speed] button[type=submit]");
    browser.until_shown("“fast” is no number");
    browser.write("[data-service=set_speed] input", "1.25");
    browser.click("[data-service=set_speed] button[type=submit]");
    browser.until(
        "it is done",
        "document.querySelector('[data-service=set_speed] .reply').innerText === 'done'",
    );
    assert_eq!(daemon.json(&["call", "demo", "get_speed"])["result"]["velocity"], 1.25);
}

#[test]
fn whoever_may_only_read_is_offered_nothing_else() {
    let daemon = demo(Home::new(), &[]);
    let browser = signed_in(&daemon, "read");
    browser.click("a[href='/component/demo']");
    browser.until_shown("Your rights do not allow calls.");
    let offered = browser.ask(
        "return [...document.querySelectorAll('main button:not(.toggle):not(:disabled), #stop-all')]\
         .map((one) => one.innerText)",
    );
    assert_eq!(offered, json!([]));
}

#[test]
fn a_page_comes_back_by_itself_when_the_daemon_does() {
    let daemon = demo(Home::new(), &[]);
    let browser = signed_in(&daemon, "read,call");
    browser.click("a[href='/component/demo']");
    browser.until("it is live", "document.getElementById('state').innerText === 'live'");
    browser.ask("window.sameDocument = true");
    let home = daemon.abandon();
    browser.until_shown("daemon away");
    let daemon = demo(home, &[]);
    browser.until("it is live again", "document.getElementById('state').innerText === 'live'");
    set_speed(&daemon, "0.01");
    // Without being loaded again, and still signed in.
    assert_eq!(browser.ask("return window.sameDocument"), true);
    browser.click("[data-service=goto] button[type=submit]");
    browser
        .until("it moves", "document.querySelector('[data-service=goto] [data-state=main].lit')");
    assert_eq!(daemon.json(&["activities", "demo"])["activities"][0]["status"], "running");
}

#[test]
fn an_open_page_of_a_session_that_ended_asks_to_sign_in() {
    let daemon = demo(Home::new().configured("[web]\nmax_sessions = 1\n"), &[]);
    let browser = signed_in(&daemon, "read");
    drop(signed_in(&daemon, "read"));
    browser.until_shown("Sign in");
    browser.write("#token", "guessed");
    browser.click("form button");
    browser.until_shown("this token is not known here");
}

#[test]
fn whatever_a_value_contains_is_shown_as_text() {
    let folder = TempDir::new().unwrap();
    let description = fixture("texts", "texts", folder.path());
    let daemon = Home::new().start(&["--web", &description]);
    let publish = |text: &str| {
        let at = "/components/texts/ports/heard";
        let published = request(&daemon.home().socket(), "POST", at, &json!(text).to_string());
        assert_eq!(published.status, 200, "{:?}", published.body);
    };
    let browser = signed_in(&daemon, "read,call");
    browser.click("a[href='/component/texts']");
    browser.click("[data-port='texts/heard'] button");
    let before = browser.ask("return document.querySelectorAll('img, script, iframe').length");
    let hostile = "<img src=x onerror=window.hacked=1><script>window.hacked=1</script>";
    publish(hostile);
    browser.until_shown(hostile);
    publish("a\u{202e}b\u{7}c\u{feff}");
    browser.until_shown("a⟨U+202E⟩b");
    publish(&"<b>".repeat(300_000));
    browser.until_shown("(900,002 characters)");
    let shown = browser.ask("return document.body.innerText.length");
    assert!(shown.as_u64().unwrap() < 20_000, "{shown}");
    // As an attribute it comes into a form.
    let set = json!({ "note": hostile }).to_string();
    assert_eq!(
        request(&daemon.home().socket(), "POST", "/components/texts/services/set_note", &set)
            .status,
        200
    );
    browser.click("[data-service=get_note] button[type=submit]");
    browser.until(
        "it is shown",
        "document.querySelector('[data-service=get_note] .reply').innerText.includes('onerror')",
    );
    assert_eq!(
        browser.ask("return document.querySelectorAll('img, script, iframe').length"),
        before
    );
    assert_eq!(browser.ask("return window.hacked ?? null"), json!(null));
}

#[test]
fn a_name_of_a_megabyte_is_cut_wherever_the_graph_shows_it() {
    let daemon = demo(Home::new(), &[]);
    let browser = signed_in(&daemon, "read,wire");
    // No name of the daemon's own is as long, and middlewares refuse most of those of others.
    browser.ask(
        "const parse = JSON.parse, long = JSON.stringify('demo/' + '<b>\u{202e}'.repeat(250000)); \
         JSON.parse = (text, ...more) => parse(text.replaceAll('\"demo/position\"', long), ...more)",
    );
    browser.click("a[href='/graph']");
    browser.until(
        "it is drawn",
        "[...document.querySelectorAll('.port')].some((one) => one.textContent.includes('<b>'))",
    );
    browser.click_right(".port.out .end");
    browser.until("its menu is open", "document.getElementById('menu')");
    let longest = browser.ask(
        "return Math.max(...[...document.querySelectorAll('main *, #menu *')].flatMap((one) => \
         [one.children.length ? 0 : one.textContent.length, one.getAttribute('aria-label')?.length ?? 0]))",
    );
    // Cut at 2,000 characters, each of which may be spelled with eight.
    assert!(longest.as_u64().unwrap() < 20_000, "{longest}");
    assert_eq!(browser.ask("return document.querySelectorAll('b').length"), json!(0));
}

#[test]
fn the_log_and_events_are_told_as_they_happen_and_filtered() {
    let daemon = demo(Home::new(), &[]);
    let browser = signed_in(&daemon, "read");
    browser.click("a[href='/logs']");
    browser.until_shown("runs on local");
    let started = daemon.json(&["start", "demo", "goto", "goal=0.01"]);
    browser.until_shown("activity ended");
    assert_eq!(started["activity"].as_u64(), Some(2), "{started}");
    browser.write("#words", "goto ended");
    browser.until(
        "only it is shown",
        "[...document.querySelectorAll('#log li')].filter((one) => !one.hidden).length === 1",
    );
    browser.write("#words", " ");
    browser.with("document.getElementById('show').value = arguments[0]", vec![json!("log")]);
    browser.ask("document.getElementById('show').dispatchEvent(new Event('change'))");
    browser.until(
        "only the log is shown",
        "document.querySelector('#log li') && !document.querySelector('#log .event')",
    );
    assert_eq!(browser.ask("return location.pathname + location.search"), "/logs?show=log&words=+");
}

#[test]
fn pages_fit_a_telephone_and_have_a_name_for_each_control() {
    let demo = component("demo");
    let daemon = Home::new().start(&["--web", path(&demo.library)]);
    let browser = Browser::start(360, 740, &[]);
    browser.open(&link(&daemon, &[]));
    browser.until_shown("Overview");
    assert_eq!(browser.ask("return innerWidth"), 360);
    for (page, there) in [
        ("/", "document.querySelector('[data-component=demo]')"),
        ("/component/demo", "document.querySelector('[data-service=goto] form button')"),
        ("/graph", "document.querySelector('.port')"),
        ("/logs", "document.querySelector('#log li')"),
        ("/doctor", "document.querySelector('#findings details')"),
        ("/deployment", "document.querySelector('#running')?.innerText"),
        ("/recordings", "document.querySelector('#what option')"),
    ] {
        browser.with(
            "history.pushState(null, '', arguments[0]); dispatchEvent(new Event('popstate'))",
            vec![json!(page)],
        );
        browser.until(page, there);
        let wide = browser.ask("return document.documentElement.scrollWidth");
        assert!(wide.as_u64().unwrap() <= 360, "{page} is {wide} wide:\n{}", browser.text());
        let unnamed = browser.ask(
            "return [...document.querySelectorAll('button, input, select, textarea, a[href], [role=button], [tabindex=\"0\"]')] \
             .filter((one) => !(one.innerText?.trim() || one.textContent.trim() || one.getAttribute('aria-label') \
             || one.labels?.length)).map((one) => one.outerHTML.slice(0, 100))",
        );
        assert_eq!(unnamed, json!([]), "{page}");
    }
}

#[test]
fn rules_of_supervision_are_listed_and_what_broke_one_is_told() {
    let demo = component("demo").library;
    let rules = format!(
        "[[component]]\nlibrary = {demo:?}\n\
         [[component.supervision]]\ncodel = \"demo_servo\"\nafter = \"demo_brake\"\n\
         [[component.supervision]]\ncodel = \"demo_brake\"\nlongest_ms = 60000\nreaction = \"interrupt\"\n\
         [[component]]\nlibrary = {demo:?}\nname = \"free\"\n"
    );
    let daemon = Home::new().configured(&rules).start(&["--web"]);
    let browser = signed_in(&daemon, "read,call");
    browser.click("a[href='/component/demo']");
    let cell = |row: usize, label: &str| {
        format!(
            "document.querySelector('#rules tbody').rows[{row}].querySelector('[data-label={label}]').innerText"
        )
    };
    browser
        .until("both rules are there", "document.querySelector('#rules tbody')?.rows.length === 2");
    for (row, kind, reaction) in [(0, "logical", "event"), (1, "deadline", "interrupt")] {
        browser.until("its kind is told", &format!("{} === '{kind}'", cell(row, "Kind")));
        assert_eq!(browser.ask(&format!("return {}", cell(row, "Reaction"))), reaction);
        assert_eq!(browser.ask(&format!("return {}", cell(row, "Broken"))), "never");
    }
    daemon.ctl(&["start", "demo", "goto", "goal=0.1"]).expect_code(0);
    browser.until("the first one is broken", &format!("Number({}) > 0", cell(0, "Broken")));
    browser.until("when is told", &format!("{} !== '–'", cell(0, "Last")));
    assert_eq!(browser.ask(&format!("return {}", cell(1, "Broken"))), "never");
    browser.until_shown("demo_servo");
    browser.click("a[href='/']");
    browser.click("a[href='/component/free']");
    browser.until_shown("free");
    browser.until(
        "no rules are shown where there are none",
        "document.querySelector('#rules')?.hidden",
    );
}
