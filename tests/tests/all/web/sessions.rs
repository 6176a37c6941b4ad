//! Links, sessions, and what they may do.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;

use genom_tests::{Home, until_answer};

use super::visitor::{Visitor, demo, link};

/// A file with a token named `panel`.
fn panel(home: &Home, token: &str, rights: &str) {
    let file = home.path().join("tokens.toml");
    let entry =
        format!("[[token]]\nname = \"panel\"\ntoken = \"{token:-<32}\"\nrights = {rights}\n");
    fs::write(&file, entry).unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
}

#[test]
fn a_link_opens_one_session_and_its_cookie_is_for_this_console_alone() {
    let daemon = demo(Home::new(), &[]);
    let link = link(&daemon, &[]);
    let stranger = Visitor::stranger(&link);
    let opened = stranger.opens(&link);
    assert_eq!(opened.status, 200, "{opened:?}");
    let port = stranger.address.rsplit(':').next().unwrap();
    let cookie = opened.header("set-cookie").unwrap();
    assert!(cookie.starts_with(&format!("genomd-{port}=")), "{cookie}");
    for rule in ["HttpOnly", "SameSite=Strict", "Path=/", "Max-Age=43200"] {
        assert!(cookie.split("; ").any(|one| one == rule), "{cookie}");
    }
    assert_eq!(opened.json()["rights"], serde_json::json!(["admin"]));
    // Whoever sees the link later, in a history or over a shoulder, is too late.
    let again = stranger.opens(&link);
    assert_eq!((again.status, again.code().as_str()), (401, "link_over"));
    assert_eq!(again.header("set-cookie"), None);
    let (stopped, _home) = daemon.stop("TERM");
    stopped.expect_err("refused POST /session of 127.0.0.1: a link that was used already");
    stopped.expect_err("web session 1 of the daemon's user began");
}

#[test]
fn a_link_that_nobody_opened_in_time_is_void() {
    let daemon = demo(Home::new().configured("[web]\nlink_time = 0.000001\n"), &[]);
    let link = link(&daemon, &[]);
    let late = Visitor::stranger(&link).opens(&link);
    assert_eq!((late.status, late.code().as_str()), (401, "link_over"));
}

#[test]
fn a_session_ends_by_signing_out_and_by_newer_ones_of_the_same_user() {
    let daemon = demo(Home::new().configured("[web]\nmax_sessions = 2\n"), &[]);
    let open = || Visitor::with_link(&link(&daemon, &[]));
    let status = |of: &Visitor| of.gets("/api/components").status;
    let (first, second) = (open(), open());
    assert_eq!((status(&first), status(&second)), (200, 200));
    let third = open();
    assert_eq!((status(&first), status(&second), status(&third)), (401, 200, 200));
    let out = third.sends("DELETE", "/session", "");
    assert_eq!(out.status, 204);
    assert!(out.header("set-cookie").unwrap().contains("Max-Age=0"), "{out:?}");
    assert_eq!((status(&second), status(&third)), (200, 401));
    let (stopped, _home) = daemon.stop("TERM");
    stopped.expect_err("web session 1 of the daemon's user ended: there are 2 newer ones");
}

#[test]
fn a_session_has_the_rights_of_its_link_and_gives_no_others() {
    let daemon = demo(Home::new(), &[]);
    let reader = Visitor::with_link(&link(&daemon, &["--rights", "read"]));
    assert_eq!(reader.gets("/api/components/demo").status, 200);
    for (method, path, body) in [
        ("POST", "/api/components/demo/services/set_speed", "{\"velocity\":1}"),
        ("DELETE", "/api/activities", ""),
        ("POST", "/api/connections", "{\"in\":\"demo/parameter\",\"out\":\"demo/position\"}"),
        ("DELETE", "/api/components/demo", ""),
        ("POST", "/api/shutdown", ""),
    ] {
        let reply = reader.sends(method, path, body);
        assert_eq!(
            (reply.status, reply.code().as_str()),
            (403, "right_missing"),
            "{method} {path}"
        );
        assert!(reply.body.contains("web session 1 of the daemon's user has read"), "{reply:?}");
    }
    let more = reader.posts("/api/web/links", "{\"rights\":[\"read\",\"call\"]}");
    assert_eq!((more.status, more.code().as_str()), (403, "right_missing"));
    let same = reader.posts("/api/web/links", "");
    assert_eq!(same.status, 200, "{same:?}");
    let other = Visitor::with_link(same.json()["url"].as_str().unwrap());
    assert_eq!(other.posts("/api/shutdown", "").status, 403);
    // Changes are logged with the session that made them.
    let caller = Visitor::with_link(&link(&daemon, &["--rights", "read,call"]));
    let set = caller.posts("/api/components/demo/services/set_speed", "{\"velocity\":1}");
    assert_eq!(set.status, 200, "{set:?}");
    let (stopped, _home) = daemon.stop("TERM");
    stopped
        .expect_err("web session 3 of the daemon's user: POST /components/demo/services/set_speed");
}

#[test]
fn a_token_signs_in_with_its_rights_as_long_as_it_is_in_the_file() {
    let home = Home::new();
    panel(&home, "first", "[\"read\", \"call\"]");
    let daemon = demo(home, &["--token-file", "tokens.toml"]);
    let stranger = Visitor::stranger(&link(&daemon, &[]));
    assert_eq!(stranger.shows("another------------------------------").status, 401);
    let opened = stranger.shows(&format!("{:-<32}", "first"));
    assert_eq!(opened.json()["rights"], serde_json::json!(["read", "call"]), "{opened:?}");
    let visitor = stranger.with(&format!("Cookie: {}", opened.cookie()));
    let call = || visitor.posts("/api/components/demo/services/get_speed", "").status;
    let status = || visitor.gets("/api/components").status;
    assert_eq!((call(), status()), (200, 200));
    panel(daemon.home(), "first", "[\"read\"]");
    assert_eq!(daemon.json(&["token", "reload"])["tokens"], 1);
    assert_eq!((call(), status()), (403, 200));
    panel(daemon.home(), "second", "[\"read\", \"call\"]");
    assert_eq!(daemon.json(&["token", "reload"])["tokens"], 1);
    assert_eq!((call(), status()), (401, 401), "it is another token, of the same name");
}

#[test]
fn a_session_and_its_address_outlive_the_daemon() {
    let daemon = demo(Home::new(), &[]);
    let owner = Visitor::with_link(&link(&daemon, &[]));
    let kept = format!("{}.web", daemon.home().socket().display());
    let mode = fs::metadata(Path::new(&kept)).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600);
    let daemon = demo(daemon.abandon(), &[]);
    until_answer(&200, || owner.gets("/api/components").status);
    assert_eq!(Visitor::stranger(&link(&daemon, &[])).address, owner.address);
}
