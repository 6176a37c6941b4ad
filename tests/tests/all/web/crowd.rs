//! A hundred components with four hundred connections.

use genom_tests::browser::Browser;
use genom_tests::mesh::mesh;
use genom_tests::pace::load;
use genom_tests::{Daemon, Home};
use tempfile::TempDir;

use super::visitor::link;

/// Greatest size of a page with all that it loads, in bytes.
const LARGEST: u64 = 400_000;

fn crowd() -> (TempDir, Daemon) {
    let made = TempDir::new().unwrap();
    let daemon = Home::new().configured(&mesh(100, made.path())).start(&["--web"]);
    (made, daemon)
}

fn count(browser: &Browser, css: &str) -> u64 {
    let script = format!("return document.querySelectorAll(\"{css}\").length");
    browser.ask(&script).as_u64().unwrap()
}

#[test]
fn a_hundred_components_stay_readable_are_found_and_unfolded() {
    let (_made, daemon) = crowd();
    let browser = Browser::start(1600, 1000, &[]);
    browser.open(&link(&daemon, &["--rights", "read"]));
    browser.click("a[href='/graph']");
    browser.until_shown("100 components, 400 connections");
    browser.until("all are drawn", "document.querySelectorAll('.node').length === 100");
    // So many are folded, and their names as large as they fit.
    assert_eq!(count(&browser, ".port"), 0);
    let heights = browser.ask(
        "return Math.min(...[...document.querySelectorAll('.node .large')].map((one) => one.getBoundingClientRect().height))",
    );
    assert!(heights.as_f64().unwrap() >= 9.0, "names are {heights} pixels high");
    let covered = browser.ask(
        "const boxes = [...document.querySelectorAll('.node .body')].map((one) => one.getBoundingClientRect());
         return boxes.filter((one, at) => boxes.some((other, place) => place > at && one.left < other.right
           && other.left < one.right && one.top < other.bottom && other.top < one.bottom)).length",
    );
    assert_eq!(covered, 0, "components cover each other");
    // What is looked for is shown with its neighbours; the address can be shared.
    browser.write("#find", "part42");
    browser.until(
        "others are gone",
        "document.querySelectorAll('.node').length < 40 && document.querySelector('[data-node=part42]:not(.beside)')",
    );
    browser.until_shown("not shown");
    assert_eq!(browser.ask("return location.search"), "?find=part42");
    browser.press("[data-key='component part42']", "m");
    browser.until("the menu is open", "document.getElementById('menu')");
    browser.ask("[...document.querySelectorAll('#menu button')].find((one) => one.innerText === 'Unfold').click()");
    browser.until("its ports are there", "document.querySelectorAll('.port.in').length === 4");
    browser.open(&format!("{}/graph?level=ports", origin(&browser)));
    browser.until("all ports are there", "document.querySelectorAll('.port').length === 600");
    browser.until(
        "rates are shown",
        "[...document.querySelectorAll('.rate')].filter((one) => one.textContent.includes('Hz')).length > 300",
    );
    // From afar only names are shown; nearer, also ports.
    browser.until("all is seen from afar", "document.querySelector('#graph.far')");
    let shown = "getComputedStyle(document.querySelector('.node:not(.away) .port text')).display !== 'none'";
    assert_eq!(browser.ask(&format!("return {shown}")), false);
    for _ in 0..6 {
        browser.click("[aria-label=Larger]");
    }
    browser.until("ports are named", shown);
    browser.click("[aria-label^=Fit]");
    browser.until("all is seen again", "document.querySelector('#graph.far')");
}

#[test]
fn cells_are_folded_into_one_and_unfolded() {
    let made = TempDir::new().unwrap();
    let text = mesh(3, made.path());
    let text = text.replace("name = \"part00\"", "cell = \"left\"\nname = \"part00\"");
    let text = text.replace("name = \"part01\"", "cell = \"left\"\nname = \"part01\"");
    let text = text.replace("\"local\"", "\"shm\"");
    let daemon = Home::new().configured(&text).start(&["--web"]);
    let browser = Browser::start(1280, 900, &[]);
    browser.open(&link(&daemon, &["--rights", "read"]));
    browser.click("a[href='/graph']");
    browser.until("all are drawn", "document.querySelectorAll('.node.component').length === 3");
    browser.open(&format!("{}/graph?level=cells", origin(&browser)));
    browser.until(
        "the cell is one",
        "document.querySelectorAll('.node.cell').length === 1 && document.querySelectorAll('.node.component').length === 1",
    );
    browser.press("[data-key='fold cell left']", "\u{E007}");
    browser.until("it is unfolded", "document.querySelectorAll('.node.component').length === 3");
}

#[test]
fn pages_are_small_to_load() {
    let (_made, daemon) = crowd();
    let browser = Browser::start(1600, 1000, &[]);
    browser.open(&link(&daemon, &["--rights", "read"]));
    browser.until_shown("Overview");
    let origin = origin(&browser);
    for page in ["/", "/component/part00", "/graph", "/logs"] {
        browser.forget_files();
        let loaded = load(&browser, &format!("{origin}{page}"));
        println!("{page}: {loaded:?}");
        assert!(loaded.bytes > 20_000, "{page} was not loaded anew: {loaded:?}");
        assert!(loaded.bytes < LARGEST, "{page}: {loaded:?}");
    }
}

fn origin(browser: &Browser) -> String {
    browser.ask("return location.origin").as_str().unwrap().to_owned()
}
