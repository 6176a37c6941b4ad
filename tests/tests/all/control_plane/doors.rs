//! Attacks on the listeners of a daemon: wrong, revoked or overused tokens, silent connections,
//! secrets that others can read.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;

use genom_protocol::{Right, routes};
use genom_tests::{Daemon, Home, WATCHDOG, component, path, request, until};

/// Names of tokens, and their rights as they stand in the file.
const TOKENS: [(&str, &str); 6] = [
    ("reader", "read"),
    ("caller", "call"),
    ("wirer", "wire"),
    ("driver", "read\", \"call"),
    ("fitter", "call\", \"wire"),
    ("boss", "admin"),
];

fn secret(name: &str) -> String {
    format!("{name}-0123456789abcdef0123456789abcdef")
}

fn entry(name: &str, rights: &str) -> String {
    let token = secret(name);
    format!("[[token]]\nname = \"{name}\"\ntoken = \"{token}\"\nrights = [\"{rights}\"]\n")
}

fn private(path: &Path, text: &str) {
    std::fs::write(path, text).unwrap();
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o600)).unwrap();
}

/// A daemon with the demo on TCP, with these settings of `[rpc]`; and its address.
fn listening(settings: &str) -> (Daemon, String) {
    let home = Home::new().configured(&format!("[rpc]\n{settings}\n"));
    let all: String = TOKENS.iter().map(|(name, rights)| entry(name, rights)).collect();
    private(&home.path().join("tokens.toml"), &all);
    let demo = component("demo");
    let arguments = ["--listen", "127.0.0.1:0", "--token-file", "tokens.toml", path(&demo.library)];
    let daemon = home.start(&arguments);
    let about = request(&daemon.home().socket(), "GET", "/", "").body;
    let address = about["listen"].as_str().unwrap().to_owned();
    (daemon, address)
}

fn connected(address: &str) -> TcpStream {
    let stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(WATCHDOG)).unwrap();
    stream
}

/// A connection on which a request was sent, and the status of the reply.
fn asked(address: &str, line: &str, authorization: &str) -> (TcpStream, u16) {
    let mut stream = connected(address);
    write!(stream, "{line} HTTP/1.1\r\nHost: x\r\nAuthorization: {authorization}\r\n").unwrap();
    write!(stream, "Content-Length: 0\r\n\r\n").unwrap();
    let mut head = [0; 12];
    stream.read_exact(&mut head).unwrap();
    let status = String::from_utf8_lossy(&head[9..]).parse().unwrap();
    (stream, status)
}

fn status(address: &str, line: &str, name: &str) -> u16 {
    asked(address, line, &format!("Bearer {}", secret(name))).1
}

#[test]
fn the_log_tells_who_was_refused_and_who_changed_what_but_no_token() {
    let (daemon, address) = listening("");
    for _ in 0..500 {
        assert_eq!(status(&address, "GET /components", "nobody"), 401);
    }
    assert_eq!(status(&address, "POST /components/demo/services/reset", "reader"), 403);
    assert_eq!(status(&address, "POST /components/demo/services/reset", "driver"), 200);
    let (stopped, _) = daemon.stop("TERM");
    let lines = |what: &str| stopped.err.lines().filter(|line| line.contains(what)).count();
    let unknown = "refused GET /components of 127.0.0.1: this token is not known here";
    assert!((1..50).contains(&lines(unknown)), "{}", stopped.err);
    assert_eq!(lines("needs the right `call`; token reader has read"), 1, "{}", stopped.err);
    let change = "INFO token driver: POST /components/demo/services/reset";
    assert_eq!(lines(change), 1, "{}", stopped.err);
    for name in ["nobody", "reader", "driver", "boss"] {
        assert!(!stopped.err.contains(&secret(name)));
    }
}

