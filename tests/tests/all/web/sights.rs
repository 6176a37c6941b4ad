//! Images, histograms, and the time in each state.

use genom_tests::request;
use serde_json::{Value, json};
use tempfile::TempDir;

use super::plots::{page_of, sights};
use super::visitor::{Visitor, demo, link, set_speed};

/// Publishes to an in port of `sights`.
fn publish(daemon: &genom_tests::Daemon, port: &str, value: &Value) {
    let at = format!("/components/sights/ports/{port}");
    let published = request(&daemon.home().socket(), "POST", &at, &value.to_string());
    assert_eq!(published.status, 200, "{:?}", published.body);
}

/// The colour of a pixel of the image of a port.
fn pixel(port: &str, x: u32, y: u32) -> String {
    format!(
        "[...(document.querySelector('[data-detail=\"sights/{port}\"] canvas')?.getContext('2d')\
         .getImageData({x}, {y}, 1, 1).data ?? [])]"
    )
}

#[test]
fn images_are_drawn_in_their_colours_and_their_size_is_told() {
    let folder = TempDir::new().unwrap();
    let daemon = sights(&folder);
    let browser = page_of(&daemon, "sights");
    browser.click("[data-port='sights/picture'] button");
    browser.until_shown("no image yet");
    // A row is longer than its pixels.
    let data = [[255, 0, 0, 0, 255, 0, 9], [0, 0, 255, 10, 20, 30, 9]].concat();
    for (encoding, first, last) in
        [("rgb8", "255,0,0,255", "10,20,30,255"), ("bgr8", "0,0,255,255", "30,20,10,255")]
    {
        let image = json!({"height": 2, "width": 2, "encoding": encoding, "step": 7, "data": data});
        publish(&daemon, "picture", &image);
        browser.until(encoding, &format!("{}.join() === '{first}'", pixel("picture", 0, 0)));
        browser.until(encoding, &format!("{}.join() === '{last}'", pixel("picture", 1, 1)));
    }
    let label = "document.querySelector('.picture').getAttribute('aria-label')";
    browser.until(
        "it has a name",
        &format!("{label}.startsWith('Image of sights/picture: 2 × 2 px, sample ')"),
    );
    for (encoding, big, data) in [
        ("mono8", 0, vec![50, 60]),
        ("mono16", 0, vec![1, 50, 1, 60]),
        ("mono16", 1, vec![50, 2, 60, 2]),
    ] {
        publish(
            &daemon,
            "picture",
            &json!({
                "height": 1, "width": 2, "encoding": encoding, "is_bigendian": big, "step": data.len(), "data": data,
            }),
        );
        browser.until(encoding, &format!("{}.join() === '60,60,60,255'", pixel("picture", 1, 0)));
        publish(&daemon, "picture", &json!({"width": 1, "height": 1, "step": 2, "data": [0, 0]}));
        browser.until("another one", "document.querySelector('.picture').width === 1");
    }
    // What does not fit together is told, and does not end the page.
    publish(&daemon, "picture", &json!({"width": 4_000_000_000_u32, "height": 4_000_000_000_u32}));
    browser.until_shown("it is too large to be shown");
    publish(&daemon, "picture", &json!({"width": 5, "height": 5, "encoding": "rgb8", "step": 15}));
    browser.until_shown("are not 2 bytes");
    publish(&daemon, "picture", &json!({"encoding": "<b>bayer</b>"}));
    browser.until_shown("`<b>bayer</b>` is no encoding that is shown");
}

#[test]
fn a_compressed_image_is_drawn_by_the_browser() {
    let folder = TempDir::new().unwrap();
    let daemon = sights(&folder);
    let browser = page_of(&daemon, "sights");
    browser.click("[data-port='sights/photo'] button");
    browser.until_shown("no image yet");
    for format in ["jpeg", "png"] {
        // The browser makes one: 8 by 6 pixels of one colour.
        let bytes = browser.with(
            "const canvas = document.createElement('canvas'); [canvas.width, canvas.height] = [8, 6]; \
             const pen = canvas.getContext('2d'); pen.fillStyle = 'rgb(200, 100, 50)'; \
             pen.fillRect(0, 0, 8, 6); \
             const text = atob(canvas.toDataURL(`image/${arguments[0]}`).split(',')[1]); \
             return [...text].map((sign) => sign.charCodeAt(0))",
            vec![json!(format)],
        );
        publish(
            &daemon,
            "photo",
            &json!({"format": format!("rgb8; {format} compressed"), "data": bytes}),
        );
        let near = format!(
            "{}.every((part, at) => Math.abs(part - [200, 100, 50, 255][at]) < 6) && \
             document.querySelector('.picture').width === 8",
            pixel("photo", 4, 3)
        );
        browser.until(format, &near);
        publish(&daemon, "photo", &json!({"format": "svg", "data": b"<svg onload=alert(1)>"}));
        browser.until_shown("`svg` is no format that is shown");
    }
    publish(&daemon, "photo", &json!({"format": "jpeg", "data": [0xFF, 0xD8, 0xFF, 0xE0, 0, 1]}));
    browser.until_shown("the compressed image is damaged");
}

