//! Measures the pages of the web console in Chromium: what each loads and how soon it can be used,
//! and frames of the graph of 100 components and 400 connections while rates change.
//!
//! `cargo run -p genom-tests --bin console [COMPONENTS]`, on an idle machine.

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program of the tests")]

use genom_tests::Home;
use genom_tests::browser::Browser;
use genom_tests::mesh::mesh;
use genom_tests::pace::{Hand, frames, load};

fn main() {
    let count = std::env::args().nth(1).map_or(100, |count| count.parse().unwrap());
    let made = tempfile::tempdir().unwrap();
    let daemon = Home::new().configured(&mesh(count, made.path())).start(&["--web"]);
    let link = || daemon.json(&["web"])["url"].as_str().unwrap().to_owned();
    println!("{:28} {:>8} {:>8} {:>10}", "page", "requests", "kB", "usable, ms");
    for page in ["/", "/component/part00", "/graph", "/logs"] {
        // Nothing of it is in the browser; the session is.
        let browser = Browser::start(1920, 1080, &[]);
        browser.open(&link());
        browser.until("somebody is signed in", "document.querySelector('#rights')");
        browser.forget_files();
        let loaded = load(&browser, &format!("{}{page}", origin(&browser)));
        #[allow(clippy::cast_precision_loss, reason = "small numbers")]
        let size = loaded.bytes as f64 / 1e3;
        println!("{page:28} {:8} {size:8.0} {:10.0}", loaded.requests, loaded.milliseconds);
    }
    println!("\n{:28} {:>8} {:>10} {:>10}", "frames", "a second", "median, ms", "95 %, ms");
    let browser = Browser::start(1920, 1080, &[]);
    browser.open(&link());
    for level in ["components", "ports"] {
        let address = format!("{}/graph?level={level}", origin(&browser));
        browser.open(&address);
        browser.until(
            "rates are shown",
            "[...document.querySelectorAll('.rate')].some((one) => one.textContent.includes('Hz'))",
        );
        for hand in [Hand::Still, Hand::Pans, Hand::Zooms, Hand::Points] {
            let found = frames(&browser, hand);
            let what = format!("{level}, {hand:?}");
            println!("{what:28} {:8.0} {:10.1} {:10.1}", found.rate, found.median, found.most);
        }
    }
}

fn origin(browser: &Browser) -> String {
    browser.ask("return location.origin").as_str().unwrap().to_owned()
}
