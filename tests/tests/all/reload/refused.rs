//! Libraries that do not fit, and moments that are none: the component goes on as it was.

use std::fs;

use genom_tests::{Daemon, until};

use super::{Author, C, GEN, count, listed, text};

#[test]
fn what_does_not_fit_is_refused_and_the_component_goes_on() {
    let author = Author::new();
    let library = author.save(1);
    let daemon = Daemon::start(&[text(&library)]);
    let whole = fs::read(&library).unwrap();
    let refused = |name: &str, why: &str| {
        let at = author.at(name);
        daemon.ctl(&["reload", "edit", text(&at)]).expect_err(why).expect_code(1);
        let before = count(&daemon);
        until("it goes on", || count(&daemon) > before);
        assert_eq!(listed(&daemon, "edit")["library"], text(&library));
    };
    let given = |name: &str, bytes: &[u8], why: &str| {
        fs::write(author.at(name), bytes).unwrap();
        fs::write(author.at(&name.replace(".so", ".gen")), GEN).unwrap();
        refused(name, why);
    };
    given("cut.so", &whole[..whole.len() / 2], "truncated");
    given("empty.so", &[], "it is empty");
    given("text.so", b"component edit {};", "it looks like text");
    refused("gone.so", "there is no ");
    author.make("lacking.so", &C.replace("edit_run(", "edit_ran("), 1);
    fs::copy(author.at("edit.gen"), author.at("lacking.gen")).unwrap();
    refused("lacking.so", "codel `edit_run`");
    let header = fs::read_to_string(author.at("edit_c_types.h")).unwrap();
    let wide = C.replace("#include \"edit_c_types.h\"", &header);
    let wide = wide.replace("int32_t *count, int32_t more", "int64_t *count, int32_t more");
    author.make("wide.so", &wide, 1);
    fs::copy(author.at("edit.gen"), author.at("wide.gen")).unwrap();
    refused("wide.so", "count");
    let demo = genom_tests::component("demo").library;
    daemon.ctl(&["reload", "edit", text(&demo)]).expect_err("one of demo").expect_code(1);
    daemon.ctl(&["reload", "nobody"]).expect_err("no component `nobody`").expect_code(1);
    // The file itself is gone, or half of it is there: as with any other.
    fs::write(&library, &whole[..whole.len() / 3]).unwrap();
    daemon.ctl(&["reload", "edit"]).expect_err("truncated").expect_code(1);
    fs::remove_file(&library).unwrap();
    daemon.ctl(&["reload", "edit"]).expect_err("there is no ").expect_code(1);
    author.save(1_000_000);
    daemon.ctl(&["reload", "edit"]).expect_code(0);
    until("it counts by the new step", || count(&daemon) > 1_000_000);
}

#[test]
fn while_a_codel_does_not_return_nothing_is_exchanged() {
    let author = Author::new();
    let library = author.save(1);
    let daemon = Daemon::start(&[text(&library)]);
    daemon.ctl(&["start", "edit", "hang"]).expect_code(0);
    author.save(1_000_000);
    let refused = daemon.ctl(&["reload", "edit"]);
    refused.expect_err("codel edit_hang of hang has been running").expect_code(1);
    daemon.ctl(&["call", "edit", "release"]).expect_code(0);
    until("it goes on", || count(&daemon) > 0);
    assert!(count(&daemon) < 1_000_000);
    daemon.ctl(&["reload", "edit"]).expect_code(0);
    until("it counts by the new step", || count(&daemon) > 1_000_000);
}

#[test]
fn a_reload_and_an_unload_at_once_leave_no_half_component() {
    let author = Author::new();
    let library = author.save(1);
    let daemon = Daemon::start(&[]);
    for _ in 0..10 {
        daemon.ctl(&["load", text(&library)]).expect_code(0);
        let all: Vec<_> = (0..3).map(|_| daemon.spawn(&["reload", "edit"])).collect();
        daemon.ctl(&["unload", "edit"]).expect_code(0);
        for one in all {
            // Done before, refused beside another one, or too late.
            let said = one.finish();
            assert!(!said.err.contains("internal"), "{}", said.err);
        }
    }
    assert_eq!(daemon.json(&["list"])["components"].as_array().unwrap().len(), 0);
    until("nothing is left", || super::mapped(daemon.process().id(), "edit.so") == 0);
}
