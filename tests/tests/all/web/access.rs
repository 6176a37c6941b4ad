//! Other web pages, other names, and people without a session are kept out.

use std::fs;

use genom_tests::{Daemon, Home};

use super::visitor::{Visitor, demo, link};

/// One path of each kind: pages, files, sessions, the live stream, the control plane.
const PATHS: [&str; 11] = [
    "/",
    "/component/demo",
    "/assets/main.js",
    "/session",
    "/live?watch=/components",
    "/api/components",
    "/doctor",
    "/api/doctor",
    "/api/recordings/kept",
    "/api/recordings/kept/own.mcap",
    "/nothing",
];

#[test]
fn a_page_elsewhere_is_refused_on_every_path_whatever_cookie_it_brings() {
    let daemon = demo(Home::new(), &[]);
    let owner = Visitor::with_link(&link(&daemon, &[]));
    let port = owner.address.rsplit(':').next().unwrap().to_owned();
    for origin in [
        "http://evil.example".to_owned(),
        // Cookies do not depend on the port or the scheme: this page sends them, too.
        "http://127.0.0.1:1".to_owned(),
        format!("https://{}", owner.address),
        format!("http://localhost:{port}"),
        "null".to_owned(),
    ] {
        for path in PATHS {
            let reply = owner.on_page(&origin).gets(path);
            assert_eq!((reply.status, reply.code().as_str()), (403, "origin"), "{origin} {path}");
            assert!(!reply.body.contains("\"demo\""), "{reply:?}");
        }
    }
    let own = owner.gets("/api/components");
    assert!(own.status == 200 && own.body.contains("\"demo\""), "{own:?}");
    let (stopped, _home) = daemon.stop("TERM");
    stopped.expect_err("web console: refused GET / of 127.0.0.1: requests from other web pages");
}

#[test]
fn a_name_that_stands_for_this_machine_elsewhere_is_refused_on_every_path() {
    let home = Home::new().configured("[web]\nhosts = [\"robot.local\"]\n");
    let daemon = demo(home, &[]);
    let owner = Visitor::with_link(&link(&daemon, &[]));
    for host in ["evil.example", "evil.example:80", "robot.local.evil.example", "x@127.0.0.1", ""] {
        for path in PATHS {
            // As a page does whose own name was made to stand for 127.0.0.1.
            let reply = owner.under(host).gets(path);
            assert_eq!((reply.status, reply.code().as_str()), (403, "origin"), "{host} {path}");
        }
    }
    for host in ["localhost:8080", "127.0.0.1", "[::1]:80", "robot.local", "Robot.Local:7380"] {
        assert_eq!(owner.under(host).gets("/api/components").status, 200, "{host}");
    }
    // A whole address in the request line counts more than `Host`.
    assert_eq!(owner.gets("http://evil.example/api/components").status, 403);
}

#[test]
fn nothing_is_changed_by_a_request_that_does_not_say_whose_page_it_is_of() {
    let daemon = demo(Home::new(), &[]);
    let owner = Visitor::with_link(&link(&daemon, &[]));
    let speed = || daemon.json(&["call", "demo", "get_speed"])["result"]["velocity"].clone();
    let before = speed();
    let call =
        |of: &Visitor| of.posts("/api/components/demo/services/set_speed", "{\"velocity\":1.25}");
    for origin in ["", "http://evil.example", "null", "http://127.0.0.1:1"] {
        let reply = call(&owner.on_page(origin));
        assert_eq!((reply.status, reply.code().as_str()), (403, "origin"), "{origin}");
        assert_eq!(owner.on_page(origin).sends("DELETE", "/api/activities", "").status, 403);
        assert_eq!(owner.on_page(origin).sends("DELETE", "/session", "").status, 403);
        let kept = "/api/recordings/kept";
        for (method, path) in [
            ("POST", kept.to_owned()),
            ("POST", format!("{kept}/own.mcap/end")),
            ("POST", format!("{kept}/own.mcap/replay")),
            ("DELETE", format!("{kept}/own.mcap/replay")),
            ("DELETE", format!("{kept}/own.mcap")),
        ] {
            let reply = owner.on_page(origin).sends(method, &path, "{}");
            assert_eq!((reply.status, reply.code().as_str()), (403, "origin"), "{method} {path}");
        }
        assert_eq!(owner.gets(kept).json()["recordings"], serde_json::json!([]));
    }
    // What a browser says itself about a page counts as well.
    for site in ["cross-site", "same-site"] {
        let reply = call(&owner.with(&format!("Sec-Fetch-Site: {site}")));
        assert_eq!(reply.status, 403, "{site}");
    }
    assert_eq!(speed(), before);
    assert_eq!(call(&owner).status, 200);
    assert_eq!(speed(), 1.25);
}