#[test]
fn each_token_opens_the_routes_and_services_of_its_rights_and_no_others() {
    let (daemon, address) = listening("");
    let check = |line: &str, needed: &[Right]| {
        for (name, rights) in TOKENS {
            let may = |right: &Right| rights.contains(&right.to_string()) || rights == "admin";
            // The daemon does not end before it is asked for all; nor does the component.
            if name == "boss" && (line == "POST /shutdown" || line.ends_with("/kill")) {
                continue;
            }
            let refused = status(&address, line, name) == 403;
            assert_eq!(refused, !needed.iter().all(may), "{line} by {name}, {rights}");
        }
        let nobody = status(&address, line, "nobody") == 401;
        assert_eq!(nobody, !needed.is_empty(), "{line} by nobody");
    };
    // A cell takes whatever comes through its daemon, which checks the rights for it.
    let library = component("demo").library;
    daemon.ctl(&["load", path(&library), "--name", "far", "--isolated"]).expect_code(0);
    let described = request(&daemon.home().socket(), "GET", "/components/demo", "").body;
    let has = |name: &str| {
        described["services"].as_array().unwrap().iter().any(|service| service["name"] == name)
    };
    let mut services = 0;
    for route in routes::all() {
        for service in route.services.iter().filter(|name| has(name)) {
            // Calling is a right of its own.
            for component in ["demo", "far"] {
                let line = format!("POST /components/{component}/services/{service}");
                check(&line, &[Right::Call, route.right.unwrap()]);
            }
            services += 1;
        }
        let names = route.template.split('/').map(|one| one.trim_start_matches('{'));
        let path: Vec<_> = names.map(|one| if one.ends_with('}') { "none" } else { one }).collect();
        let line = format!("{} {}", route.method.as_str(), path.join("/"));
        check(&line, route.right.as_slice());
    }
    assert_eq!(services, 4, "abort_activity, connect_port, connect_service, kill");
}

#[test]
fn bearer_is_written_in_any_case() {
    let (_daemon, address) = listening("");
    for scheme in ["Bearer", "bearer", "BEARER", "bEaReR "] {
        let (_, status) = asked(&address, "GET /", &format!("{scheme} {}", secret("reader")));
        assert_eq!(status, 200, "{scheme}");
    }
    for wrong in ["Basic", "Bearer:", "Bearers", ""] {
        let (_, status) = asked(&address, "GET /", &format!("{wrong} {}", secret("reader")));
        assert_eq!(status, 401, "{wrong}");
    }
}

#[test]
fn the_token_file_is_read_again_and_a_mistake_in_it_changes_nothing() {
    let (daemon, address) = listening("");
    let file = daemon.home().path().join("tokens.toml");
    let known = |name: &str| status(&address, "GET /", name) == 200;
    assert!(known("reader") && !known("guest"));
    private(&file, &entry("guest", "read"));
    assert!(known("reader") && !known("guest"), "not before it is asked for");
    daemon.ctl(&["token", "reload"]).expect_code(0).expect_out("1 tokens known\n");
    assert!(!known("reader") && known("guest"));
    private(&file, &(entry("guest", "read") + "[[token]]\nname = 3\n"));
    let refused = daemon.ctl(&["token", "reload"]);
    refused.expect_code(1).expect_err("tokens.toml:6:").expect_err("those of before");
    assert!(known("guest"));
    std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o644)).unwrap();
    daemon.ctl(&["token", "reload"]).expect_code(1).expect_err("chmod 600");
    private(&file, &entry("other", "read"));
    daemon.process().signal("HUP");
    until("it is read again", || known("other"));
    assert!(!known("guest"));
    private(&file, "[[token]]\n");
    daemon.process().signal("HUP");
    let told = daemon.process().error_line_where(|line| line.contains("those of before"));
    assert!(told.unwrap().contains("tokens.toml"));
    assert!(known("other"));
    // The right to read is not enough for that.
    assert_eq!(status(&address, "POST /tokens/reload", "other"), 403);
    let none = Daemon::start(&[]);
    none.ctl(&["token", "reload"]).expect_code(1).expect_err("no token file");
}

#[test]
fn a_greedy_token_leaves_streams_to_other_tokens_and_all_of_his_to_the_owner() {
    let (daemon, address) = listening("max_streams = 6\nmax_streams_per_token = 4");
    let open = |name: &str| asked(&address, "GET /events", &format!("Bearer {}", secret(name)));
    let mut held: Vec<_> = (0..4).map(|_| open("reader")).collect();
    assert!(held.iter().all(|(_, status)| *status == 200));
    for _ in 0..20 {
        assert_eq!(open("reader").1, 503);
    }
    held.extend([open("driver"), open("driver")]);
    assert!(held.iter().all(|(_, status)| *status == 200));
    assert_eq!(open("driver").1, 503, "of all tokens together");
    let _own: Vec<_> = (0..6).map(|_| daemon.events()).collect();
    let refused = request(&daemon.home().socket(), "GET", "/events", "");
    assert_eq!((refused.status, refused.code()), (503, "too_many_streams"));
}

