//! The page of deployments in a real browser: a plan, its steps, what is refused and where.

use std::fs;

use genom_tests::browser::Browser;
use genom_tests::{Home, component, path};
use serde_json::json;

use super::visitor::{Visitor, demo, link};

const ENTER: &str = "\u{E007}";

/// A browser in which somebody with these rights looks at the page.
fn shown(link: &str) -> Browser {
    let browser = Browser::start(1280, 900, &[]);
    browser.open(link);
    browser.click("a[href='/deployment']");
    browser.until("what runs is there", "document.getElementById('running')?.innerText");
    browser
}

/// Writes a text into the field, as somebody does who pastes it.
fn paste(browser: &Browser, text: &str) {
    browser.with(
        "const field = document.getElementById('text'); field.value = arguments[0];
         field.dispatchEvent(new Event('input'))",
        vec![json!(text)],
    );
}

#[test]
fn a_file_is_planned_applied_step_by_step_and_pruned() {
    let daemon = demo(Home::new(), &[]);
    let mission = component("mission");
    let browser = shown(&link(&daemon, &[]));
    let file = format!(
        "[[component]]\nlibrary = \"{}\"\n\n\
         [[connection]]\nin = \"mission/position\"\nout = \"demo/position\"\n",
        path(&mission.library)
    );
    paste(&browser, &file);
    browser.click("#plan");
    browser.until_shown("2 steps to take. Beside the file, and kept: component demo.");
    let planned = "[...document.querySelectorAll('#steps li')].map((one) => one.dataset.status)";
    assert_eq!(browser.ask(&format!("return {planned}")), json!(["to do", "to do"]));
    // A plan is no step: nothing was done.
    assert_eq!(daemon.json(&["list"])["components"].as_array().unwrap().len(), 1);
    browser.click("#apply");
    browser.until_shown("Applied: 2 steps were taken.");
    assert_eq!(browser.ask(&format!("return {planned}")), json!(["done", "done"]));
    assert_eq!(daemon.json(&["connections"])["connections"][0]["in"], "mission/position");
    browser.until(
        "what runs is shown as it is now",
        "document.getElementById('running').innerText.includes('mission/position')",
    );
    // The same again is nothing; with what is beside it removed, it is a step. By keyboard.
    browser.press("#plan", ENTER);
    browser.until_shown("Nothing to do: all that the file says is so.");
    assert_eq!(browser.ask("return document.getElementById('apply').disabled"), true);
    paste(&browser, &format!("[[component]]\nlibrary = \"{}\"\n", path(&mission.library)));
    browser.press("#prune", " ");
    browser.press("#plan", ENTER);
    browser.until("the plan is there", "document.querySelectorAll('#steps li').length >= 2");
    browser.press("#apply", ENTER);
    browser.until_shown("Applied:");
    let left = daemon.json(&["list"]);
    let names: Vec<_> =
        left["components"].as_array().unwrap().iter().map(|one| &one["name"]).collect();
    assert_eq!(names, [&json!("mission")]);
}

#[test]
fn what_cannot_be_is_refused_at_its_place_and_undone() {
    let daemon = demo(Home::new(), &[]);
    let browser = shown(&link(&daemon, &[]));
    let selected = "return ((field) => field.value.slice(field.selectionStart, field.selectionEnd))\
                    (document.getElementById('text'))";
    paste(&browser, "backend = \"local\"\n\n[[component]]\nlibary = \"demo\"\n");
    browser.click("#plan");
    browser.until_shown("deployment.toml:4: unknown field `libary`");
    browser.until_shown("did you mean `library`?");
    assert_eq!(browser.ask(selected), "libary = \"demo\"");
    // Types that do not fit are found when the step is taken; all is as it was then.
    let mission = component("mission");
    paste(
        &browser,
        &format!(
            "[[component]]\nlibrary = \"{}\"\n\n\
             [[connection]]\nin = \"demo/parameter\"\nout = \"demo/position\"\n",
            path(&mission.library)
        ),
    );
    browser.click("#plan");
    browser.until_shown("2 steps to take.");
    browser.click("#apply");
    browser.until_shown("Not applied.");
    browser.until_shown("everything is as it was before");
    browser.until(
        "no step counts as done",
        "[...document.querySelectorAll('#steps li')].every((one) => one.dataset.status !== 'done')",
    );
    assert_eq!(daemon.json(&["list"])["components"].as_array().unwrap().len(), 1);
    // A file is shown as text, whatever is in it, and its place is told of it, too.
    paste(&browser, "[[component]]\nlibrary = \"<img src=x onerror=window.hacked=1>\"\n");
    browser.click("#plan");
    browser.until(
        "it answers",
        "document.getElementById('problem').innerText || document.querySelector('#steps li')",
    );
    assert_eq!(
        browser.ask("return [window.hacked ?? null, document.querySelectorAll('main img').length]"),
        json!([null, 0])
    );
}