#[test]
fn whoever_is_not_signed_in_learns_nothing() {
    let daemon = demo(Home::new(), &[]);
    let stranger = Visitor::stranger(&link(&daemon, &[]));
    let name = format!("genomd-{}", stranger.address.rsplit(':').next().unwrap());
    for of in [
        stranger.clone(),
        stranger.with("Cookie: a=b"),
        stranger.with(&format!("Cookie: {name}=")),
        stranger.with(&format!("Cookie: {name}={}", "0".repeat(64))),
        // Tokens are for signing in, and not for requests.
        stranger.with("Authorization: Bearer 0123456789abcdef0123456789abcdef"),
    ] {
        for path in [
            "/api/",
            "/api/components",
            "/api/doctor",
            "/api/recordings/kept",
            "/api/recordings/kept/own.mcap",
            "/api/nothing",
            "/api/openapi.json",
            "/live",
            "/session",
        ] {
            let reply = of.gets(path);
            assert_eq!((reply.status, reply.code().as_str()), (401, "unauthorized"), "{path}");
            assert!(!reply.body.contains("demo"), "{reply:?}");
        }
    }
    let (stopped, _home) = daemon.stop("TERM");
    stopped.expect_err("of 127.0.0.1: nobody is signed in");
}

#[test]
fn every_reply_forbids_what_no_page_of_the_console_does() {
    let daemon = demo(Home::new(), &[]);
    let owner = Visitor::with_link(&link(&daemon, &[]));
    for path in PATHS {
        let reply = match path.starts_with("/live") {
            true => owner.on_page("http://evil.example").gets(path),
            false => owner.gets(path),
        };
        let policy = reply.header("content-security-policy").expect("a policy");
        for rule in [
            "default-src 'none'",
            "script-src 'self';",
            "frame-ancestors 'none'",
            "require-trusted-types-for 'script'",
        ] {
            assert!(policy.contains(rule), "{path}: {policy}");
        }
        assert!(!policy.contains("unsafe"), "{policy}");
        assert_eq!(reply.header("x-content-type-options"), Some("nosniff"), "{path}");
        assert_eq!(reply.header("referrer-policy"), Some("no-referrer"), "{path}");
        assert_eq!(reply.header("access-control-allow-origin"), None, "{path}");
    }
    // What the console knows of a robot is not kept by a browser; its files are, if they are the same.
    assert_eq!(owner.gets("/api/components").header("cache-control"), Some("no-store"));
    let script = owner.gets("/assets/main.js");
    let known = format!("If-None-Match: {}", script.header("etag").expect("a tag"));
    assert_eq!(owner.with(&known).gets("/assets/main.js").status, 304);
}

#[test]
fn a_request_to_sign_in_is_small_and_of_its_form() {
    let daemon = demo(Home::new(), &[]);
    let stranger = Visitor::stranger(&link(&daemon, &[]));
    let large = format!("{{\"token\":\"{}\"}}", "x".repeat(1_000_000));
    for body in
        ["", "{}", "[]", "{\"link\":3}", "{\"token\":\"a\",\"link\":\"b\"}", "\u{0}", &large]
    {
        assert_eq!(stranger.posts("/session", body).status, 422, "{} bytes", body.len());
    }
    assert_eq!(stranger.shows("guessed").status, 401);
    let (stopped, _home) = daemon.stop("TERM");
    assert!(!stopped.err.contains("guessed"), "{}", stopped.err);
}

#[test]
fn beyond_this_machine_there_is_no_console_without_tls() {
    let refused = Home::new().refused(&["--web=0.0.0.0:0"]);
    refused
        .expect_code(2)
        .expect_err("0.0.0.0:0 can be reached from outside")
        .expect_err("[rpc.tls]");
    let daemon = Daemon::start(&[]);
    let refused = daemon.ctl(&["web"]);
    refused.expect_code(1).expect_err("this daemon has no web console").expect_err("genomd --web");
}

#[test]
fn no_secret_of_a_session_is_in_the_log_or_on_disk() {
    let daemon = demo(Home::new(), &["--log", "trace"]);
    let link = link(&daemon, &[]);
    let owner = Visitor::with_link(&link);
    assert_eq!(owner.gets("/api/components").status, 200);
    let secret = link.split_once('#').unwrap().1.to_owned();
    let cookie = owner.headers.iter().find_map(|one| one.strip_prefix("Cookie: ")).unwrap();
    let cookie = cookie.split_once('=').unwrap().1.to_owned();
    let kept = format!("{}.web", daemon.home().socket().display());
    let kept = fs::read_to_string(kept).unwrap();
    let (stopped, _home) = daemon.stop("TERM");
    for secret in [secret, cookie] {
        assert!(secret.len() == 64 && !stopped.err.contains(&secret) && !kept.contains(&secret));
    }
}
