//! Who may use the control plane, and for what: sockets, tokens, certificates, contexts.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::path::Path;
use std::process::Command;

use genom_tests::{
    Daemon, Finished, Home, Running, WATCHDOG, component, path, program, repository, request,
};

/// A `genomctl` that finds a daemon only by its arguments and the contexts in this directory.
fn ctl(home: &Path, arguments: &[&str]) -> Finished {
    let mut command = Command::new(program("genomctl"));
    command.env_clear().env("XDG_CONFIG_HOME", home.join("config")).current_dir(home);
    Running::start(command.args(arguments)).finish()
}

/// A home with a token for each right, also in one file each.
fn tokens() -> Home {
    let home = Home::new();
    for right in ["read", "call", "wire", "admin"] {
        for file in ["tokens.toml", right] {
            let made = ctl(home.path(), &["token", right, "--rights", right, "--into", file]);
            made.expect_code(0).expect_out("");
        }
        // The entry that the daemon's file needs for the client's token.
        let entry = std::fs::read_to_string(home.path().join(right)).unwrap();
        let all = home.path().join("tokens.toml");
        let text = std::fs::read_to_string(&all).unwrap();
        let at = text.rfind("[[token]]").unwrap();
        std::fs::write(all, format!("{}{entry}", &text[..at])).unwrap();
    }
    home
}

/// Address of a daemon's TCP listener.
fn address(daemon: &Daemon) -> String {
    let about = request(&daemon.home().socket(), "GET", "/", "").body;
    about["listen"].as_str().expect("it listens").to_owned()
}

fn demo_on_tcp() -> (Daemon, String) {
    let demo = component("demo");
    let arguments = ["--listen", "127.0.0.1:0", "--token-file", "tokens.toml"];
    let daemon = tokens().start(&[&arguments[..], &[path(&demo.library)]].concat());
    let address = address(&daemon);
    (daemon, address)
}

/// Sends one request over TCP and returns the whole reply.
fn raw(address: &str, head: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(WATCHDOG)).unwrap();
    write!(stream, "{head}\r\nHost: {address}\r\nConnection: close\r\n\r\n").unwrap();
    let mut reply = String::new();
    stream.read_to_string(&mut reply).unwrap();
    reply
}

#[test]
fn the_socket_is_for_its_user_alone() {
    let daemon = Daemon::start(&[]);
    let mode = |path: &Path| std::fs::metadata(path).unwrap().mode() & 0o777;
    assert_eq!(mode(&daemon.home().socket()), 0o600);
    assert_eq!(mode(daemon.home().socket().parent().unwrap()), 0o700);
}

#[test]
fn each_right_opens_what_it_names_and_nothing_else() {
    let (daemon, address) = demo_on_tcp();
    let home = daemon.home().path();
    let with = |right: &str, arguments: &[&str]| {
        ctl(home, &[&["--host", &address, "--token-file", right], arguments].concat())
    };
    let asked: [(&str, &[&str]); 5] = [
        ("read", &["list"]),
        ("call", &["call", "demo", "set_speed", "velocity=0.25"]),
        ("call", &["fire", "demo", "emergency"]),
        ("wire", &["backend", "demo", "local"]),
        ("admin", &["unload", "demo"]),
    ];
    for (needed, arguments) in asked {
        for right in ["read", "call", "wire"] {
            if right != needed {
                let refused = with(right, arguments);
                refused.expect_code(1).expect_out("");
                let told = format!("needs the right `{needed}`; token {right} has {right}");
                refused.expect_err(&told).expect_err("token file");
            }
        }
        if needed != "admin" {
            with(needed, arguments).expect_code(0);
            with("admin", arguments).expect_code(0);
        }
    }
    // The services that every component has do not circumvent rights.
    let inputs = r#"{"local":"parameter","remote":"demo/position"}"#;
    for (needed, arguments) in [
        ("admin", &["call", "demo", "kill"][..]),
        ("wire", &["call", "demo", "connect_port", inputs]),
    ] {
        let told = format!("needs the right `{needed}`; token call has call");
        with("call", arguments).expect_code(1).expect_err(&told);
    }
    // Nor does the route with which a daemon tells its cells where ports are needed.
    for (right, status) in [("read", 403), ("call", 403), ("wire", 422), ("admin", 422)] {
        let file = std::fs::read_to_string(home.join(right)).unwrap();
        let token = file.lines().find_map(|line| line.strip_prefix("token = ")).unwrap();
        let head = format!(
            "PUT /components/demo/ends HTTP/1.1\r\nContent-Length: 0\r\nAuthorization: Bearer {}",
            token.trim_matches('"')
        );
        let reply = raw(&address, &head);
        assert!(reply.starts_with(&format!("HTTP/1.1 {status}")), "{right}: {reply}");
    }
    with("admin", &["unload", "demo"]).expect_code(0);
}