#[test]
fn an_image_is_sent_once_and_no_wider_than_asked_for() {
    let folder = TempDir::new().unwrap();
    let daemon = sights(&folder);
    let owner = Visitor::with_link(&link(&daemon, &[]));
    let path = "/api/components/sights/ports/picture/image";
    assert_eq!(owner.gets(path).body, "", "before the first one");
    let data: Vec<u8> = (0..64 * 2).map(|at| at % 64).collect();
    publish(
        &daemon,
        "picture",
        &json!({"height": 2, "width": 64, "encoding": "mono8", "step": 64, "data": data}),
    );
    let shown = |query: &str| {
        let reply = owner.gets(&format!("{path}{query}"));
        (reply.header("image-width").map(str::to_owned), reply)
    };
    genom_tests::until("it is read", || shown("").0.is_some());
    let (width, reply) = shown("?width=16");
    assert_eq!((width.as_deref(), reply.header("image-whole")), (Some("16"), Some("64x2")));
    let sample = reply.header("image-sample").unwrap();
    assert_eq!(shown(&format!("?width=16&seen={sample}")).0, None);
    for query in
        ["?width=0", "?width=4097", "?width=-1", "?width=x", "?seen=x", "?wide=1", "?element=a"]
    {
        assert!(matches!(shown(query).1.status, 400 | 422), "{query}");
    }
    let none = owner.gets("/api/components/sights/ports/wave/image");
    assert!(none.status == 422 && none.body.contains("no image"), "{none:?}");
}

#[test]
fn histograms_grow_while_they_are_open_and_a_late_task_is_seen() {
    let folder = TempDir::new().unwrap();
    let daemon = sights(&folder);
    let browser = page_of(&daemon, "sights");
    browser.click("#histograms summary");
    browser.until(
        "work is counted",
        "/Lateness of main [\\d,]+ in the last two minutes: half within [\\d.]+ (ns|µs|ms)/\
         .test(document.querySelector('[data-task=main]')?.innerText)",
    );
    daemon.ctl(&["call", "sights", "lag", "milliseconds=300"]).expect_code(0);
    browser.until(
        "the long cycle is in the histogram",
        "/Duration of main .* the longest 3\\d\\d ms/.test(document.querySelector('[data-task=main]').innerText)",
    );
    let drawn = browser.ask(
        "return [...document.querySelectorAll('.heat')].map((canvas) => { \
         const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data; \
         return data.some((part) => part > 0); })",
    );
    assert_eq!(drawn, json!([true, true]));
}

#[test]
fn the_time_in_each_state_of_an_activity_is_told() {
    let daemon = demo(genom_tests::Home::new(), &[]);
    set_speed(&daemon, "0.01");
    let _ = daemon.json(&["start", "demo", "goto", "goal=0.5"]);
    let browser = page_of(&daemon, "demo");
    browser.click("[data-service=goto] .spent summary");
    let row = |state: &str| {
        format!("document.querySelector('[data-service=goto] [data-spent=\"{state}\"]')")
    };
    browser.until("it is in main", &format!("{}?.innerText.includes('#')", row("main")));
    let seconds = format!("parseFloat({}.children[2].innerText)", row("main"));
    let before = browser.ask(&format!("return {seconds}"));
    assert!(before.as_f64().is_some(), "{before}");
    set_speed(&daemon, "2");
    browser
        .until("nothing is in it any more", &format!("!{}.innerText.includes('#')", row("main")));
    let entered = browser.ask(&format!("return {}.children[1].innerText", row("main")));
    assert_eq!(entered, json!("1"));
}
