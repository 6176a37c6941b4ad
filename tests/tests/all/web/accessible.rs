//! All pages of the console by the rules of WCAG 2 A and AA, as far as axe-core checks them.
//!
//! axe-core comes from the npm registry, in the version of `tests/fixtures/axe`.

use std::fs;

use genom_components::node;
use genom_tests::browser::Browser;
use genom_tests::{Daemon, Home, component, path, repository};
use serde_json::{Value, json};
use tempfile::TempDir;

use super::visitor::link;

/// Sizes, in pixels: a telephone and a large screen.
const SIZES: [(u32, u32); 2] = [(360, 740), (1920, 1080)];

/// The source of axe-core.
fn axe() -> String {
    let scratch = TempDir::new().unwrap();
    let copy = scratch.path().join("axe");
    let fixture = repository().join("tests/fixtures/axe");
    node::package(&fixture, &copy).unwrap_or_else(|error| panic!("{error}"));
    fs::read_to_string(copy.join("node_modules/axe-core/axe.min.js")).unwrap()
}

/// An axis and a mission, connected, with an exception to be seen.
fn daemon() -> Daemon {
    let (demo, mission) = (component("demo"), component("mission"));
    let daemon = Home::new().start(&["--web", path(&demo.library), path(&mission.library)]);
    daemon.ctl(&["connect", "mission/position", "demo/position"]).expect_code(0);
    daemon.ctl(&["connect", "mission/goto", "demo/goto"]).expect_code(0);
    daemon.ctl(&["start", "--wait", "demo", "goto", "goal=1000000"]).expect_code(1);
    daemon
}

/// Checks the page as it is now, in both schemes of colours and both sizes.
#[track_caller]
fn check(browser: &Browser, source: &str, what: &str, found: &mut Vec<String>) {
    for (width, height) in SIZES {
        for dark in [false, true] {
            browser.look(width, height, dark);
            let scheme = browser.ask("return matchMedia('(prefers-color-scheme: dark)').matches");
            assert_eq!(scheme, dark);
            // Evaluated by WebDriver, which the policy for contents does not concern.
            browser.with(
                "if (!window.axe) new Function(arguments[0]).call(window);
                 window.found = null;
                 axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'],
                   resultTypes: ['violations'] })
                   .then((told) => { window.found = told; }, (error) => { window.found = { error: String(error) }; })",
                vec![json!(source)],
            );
            browser.until("axe-core has checked", "window.found");
            let told = browser.ask(
                "return window.found.error ? { error: window.found.error } : {
                   passed: window.found.passes.length,
                   violations: window.found.violations.flatMap((one) => one.nodes.map((node) =>
                     `${one.id}: ${node.target.join(' ')}: ${node.failureSummary.replaceAll('\\n', ' ')}`)) }",
            );
            assert!(told["passed"].as_u64().is_some_and(|passed| passed > 5), "{what}: {told}");
            let all = told["violations"].as_array().unwrap().iter().filter_map(Value::as_str);
            let scheme = if dark { "dark" } else { "light" };
            found.extend(all.map(|one| format!("{what}, {width} px, {scheme}: {one}")));
        }
    }
}

#[test]
fn no_page_breaks_a_rule_of_wcag_2_a_or_aa_in_light_or_dark_on_a_telephone_or_a_large_screen() {
    let source = axe();
    let daemon = daemon();
    let browser = Browser::start(1920, 1080, &[]);
    let mut found = Vec::new();
    browser.open(&link(&daemon, &[]));
    browser.until_shown("Overview");
    let links = browser.ask(
        "return [...document.querySelectorAll('#bar nav a')].map((one) => one.getAttribute('href'))",
    );
    let mut pages: Vec<String> = serde_json::from_value(links).unwrap();
    assert!(pages.len() >= 3, "{pages:?}");
    pages.extend(["/component/demo", "/component/nobody", "/nowhere"].map(str::to_owned));
    for page in &pages {
        show(&browser, page);
        check(&browser, &source, page, &mut found);
    }
    // What opens on a page.
    show(&browser, "/component/demo");
    browser.click("[data-port='demo/position'] button");
    browser.until("its value is shown", "document.querySelector('[data-detail] .value')");
    check(&browser, &source, "an opened port", &mut found);
    browser.look(1920, 1080, false);
    show(&browser, "/graph");
    browser.until("the graph is drawn", "document.querySelector('.edge')");
    browser.press("[data-edge='mission/position']", "m");
    browser.until("the menu is open", "document.getElementById('menu')");
    check(&browser, &source, "a menu", &mut found);
    browser.press("#menu button", "\u{E007}");
    browser.until("the question is there", "document.querySelector('dialog')");
    check(&browser, &source, "a question", &mut found);
    browser.ask("document.querySelector('dialog').close()");
    browser.ask("document.querySelector('.who').open = true");
    check(&browser, &source, "the session", &mut found);
    browser.ask("document.getElementById('sign-out').click()");
    browser.until_shown("Run genomctl web on the robot");
    check(&browser, &source, "signing in", &mut found);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Shows a page, whole and with the values that it has.
#[track_caller]
fn show(browser: &Browser, page: &str) {
    browser.with(
        "document.querySelector('main').replaceChildren();
         history.pushState(null, '', arguments[0]); dispatchEvent(new Event('popstate'))",
        vec![json!(page)],
    );
    browser.until(&format!("{page} is shown"), "document.querySelector('main h1')");
    browser.until(
        &format!("{page} has values"),
        "!document.getElementById('state') || document.getElementById('state').innerText !== '…' \
         || !document.querySelector('main table, main svg, main ol')",
    );
}
