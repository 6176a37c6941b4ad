//! Attacks on the route that sends what a component was made of: names that lead elsewhere, files
//! that are replaced, texts that are too long. Its right is checked with those of all routes
//! (`doors.rs`).

use std::fs;
use std::os::unix::fs::symlink;

use genom_tests::{Daemon, Reply, component, path, request};

const SECRET: &str = "kept to myself";

fn sources(daemon: &Daemon, name: &str) -> Reply {
    let socket = daemon.home().socket();
    request(&socket, "GET", &format!("/components/{name}/sources"), "")
}

/// A daemon with a demo of this name, described by a file of its own with this text at its end.
fn described(name: &str, more: impl AsRef<[u8]>) -> Daemon {
    let daemon = Daemon::start(&[]);
    let demo = component("demo");
    let file = daemon.home().path().join(format!("{name}.gen"));
    let text = [fs::read(&demo.description).unwrap(), more.as_ref().to_vec()].concat();
    fs::write(&file, text).unwrap();
    let load = ["load", path(&demo.library), "--name", name, "--gen-file", path(&file)];
    daemon.ctl(&load).expect_code(0);
    daemon
}

#[test]
fn no_name_of_a_component_leads_to_another_file() {
    let daemon = described("own", "");
    let secret = daemon.home().path().join("secret.gen");
    fs::write(&secret, format!("/* {SECRET} */ component secret {{ }};")).unwrap();
    let whole = path(&secret).replace('/', "%2f");
    for name in [
        "..",
        "%2e%2e",
        "secret",
        "secret.gen",
        "..%2fsecret.gen",
        "own%2f..%2fsecret.gen",
        "own%00",
        "%2fetc%2fpasswd",
        "%ff",
        &whole,
    ] {
        let reply = sources(&daemon, name);
        assert!(matches!(reply.status, 400 | 404), "{name}: {}", reply.status);
        let told = reply.body.to_string();
        assert!(!told.contains(SECRET) && !told.contains("root:"), "{name}: {told}");
    }
    assert_eq!(sources(&daemon, "own").status, 200);
}

#[test]
fn texts_are_those_that_were_loaded_whatever_has_come_in_the_place_of_their_files() {
    let daemon = described("own", "/* as it was loaded */\n");
    let file = daemon.home().path().join("own.gen");
    let secret = daemon.home().path().join("secret");
    fs::write(&secret, SECRET).unwrap();
    fs::remove_file(&file).unwrap();
    symlink(&secret, &file).unwrap();
    let told = sources(&daemon, "own").body.to_string();
    assert!(told.contains("as it was loaded") && !told.contains(SECRET), "{told}");
}

#[test]
fn a_description_that_is_too_long_to_be_sent_is_not_loaded() {
    let daemon = Daemon::start(&[]);
    let file = daemon.home().path().join("long.gen");
    fs::write(&file, format!("/* {} */\n", "x".repeat(17 << 20))).unwrap();
    let demo = component("demo");
    let load = ["load", path(&demo.library), "--name", "long", "--gen-file", path(&file)];
    daemon.ctl(&load).expect_err("it is larger than 16 MiB");
    assert_eq!(sources(&daemon, "long").status, 404);
}

#[test]
fn texts_that_are_too_long_once_they_are_decoded_are_refused() {
    // Latin-1: each byte is two in UTF-8, so what is read as 9 MiB would be sent as 18.
    let comment = [b"/* ".as_slice(), &vec![0xe9; 9 << 20], b" */\n"].concat();
    let daemon = described("accented", comment);
    let reply = sources(&daemon, "accented");
    assert_eq!((reply.status, reply.code()), (413, "too_large"), "{reply:?}");
    let error = &reply.body["error"];
    let message = error["message"].as_str().unwrap();
    assert!(message.starts_with("the description of accented has 18"), "{message}");
    assert_eq!(error["help"], "read it from its files");
    // It runs all the same, and who asks for it by genomctl is told.
    daemon.ctl(&["verify", "accented"]).expect_code(1).expect_err("has 18");
    assert_eq!(daemon.json(&["list"])["components"][0]["state"], "running");
}
