//! Pictures of the console for the pages of the documentation.
//!
//! `UPDATE_EXPECT=1 cargo test --workspace --test all -- web::pictures` takes them anew. Otherwise
//! what they show must still be there to be pictured; pixels are not compared.

use std::fs;
use std::path::PathBuf;

use genom_tests::browser::Browser;
use genom_tests::{Daemon, Home, component, path, repository};
use serde_json::json;

use super::visitor::{link, set_speed};

/// Size of pictures in pixels.
const SIZE: (u32, u32) = (1280, 760);
/// Greatest size of a file in bytes.
const LARGEST: u64 = 150_000;

/// The mission of configs/mission.toml and the pipeline of configs/pipeline.toml on one daemon.
fn robot() -> Daemon {
    let components = |text: &str, names: &[&str]| {
        let start = text.find("[[component]]").unwrap();
        names.iter().fold(text[start..].to_owned(), |text, name| {
            let library = path(&component(name).library).to_owned();
            text.replace(&format!("library = \"{name}\""), &format!("library = {library:?}"))
        })
    };
    let read = |name: &str| fs::read_to_string(repository().join("configs").join(name)).unwrap();
    let pipeline = components(&read("pipeline.toml"), &["camera", "stereo", "viewer"]);
    let mission = components(&read("mission.toml"), &["demo", "mission"]);
    let text = format!("backend = \"shm\"\n{mission}\n{pipeline}");
    let text = text.replace("library = ", "cell = \"CELL\"\nlibrary = ");
    let text = ["control", "control", "eyes", "eyes", "eyes"]
        .iter()
        .fold(text, |text, cell| text.replacen("CELL", cell, 1));
    Home::new().configured(&text).start(&["--web"])
}

#[test]
fn the_pictures_in_the_documentation_show_what_is_there() {
    let daemon = robot();
    set_speed(&daemon, "0.05");
    daemon.ctl(&["start", "mission", "patrol", "rounds=1000"]).expect_code(0);
    let browser = Browser::start(SIZE.0, SIZE.1, &[]);
    browser.open(&link(&daemon, &[]));
    browser.until_shown("Overview");
    browser.look(SIZE.0, SIZE.1, false);
    browser.until(
        "five components run, and say what they do",
        "document.querySelectorAll('#components .pill.good').length === 5 \
         && document.querySelector('[data-component=camera] [data-label=Activities]').innerText === '1'",
    );
    pictured(&browser, "web-overview");
    browser.click("a[href='/component/demo']");
    browser.until(
        "the motion of the mission is seen",
        "document.querySelector('[data-service=goto] [data-state=main].lit')",
    );
    pictured(&browser, "web-component");
    browser.ask("document.querySelector('a[href=\"/graph\"]').click()");
    browser.until(
        "all connections have rates",
        "document.querySelectorAll('.node').length === 5 && document.querySelector('.edge.call') \
         && [...document.querySelectorAll('.rate')].filter((one) => one.textContent.includes('Hz')).length === 8",
    );
    pictured(&browser, "web-graph");
}

/// Takes a picture where that is asked for, and makes sure that there is one of the right size.
#[track_caller]
fn pictured(browser: &Browser, name: &str) {
    // The pointer lights up what it is on, and messages go.
    browser
        .ask("document.getElementById('notes').replaceChildren(); document.activeElement.blur()");
    browser.until("nothing moves", "document.getAnimations().length === 0");
    let file: PathBuf = repository().join(format!("docs/{name}.png"));
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        fs::write(&file, browser.picture()).unwrap();
    }
    let Ok(picture) = fs::read(&file) else {
        panic!("no {}: UPDATE_EXPECT=1 takes it", file.display())
    };
    let shown = image::load_from_memory(&picture).unwrap();
    assert_eq!((shown.width(), shown.height()), SIZE, "{name}");
    assert!(picture.len() as u64 <= LARGEST, "{name}: {} bytes", picture.len());
    assert_ne!(json!(null), browser.ask("return document.querySelector('main h1').innerText"));
}
