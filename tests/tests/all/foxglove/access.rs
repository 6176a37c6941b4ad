//! Who may connect: pages, names, tokens, and how many.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;

use genom_tests::{Home, component, path, until};
use serde_json::json;

use super::raw::Raw;
use super::visitor::{Client, address, demo, source};

#[test]
fn a_page_elsewhere_is_refused_and_programs_are_not() {
    let (daemon, address) = demo("", &[]);
    for origin in [
        "http://evil.example",
        "null",
        "",
        "http://localhost:3000",
        "https://app.foxglove.dev.evil.example",
        "http://app.foxglove.dev",
        "file://",
    ] {
        let (_, reply) = Raw::greet(&address, "/", &[("Origin", origin)]);
        assert!(reply.starts_with("HTTP/1.1 403 ") && reply.contains("\"origin\""), "{reply}");
        assert!(!reply.contains("demo"), "{reply}");
    }
    let twice = [("Origin", "https://app.foxglove.dev"), ("origin", "http://evil.example")];
    assert!(Raw::greet(&address, "/", &twice).1.starts_with("HTTP/1.1 403 "));
    for headers in [&[][..], &[("Origin", "https://app.foxglove.dev")]] {
        let (_, reply) = Raw::greet(&address, "/", headers);
        assert!(reply.starts_with("HTTP/1.1 101 "), "{reply}");
    }
    let (stopped, _home) = daemon.stop("TERM");
    stopped
        .expect_err("foxglove: refused a client of 127.0.0.1: web pages of `http://evil.example`");
}

#[test]
fn a_name_that_stands_for_this_machine_elsewhere_is_refused() {
    let (_daemon, address) =
        demo("hosts = [\"robot.local\"]\norigins = [\"https://x.example\"]", &[]);
    for host in ["evil.example", "robot.local.evil.example", "x@127.0.0.1", "", "NONE"] {
        let (_, reply) = Raw::greet(&address, "/", &[("Host", host)]);
        assert!(!reply.starts_with("HTTP/1.1 101 "), "{host}: {reply}");
    }
    for host in ["localhost:8765", "127.0.0.1", "[::1]:80", "robot.local"] {
        let (_, reply) = Raw::greet(&address, "/", &[("Host", host)]);
        assert!(reply.starts_with("HTTP/1.1 101 "), "{host}: {reply}");
    }
    let target = format!("http://evil.example{}", "/");
    assert!(!Raw::greet(&address, &target, &[]).1.starts_with("HTTP/1.1 101 "));
    // The configuration says which pages: that of the default is no longer one.
    let (_, reply) = Raw::greet(&address, "/", &[("Origin", "https://app.foxglove.dev")]);
    assert!(reply.starts_with("HTTP/1.1 403 "), "{reply}");
    let (_, reply) = Raw::greet(&address, "/", &[("Origin", "https://x.example")]);
    assert!(reply.starts_with("HTTP/1.1 101 "), "{reply}");
}

#[test]
fn what_is_no_client_of_foxglove_is_told_so() {
    let (_daemon, address) = demo("", &[]);
    for (headers, status) in [
        ([("Sec-WebSocket-Protocol", "NONE")], "400"),
        ([("Sec-WebSocket-Protocol", "foxglove.sdk.v2, chat")], "400"),
        ([("Sec-WebSocket-Key", "NONE")], "400"),
        ([("Sec-WebSocket-Version", "8")], "400"),
        ([("Upgrade", "h2c")], "400"),
        ([("Connection", "close")], "400"),
    ] {
        let (_, reply) = Raw::greet(&address, "/", &headers);
        assert!(reply.starts_with(&format!("HTTP/1.1 {status} ")), "{headers:?}: {reply}");
    }
    assert!(Raw::greet(&address, "/other", &[]).1.starts_with("HTTP/1.1 404 "));
    let several = [("Sec-WebSocket-Protocol", "chat, foxglove.sdk.v1 , foxglove.websocket.v1")];
    let (_, reply) = Raw::greet(&address, "/", &several);
    assert!(reply.to_ascii_lowercase().contains("sec-websocket-protocol: foxglove.sdk.v1\r\n"));
}

const READER: &str = "0123456789abcdef0123456789abcdef";
const DRIVER: &str = "fedcba9876543210fedcba9876543210";