#[test]
fn a_greedy_token_leaves_requests_to_others() {
    let (_daemon, address) = listening("max_connections = 8\nmax_connections_per_token = 3");
    let open = |name: &str| asked(&address, "GET /events", &format!("Bearer {}", secret(name)));
    let _held: Vec<_> = (0..3).map(|_| open("reader")).collect();
    for _ in 0..20 {
        assert_eq!(open("reader").1, 503);
    }
    assert_eq!(status(&address, "GET /", "driver"), 200);
}

/// Whether the daemon has not closed the connection.
fn is_open(stream: &TcpStream) -> bool {
    stream.set_nonblocking(true).unwrap();
    let mut stream = stream;
    let got = stream.read(&mut [0; 4096]);
    matches!(got, Err(error) if error.kind() == std::io::ErrorKind::WouldBlock)
}

#[test]
fn connections_that_say_nothing_or_half_of_something_are_no_obstacle() {
    let (daemon, address) = listening("max_connections = 8");
    let (known, told) = asked(&address, "GET /events", &format!("Bearer {}", secret("driver")));
    assert_eq!(told, 200);
    let half = |text: &str| {
        let mut stream = connected(&address);
        stream.write_all(text.as_bytes()).unwrap();
        stream
    };
    // Many more than are allowed.
    let all: Vec<_> = (0..24)
        .map(|number| match number % 3 {
            0 => half(""),
            1 => half("GET / HT"),
            _ => half("POST /components HTTP/1.1\r\nHost: x\r\nContent-Length: 9\r\n"),
        })
        .collect();
    // They need not time out: the oldest are closed, and the newest stay open.
    assert_eq!(status(&address, "GET /", "reader"), 200);
    assert!(!is_open(&all[0]) && is_open(all.last().unwrap()));
    // Connections with a valid token are not closed.
    daemon.ctl(&["call", "demo", "reset"]).expect_code(0);
    let mut told = [0; 16];
    (&known).read_exact(&mut told).unwrap();
}

#[test]
fn keys_that_others_may_read_are_refused() {
    let home = Home::new().configured("[rpc.tls]\ncert = \"robot.pem\"\nkey = \"robot.key\"\n");
    let made = rcgen::generate_simple_self_signed(vec!["127.0.0.1".to_owned()]).unwrap();
    let file = |name: &str| home.path().join(name);
    std::fs::write(file("robot.pem"), made.cert.pem()).unwrap();
    std::fs::write(file("robot.key"), made.signing_key.serialize_pem()).unwrap();
    private(&file("tokens.toml"), &entry("reader", "read"));
    let arguments = ["--listen", "127.0.0.1:0", "--token-file", "tokens.toml"];
    for mode in [0o644, 0o640, 0o604] {
        let open = std::fs::Permissions::from_mode(mode);
        std::fs::set_permissions(file("robot.key"), open).unwrap();
        let refused = home.refused(&arguments);
        refused.expect_code(2).expect_err("others may read").expect_err("robot.key");
        refused.expect_err("chmod 600");
    }
    private(&file("robot.key"), &made.signing_key.serialize_pem());
    let daemon = home.start(&arguments);
    let file = |name: &str| daemon.home().path().join(name);
    // The same applies to a client's key.
    let both = format!("{}{}", made.cert.pem(), made.signing_key.serialize_pem());
    std::fs::write(file("both.pem"), both).unwrap();
    let (ca, cert) = (file("robot.pem"), file("both.pem"));
    let about = request(&daemon.home().socket(), "GET", "/", "").body;
    let host = format!("https://{}", about["listen"].as_str().unwrap());
    let arguments = ["--host", &host, "--ca", path(&ca), "--cert", path(&cert), "list"];
    let refused = daemon.ctl(&arguments);
    refused.expect_code(2).expect_err("others may read it").expect_err("both.pem");
}