#[test]
fn what_runs_is_saved_as_a_file_that_brings_it_back() {
    let daemon = demo(Home::new(), &[]);
    let browser = shown(&link(&daemon, &[]));
    // What the browser is given to save, without a dialog.
    browser.ask(
        "window.saved = []; const make = URL.createObjectURL;
         URL.createObjectURL = (blob) => { blob.text().then((text) => window.saved.push(text)); return make(blob); }",
    );
    browser.click("#save-running");
    browser.until("it is saved", "window.saved.length === 1");
    let saved = browser.ask("return window.saved[0]");
    let saved = saved.as_str().unwrap();
    assert_eq!(saved, daemon.json(&["dump"])["text"].as_str().unwrap());
    let file = daemon.home().path().join("saved.toml");
    fs::write(&file, saved).unwrap();
    daemon.ctl(&["unload", "demo"]).expect_code(0);
    daemon.ctl(&["apply", path(&file)]).expect_code(0);
    assert_eq!(daemon.json(&["list"])["components"][0]["name"], "demo");
    browser.click("#take-running");
    assert_eq!(browser.ask("return document.getElementById('text').value"), saved);
}

#[test]
fn what_is_written_is_still_there_after_a_look_at_another_page() {
    let daemon = demo(Home::new(), &[]);
    let browser = shown(&link(&daemon, &[]));
    paste(&browser, "[[component]]\nlibrary = \"arm.so\"\n");
    browser.click("a[href='/logs']");
    browser.until("the page is left", "!document.getElementById('text')");
    browser.click("a[href='/deployment']");
    browser.until("the page is back", "document.getElementById('text')");
    let written = browser.ask("return document.getElementById('text').value");
    assert_eq!(written, "[[component]]\nlibrary = \"arm.so\"\n");
}

#[test]
fn what_a_message_covers_can_be_scrolled_out_from_below_it() {
    let daemon = demo(Home::new(), &[]);
    let browser = shown(&link(&daemon, &[]));
    browser
        .ask("return import('/assets/dom.js').then(({ note }) => note('x'.repeat(400), 'error'))");
    browser.until("the message shows", "document.querySelector('.note')");
    browser.ask("window.scrollTo(0, document.documentElement.scrollHeight)");
    browser.until(
        "the last thing on the page is above the message",
        "document.querySelector('main').lastElementChild.getBoundingClientRect().bottom
            <= document.querySelector('.note').getBoundingClientRect().top",
    );
}

#[test]
fn whoever_may_not_deploy_is_not_offered_to_and_refused() {
    let daemon = demo(Home::new(), &[]);
    let rights = ["--rights", "read,call,wire"];
    let browser = shown(&link(&daemon, &rights));
    browser.until_shown("Your rights do not allow to apply a file.");
    assert_eq!(
        browser.ask("return document.querySelectorAll('main form, #apply, #plan').length"),
        0
    );
    let visitor = Visitor::with_link(&link(&daemon, &rights));
    for dry_run in [true, false] {
        let body = json!({"text": "", "file": "x.toml", "prune": true, "dry_run": dry_run});
        let refused = visitor.posts("/api/deployment", &body.to_string());
        assert_eq!((refused.status, refused.code().as_str()), (403, "right_missing"));
    }
    assert_eq!(daemon.json(&["list"])["components"].as_array().unwrap().len(), 1);
}