#[test]
fn whoever_has_no_token_learns_nothing() {
    let (daemon, address) = demo_on_tcp();
    for head in [
        "GET / HTTP/1.1",
        "GET /components HTTP/1.1",
        "GET /nothing HTTP/1.1",
        "PATCH /components HTTP/1.1",
        "POST /shutdown HTTP/1.1",
        "GET /components HTTP/1.1\r\nAuthorization: Bearer ",
        "GET /components HTTP/1.1\r\nAuthorization: Bearer 0123456789abcdef0123456789abcdef",
        "GET /components HTTP/1.1\r\nAuthorization: Basic cm9ib3Q6cm9ib3Q=",
    ] {
        let reply = raw(&address, head);
        assert!(reply.starts_with("HTTP/1.1 401"), "{head}: {reply}");
        assert!(reply.to_lowercase().contains("www-authenticate: bearer"), "{reply}");
        assert!(!reply.contains("demo"), "{reply}");
    }
    assert!(raw(&address, "GET /docs HTTP/1.1").starts_with("HTTP/1.1 200"));
    let refused = ctl(daemon.home().path(), &["--host", &address, "list"]);
    refused.expect_code(1).expect_err("a token is needed here").expect_err("--token-file");
    // Another web page must not be able to use a token that a browser may have stored.
    let token = std::fs::read_to_string(daemon.home().path().join("read")).unwrap();
    let token = token.lines().find_map(|line| line.strip_prefix("token = ")).unwrap();
    let head = format!("GET / HTTP/1.1\r\nAuthorization: Bearer {}", token.trim_matches('"'));
    assert!(raw(&address, &head).starts_with("HTTP/1.1 200"));
    let foreign = format!("{head}\r\nOrigin: http://evil.example");
    assert!(raw(&address, &foreign).starts_with("HTTP/1.1 403"));
    let own = format!("{head}\r\nOrigin: http://{address}");
    assert!(raw(&address, &own).starts_with("HTTP/1.1 200"));
}

#[test]
fn tokens_are_in_no_log_and_no_message() {
    let demo = component("demo");
    let arguments = ["--log", "trace", "--listen", "127.0.0.1:0", "--token-file", "tokens.toml"];
    let daemon = tokens().start(&[&arguments[..], &[path(&demo.library)]].concat());
    let address = address(&daemon);
    let home = daemon.home().path();
    let text = std::fs::read_to_string(home.join("tokens.toml")).unwrap();
    let secrets: Vec<_> =
        text.lines().filter_map(|line| line.strip_prefix("token = ")).map(str::to_owned).collect();
    assert_eq!(secrets.len(), 4);
    let refused =
        ctl(home, &["--host", &address, "--token-file", "read", "fire", "demo", "emergency"]);
    refused.expect_code(1);
    let (stopped, _home) = daemon.stop("TERM");
    for secret in &secrets {
        let secret = secret.trim_matches('"');
        assert!(!stopped.err.contains(secret) && !refused.err.contains(secret));
    }
}