fn write_tokens(home: &Home, all: &[(&str, &str, &str)]) {
    let entry = |(name, token, rights): &(&str, &str, &str)| {
        format!("[[token]]\nname = \"{name}\"\ntoken = \"{token}\"\nrights = {rights}\n")
    };
    let file = home.path().join("tokens.toml");
    fs::write(&file, all.iter().map(entry).collect::<String>()).unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
}

#[test]
fn a_token_in_the_address_gives_its_rights_for_as_long_as_it_is_known() {
    let demo = component("demo");
    let home = Home::new().configured(&source("rights = []"));
    write_tokens(&home, &[("eye", READER, "[\"read\"]"), ("hand", DRIVER, "[\"read\", \"call\"]")]);
    let file = home.path().join("tokens.toml");
    let daemon = home.start(&["--token-file", path(&file), path(&demo.library)]);
    let address = address(&daemon);
    for target in [
        "/".to_owned(),
        "/?token=".to_owned(),
        format!("/?token={}", &READER[1..]),
        format!("/?token={READER}0"),
        format!("/?token={READER}&token={DRIVER}"),
    ] {
        let (_, reply) = Raw::greet(&address, &target, &[]);
        assert!(!reply.starts_with("HTTP/1.1 101 "), "{target}: {reply}");
    }
    let bearer = format!("Bearer {READER}");
    let (_, reply) = Raw::greet(&address, "/", &[("Authorization", &bearer)]);
    assert!(reply.starts_with("HTTP/1.1 101 "), "{reply}");
    let with = |token| format!("{address}/?token={token}");
    let mut eye = Client::new(&daemon, &with(READER));
    let mut hand = Client::new(&daemon, &with(DRIVER));
    assert_eq!(eye.ask("info", &[])["capabilities"], json!(["connectionGraph"]));
    eye.of_name("channel", "/demo/position");
    let speed = "/demo/set_speed/velocity";
    assert_eq!(hand.ask("set", &[json!(speed), json!(2)])[0]["value"], 2.0);
    // The token's rights are changed, then it is removed.
    write_tokens(daemon.home(), &[("eye", READER, "[\"read\"]"), ("hand", DRIVER, "[\"read\"]")]);
    daemon.ctl(&["token", "reload"]).expect_code(0);
    until("the right is gone", || {
        let answer = hand.ask("call", &[json!("/demo/set_speed"), json!({"velocity": 1.0})]);
        answer["failure"].as_str().is_some_and(|told| told.contains("needs the right `call`"))
    });
    write_tokens(daemon.home(), &[("eye", READER, "[\"read\"]")]);
    daemon.ctl(&["token", "reload"]).expect_code(0);
    hand.ask("closed", &[]);
    hand.is_told("its token is not known any more");
    eye.of_name("send", "still there?");
    eye.is_told("none of the protocol");
    let (stopped, _home) = daemon.stop("TERM");
    assert!(!stopped.err.contains(&READER[..16]) && !stopped.err.contains(&DRIVER[..16]));
}

#[test]
fn there_are_so_many_clients_and_one_that_leaves_makes_room() {
    let (daemon, address) = demo("max_clients = 3", &[]);
    let mut all: Vec<_> = (0..3).map(|_| Raw::greet(&address, "/", &[])).collect();
    assert!(all.iter().all(|(_, reply)| reply.starts_with("HTTP/1.1 101 ")), "{all:?}");
    let (_, reply) = Raw::greet(&address, "/", &[]);
    assert!(reply.starts_with("HTTP/1.1 503 "), "{reply}");
    assert!(reply.contains("3 clients are connected already"), "{reply}");
    drop(all.pop());
    until("there is room", || Raw::greet(&address, "/", &[]).1.starts_with("HTTP/1.1 101 "));
    let (stopped, _home) = daemon.stop("TERM");
    stopped.expect_err("foxglove: refused a client of 127.0.0.1: 3 clients are connected already");
}

#[test]
fn others_reach_it_by_tls_and_a_token_only() {
    let home = Home::new();
    let refused = home.refused(&["--foxglove=0.0.0.0:0"]);
    refused.expect_code(2).expect_err("can be reached from outside: Foxglove needs TLS there");
    let refused = home.refused(&["--set", "foxglove.rights=[\"admin\"]"]);
    refused.expect_code(2).expect_err("foxglove.rights = \"admin\": takes a token");
}
