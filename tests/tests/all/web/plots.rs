//! Plots: every sample counts, whatever the page and the network do.

use genom_tests::browser::Browser;
use genom_tests::{Daemon, Home, fixture, request, until};
use serde_json::{Value, json};
use tempfile::TempDir;

use super::visitor::{Visitor, link, next};

/// A daemon with the component `sights`, which writes a sample each millisecond.
pub(super) fn sights(folder: &TempDir) -> Daemon {
    let description = fixture("sights", "sights", folder.path());
    Home::new().start(&["--web", &description])
}

/// A browser on the page of a component, in which whoever may read and call is signed in.
pub(super) fn page_of(daemon: &Daemon, component: &str) -> Browser {
    let browser = Browser::start(1280, 1000, &[]);
    browser.open(&link(daemon, &["--rights", "read,call"]));
    browser.until_shown("Overview");
    browser.click(&format!("a[href='/component/{component}']"));
    browser.until_shown("Ports");
    browser
}

#[test]
fn every_sample_is_in_exactly_one_column() {
    let folder = TempDir::new().unwrap();
    let daemon = sights(&folder);
    let owner = Visitor::with_link(&link(&daemon, &[]));
    // Two columns a second: a value read twice a second would miss nearly every spike.
    let path = "/components/sights/plots?columns=2%26plot=wave%2523spike,count,row%5B1%5D";
    let mut live = owner.follows(&format!("/live?rate=30&watch={path}"));
    let begun = next(&mut live, |told| told["kind"] == "plots");
    let plot = &begun["told"]["plots"][0];
    assert_eq!(
        (&plot["port"], &plot["leaves"]),
        (&json!("sights/wave"), &json!(["spike", "count", "row[1]"]))
    );
    let known = plot["known"].as_array().unwrap();
    assert!(known.contains(&json!("row[2]")) && known.contains(&json!("value")), "{known:?}");
    let (mut all, mut lost) = (Vec::new(), 0);
    while all.len() < 4 {
        let told = next(&mut live, |told| told["kind"] == "columns");
        let plot = &told["told"]["plots"][0];
        all.extend(plot["columns"].as_array().expect("columns").iter().cloned());
        lost = plot["lost"].as_u64().unwrap();
    }
    // The first one began before anybody looked. Samples are numbered by the component.
    let number = |column: &Value, at: usize| column["values"][1][at].as_f64().unwrap();
    let mut missing = 0.0;
    for pair in all[1..].windows(2) {
        let (one, other) = (&pair[0], &pair[1]);
        let apart = other["at"].as_u64().unwrap() - one["at"].as_u64().unwrap();
        assert!(apart > 0 && apart.is_multiple_of(500_000_000), "{one} {other}");
        missing += number(one, 3) - number(one, 0) + 1.0 - one["samples"].as_f64().unwrap();
        missing += number(other, 0) - number(one, 3) - 1.0;
        assert_eq!((number(one, 1), number(one, 2)), (number(one, 0), number(one, 3)));
        assert_eq!(one["values"][2], json!([2.0, 2.0, 2.0, 2.0]));
        // One sample of 500 is a spike: as many of them have one.
        if one["samples"].as_u64().unwrap() >= 500 && lost == 0 {
            assert_eq!(one["values"][0][2], 1000.0, "{one}");
        }
    }
    // None, unless this machine kept the daemon from looking for a second: then they are counted.
    assert!(missing <= lost as f64, "{missing} samples are missing, {lost} are told: {all:?}");
}

#[test]
fn nothing_is_taken_of_a_port_once_nobody_looks() {
    let folder = TempDir::new().unwrap();
    let daemon = sights(&folder);
    let owner = Visitor::with_link(&link(&daemon, &[]));
    let path = "/live?rate=30&watch=/components/sights/plots?plot=wave";
    let open: Vec<_> = (0..16).map(|_| owner.follows(path)).collect();
    drop(open);
    // The streams end with their pages, and so do the slots that they take.
    until("all have ended", || {
        let again: Vec<_> = (0..16).map(|_| owner.looks_into("/live?watch=/components")).collect();
        again.iter().all(|status| *status == 200)
    });
    let (stopped, _home) = daemon.stop("TERM");
    assert!(!stopped.err.contains("WARN"), "{}", stopped.err);
}