#[test]
fn contexts_name_daemons() {
    let (daemon, address) = demo_on_tcp();
    let home = daemon.home().path();
    ctl(home, &["list"]).expect_code(3);
    let add = ["context", "add", "robot", "--host", &address, "--token-file", "read"];
    // The context is not used until it is selected.
    ctl(home, &add).expect_code(0).expect_err("`genomctl context use robot` does from now on");
    ctl(home, &["list"]).expect_code(3);
    ctl(home, &["context", "use", "robot"]).expect_code(0);
    let listed = ctl(home, &["list"]);
    assert!(listed.expect_code(0).out.contains("demo"), "{}", listed.out);
    ctl(home, &["context", "add", "other", "--socket", "/nowhere/socket"]).expect_code(0);
    ctl(home, &["context", "use", "other"]).expect_code(0);
    ctl(home, &["list"]).expect_code(3).expect_err("/nowhere/socket");
    ctl(home, &["--context", "robot", "list"]).expect_code(0);
    // The command line takes precedence.
    ctl(home, &["--socket", path(&daemon.home().socket()), "list"]).expect_code(0);
    ctl(home, &["--context", "robot", "--token-file", "admin", "call", "demo", "get_speed"])
        .expect_code(0);
    let listed = ctl(home, &["context", "list"]);
    let shown = format!("CONTEXT  DAEMON\nother*   /nowhere/socket\nrobot    {address}\n");
    listed.expect_code(0).expect_out(&shown);
    ctl(home, &["context", "use", "rbot"]).expect_code(2).expect_err("there is: other, robot");
    ctl(home, &["context", "add", "x"]).expect_code(2).expect_err("nothing says which daemon");
    ctl(home, &["context", "remove", "other"]).expect_code(0);
    ctl(home, &["context", "use"]).expect_code(0);
    let file = std::fs::metadata(home.join("config/genomd/contexts.toml")).unwrap();
    assert_eq!(file.mode() & 0o777, 0o600);
}

/// Writes a root certificate, a daemon's certificate for 127.0.0.1 and a client's to files.
fn certificates(home: &Path) {
    use rcgen::{BasicConstraints, CertificateParams, DnType, IsCa, Issuer, KeyPair};
    let mut root = CertificateParams::new(Vec::<String>::new()).unwrap();
    root.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    let root_key = KeyPair::generate().unwrap();
    let certificate = root.self_signed(&root_key).unwrap();
    std::fs::write(home.join("ca.pem"), certificate.pem()).unwrap();
    let issuer = Issuer::new(root, root_key);
    for (name, of) in [("robot", "127.0.0.1"), ("client", "client")] {
        let key = KeyPair::generate().unwrap();
        let mut params = CertificateParams::new(vec![of.to_owned()]).unwrap();
        // Some programs take a certificate with the name of its root for the root.
        params.distinguished_name.push(DnType::CommonName, name);
        let pem = params.signed_by(&key, &issuer).unwrap().pem();
        std::fs::write(home.join(format!("{name}.key")), key.serialize_pem()).unwrap();
        std::fs::write(home.join(format!("{name}.pem")), &pem).unwrap();
        let both = format!("{pem}{}", key.serialize_pem());
        std::fs::write(home.join(format!("{name}-both.pem")), both).unwrap();
        for secret in [format!("{name}.key"), format!("{name}-both.pem")] {
            let private = std::fs::Permissions::from_mode(0o600);
            std::fs::set_permissions(home.join(secret), private).unwrap();
        }
    }
}

#[test]
fn a_daemon_on_the_network_is_reached_by_tls_and_token() {
    let home = tokens();
    certificates(home.path());
    let home = home.configured("[rpc.tls]\ncert = \"robot.pem\"\nkey = \"robot.key\"\n");
    let daemon = home.start(&["--listen", "0.0.0.0:0", "--token-file", "tokens.toml"]);
    let address = address(&daemon).replace("0.0.0.0", "https://127.0.0.1");
    let home = daemon.home().path();
    let here = ["--host", &address, "--token-file", "read"];
    ctl(home, &[&here[..], &["--ca", "ca.pem", "list"]].concat()).expect_code(0);
    // Neither the daemon nor its client is trusted without a certificate.
    ctl(home, &[&here[..], &["list"]].concat()).expect_code(2).expect_err("--ca FILE");
    let wrong = ctl(home, &[&here[..], &["--ca", "client.pem", "list"]].concat());
    wrong.expect_code(3).expect_err("certificate").expect_err("--ca FILE");
    let refused = ctl(home, &["--host", &address, "--ca", "ca.pem", "list"]);
    refused.expect_code(1).expect_err("a token is needed here");
    // Without encryption there is no reply.
    let mut stream = TcpStream::connect(address.trim_start_matches("https://")).unwrap();
    stream.set_read_timeout(Some(WATCHDOG)).unwrap();
    let _ = stream.write_all(b"GET / HTTP/1.1\r\nHost: x\r\n\r\n");
    let mut reply = Vec::new();
    let _ = stream.read_to_end(&mut reply);
    assert!(!reply.starts_with(b"HTTP"), "{reply:?}");
}

#[test]
fn a_client_certificate_may_stand_for_a_token() {
    let home = Home::new();
    certificates(home.path());
    let home = home.configured(
        "[rpc.tls]\ncert = \"robot.pem\"\nkey = \"robot.key\"\nclient_ca = \"ca.pem\"\n\
         client_rights = [\"read\", \"call\"]\n",
    );
    let daemon = home.start(&["--listen", "127.0.0.1:0"]);
    let address = format!("https://{}", address(&daemon));
    let home = daemon.home().path();
    let here = ["--host", &address, "--ca", "ca.pem"];
    let with = [&here[..], &["--cert", "client-both.pem"]].concat();
    ctl(home, &[&with[..], &["list"]].concat()).expect_code(0);
    let refused = ctl(home, &[&with[..], &["kill"]].concat());
    refused.expect_code(1).expect_err("needs the right `admin`");
    // TLS 1.3 reports it with the first reply: as unreachable or lost, depending on timing.
    ctl(home, &[&here[..], &["list"]].concat()).expect_code(3);
}

#[test]
fn certificates_that_cannot_be_used_are_named() {
    let home = tokens();
    let arguments = ["--listen", "127.0.0.1:0", "--token-file", "tokens.toml"];
    let home = home.configured("[rpc.tls]\ncert = \"robot.pem\"\nkey = \"robot.key\"\n");
    home.refused(&arguments).expect_code(2).expect_err("robot.pem: no usable certificate in PEM");
    certificates(home.path());
    std::fs::copy(home.path().join("client.key"), home.path().join("robot.key")).unwrap();
    home.refused(&arguments).expect_code(2).expect_err("certificate and key of rpc.tls");
}

/// Runs tests of the Python client against a daemon, with the files in its home.
#[track_caller]
fn python_comes_in(daemon: &Daemon, tests: &str) {
    let (package, home) = (repository().join("clients/python"), daemon.home().path());
    let mut command = Command::new(std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into()));
    command
        .current_dir(home)
        .env_clear()
        .env("PYTHONPATH", std::env::join_paths([package.join("src"), package]).unwrap())
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("XDG_CONFIG_HOME", home.join("config"))
        .env("GENOM_HOST", format!("https://{}", address(daemon)))
        .args(["-S", "-W", "error", "-m", "unittest", "--verbose", tests]);
    let finished = Running::start(&mut command).finish();
    finished.expect_code(0);
    assert!(!finished.err.contains("Ran 0 tests"), "{}", finished.err);
}

#[test]
fn python_reaches_a_daemon_by_tls_and_token_and_by_contexts() {
    let home = tokens();
    certificates(home.path());
    let home = home.configured("[rpc.tls]\ncert = \"robot.pem\"\nkey = \"robot.key\"\n");
    let demo = component("demo");
    let arguments = ["--listen", "127.0.0.1:0", "--token-file", "tokens.toml"];
    let daemon = home.start(&[&arguments[..], &[path(&demo.library)]].concat());
    let host = format!("https://{}", address(&daemon));
    let add =
        ["context", "add", "robot", "--host", &host, "--ca", "ca.pem", "--token-file", "read"];
    ctl(daemon.home().path(), &add).expect_code(0);
    let other = ["context", "add", "it's \"spare\"", "--socket", "/nowhere/socket"];
    ctl(daemon.home().path(), &other).expect_code(0);
    ctl(daemon.home().path(), &["context", "use", "robot"]).expect_code(0);
    python_comes_in(&daemon, "tests.test_access.Tokens");
}

#[test]
fn python_comes_in_with_a_certificate() {
    let home = Home::new();
    certificates(home.path());
    let home = home.configured(
        "[rpc.tls]\ncert = \"robot.pem\"\nkey = \"robot.key\"\nclient_ca = \"ca.pem\"\n\
         client_rights = [\"read\", \"call\"]\n",
    );
    let demo = component("demo");
    let daemon = home.start(&["--listen", "127.0.0.1:0", path(&demo.library)]);
    python_comes_in(&daemon, "tests.test_access.Certificates");
}