#[test]
fn what_cannot_be_plotted_is_refused_with_the_reason() {
    let folder = TempDir::new().unwrap();
    let daemon = sights(&folder);
    let owner = Visitor::with_link(&link(&daemon, &[]));
    let refused = |query: &str| {
        let reply = owner.gets(&format!("/api/components/sights/plots{query}"));
        (reply.status, reply.json()["error"]["message"].as_str().unwrap_or_default().to_owned())
    };
    let many = format!("?{}", "plot=wave&".repeat(65).trim_end_matches('&'));
    let leaves = format!("?plot=wave%23{}", ["value"; 17].join(","));
    for (query, status, told) in [
        ("", 422, "0 plots"),
        (many.as_str(), 422, "65 plots"),
        ("?plot=wave&columns=0", 422, "columns"),
        ("?plot=wave&columns=1e9", 422, "columns"),
        ("?plot=wave&columns=NaN", 422, "columns"),
        ("?plot=wave&rate=3", 400, "`rate`"),
        ("?plot=wav", 404, "no port"),
        ("?plot=wave/left", 422, "single"),
        ("?plot=wave%23valu", 422, "no member `valu`"),
        ("?plot=wave%23row%5B3%5D", 422, "no element [3]"),
        ("?plot=wave%23row%5B99999999999999999999%5D", 422, "no path"),
        ("?plot=wave%23row", 422, "no number"),
        (leaves.as_str(), 422, "17 numbers"),
    ] {
        let (found, message) = refused(query);
        assert_eq!(found, status, "{query}: {message}");
        assert!(message.contains(told), "{query}: {message}");
    }
    assert_eq!(owner.gets("/api/components/nobody/plots?plot=a").status, 404);
    let nobody = Visitor::with_link(&link(&daemon, &["--rights", "wire"]));
    for path in ["plots?plot=wave", "ports/picture/image", "tasks/histograms"] {
        assert_eq!(nobody.gets(&format!("/api/components/sights/{path}")).status, 403, "{path}");
    }
    assert_eq!(nobody.gets("/api/timeline/stream").status, 403);
}

#[test]
fn a_page_shows_the_spike_that_is_there_for_one_millisecond() {
    let folder = TempDir::new().unwrap();
    let daemon = sights(&folder);
    let browser = page_of(&daemon, "sights");
    browser.click("[data-port='sights/wave'] button");
    let line = |name: &str, text: &str| {
        format!(
            "[...document.querySelectorAll('[data-detail=\"sights/wave\"] .legend li')].some((line) => \
             line.innerText.startsWith('{name}') && line.innerText.includes('{text}'))"
        )
    };
    browser.until("the spike is in the plot", &line("spike", "[0 … 1000]"));
    browser.until("so is the wave", &line("value", "[-1 … 1]"));
    browser.until_shown("all of them in the plot");
    let told = browser.ask("return document.querySelector('.plot-told').innerText");
    assert!(!told.as_str().unwrap().contains("lost"), "{told}");
    // Something is drawn: the band reaches from the bottom to the top.
    browser.until(
        "it is drawn",
        "(() => { const canvas = document.querySelector('.plot'); \
         const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data; \
         let seen = 0; for (let at = 3; at < data.length; at += 4) seen += data[at] > 0; \
         return seen > 1000; })()",
    );
    // By keyboard: what a column has is read out.
    browser.press(".plot", "\u{E012}\u{E012}");
    browser.until(
        "it is read out",
        "/spike .* samples/.test(document.querySelector('.plot-read').innerText)",
    );
    let label = browser.ask("return document.querySelector('.plot').getAttribute('aria-label')");
    assert!(label.as_str().unwrap().starts_with("sights/wave, the last 20 s: value"), "{label}");
    // Other numbers, also of an array.
    browser.write(".plot-tools input", "row[2]\u{E007}");
    browser.until("another number", &line("row[2]", "[3 … 3]"));
    browser.write(".plot-tools input", "rows\u{E007}");
    browser.until_shown("has no member `rows`");
    browser.write(".plot-tools input", "spike\u{E007}");
    browser.until("it goes on", &line("spike", "[0 … 1000]"));
}

#[test]
fn a_sequence_of_structs_is_a_table_and_its_texts_stay_texts() {
    let folder = TempDir::new().unwrap();
    let daemon = sights(&folder);
    let browser = page_of(&daemon, "sights");
    browser.click("[data-port='sights/seen'] button");
    let hostile = "<img src=x onerror=window.hacked=1>\u{202e}";
    let points: Vec<_> = (0..120)
        .map(|at| json!({"x": at, "y": f64::from(at) / 3.0, "label": if at == 1 { hostile } else { "" }}))
        .collect();
    let published = request(
        &daemon.home().socket(),
        "POST",
        "/components/sights/ports/seen",
        &json!(points).to_string(),
    );
    assert_eq!(published.status, 200, "{:?}", published.body);
    browser.until_shown("120 elements, the first 100 shown");
    let cells = browser.ask(
        "return [...document.querySelectorAll('.sequence tbody tr:nth-child(2) > *')].map((one) => one.textContent)",
    );
    assert_eq!(cells, json!(["1", "1", "0.33333", "<img src=x onerror=window.hacked=1>⟨U+202E⟩"]));
    let heads = browser.ask(
        "return [...document.querySelectorAll('.sequence thead th')].map((one) => one.innerText)",
    );
    assert_eq!(heads, json!(["", "x", "y", "label"]));
    assert_eq!(browser.ask("return window.hacked ?? null"), json!(null));
}
