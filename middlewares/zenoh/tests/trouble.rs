//! What keeps sessions from each other is told: endpoints, versions, certificates, access control.

#![allow(
    clippy::panic,
    clippy::unwrap_used,
    reason = "test code that stands outside of test functions"
)]

use std::fs;
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use genom_components::peer::Lines;
use genom_conformance::eventually;
use genom_conformance::samples::{number, numbered, state};
use genom_middleware::{
    Address, Middleware, Obstacle, Policy, PortSpec, Ports, Publisher, Reading,
};
use genom_types::Record;
use genom_zenoh::{Options, Tls, Zenoh};
use rcgen::{CertificateParams, KeyPair, date_time_ymd};

/// Outside the range of ephemeral ports.
const PORT: u16 = 29448;

/// An address on this machine that no other test uses.
fn address() -> String {
    static NEXT: AtomicU8 = AtomicU8::new(1);
    let [_, _, b, c] = std::process::id().to_be_bytes();
    format!("127.{}.{b}.{c}:{PORT}", NEXT.fetch_add(1, Ordering::Relaxed))
}

fn alone() -> Options {
    Options { rendezvous: None, ..Options::default() }
}

fn listener(endpoint: &str) -> Arc<Zenoh> {
    Zenoh::open(&Options { listen: vec![endpoint.to_owned()], ..alone() }).unwrap()
}

fn connected(endpoint: &str) -> Arc<Zenoh> {
    Zenoh::open(&Options { connect: vec![endpoint.to_owned()], ..alone() }).unwrap()
}

/// The only finding.
#[track_caller]
fn only(session: &Zenoh) -> Obstacle {
    let found = session.trouble();
    let [one] = found.as_slice() else { panic!("{found:?}") };
    one.clone()
}

#[test]
fn an_endpoint_where_nobody_listens_is_told_until_somebody_does() {
    let endpoint = format!("tcp/{}", address());
    let desk = connected(&endpoint);
    let told = only(&desk);
    let begins = format!("there is no session with {endpoint}, which is to be connected: ");
    assert!(told.what.starts_with(&begins), "{}", told.what);
    assert!(told.what.contains("Connection refused") && !told.what.contains(".rs:"), "{told:?}");
    assert!(told.fix.starts_with("start the router"), "{}", told.fix);
    let _robot = listener(&endpoint);
    assert_eq!(desk.trouble(), []);
}

#[test]
fn an_endpoint_that_does_not_answer_is_told_after_a_limited_time() {
    let address = address();
    // Connections are made, and nobody speaks.
    let _silent = TcpListener::bind(&address).unwrap();
    let told = only(&connected(&format!("tcp/{address}")));
    assert!(told.what.ends_with("no answer within 3 s"), "{}", told.what);
}

#[test]
fn a_router_of_another_version_of_the_protocol_is_told() {
    let python = genom_components::python::environment(&["eclipse-zenoh==0.11.0"]).unwrap();
    let endpoint = format!("tcp/{}", address());
    let script = "import json, sys, zenoh\n\
                  config = zenoh.Config()\n\
                  config.insert_json5('mode', '\"router\"')\n\
                  config.insert_json5('listen/endpoints', json.dumps([sys.argv[1]]))\n\
                  config.insert_json5('scouting/multicast/enabled', 'false')\n\
                  session = zenoh.open(config)\n\
                  print('up', flush=True)\n\
                  sys.stdin.read()\n";
    let mut router = Command::new(python);
    let router = Lines::start(router.args(["-c", script, &endpoint]));
    router.says("up");
    let told = only(&connected(&endpoint));
    assert!(told.what.contains("in response to an InitSyn"), "{}", told.what);
    assert!(told.fix.contains("another version of zenoh's protocol"), "{}", told.fix);
}

/// Files of a certificate of these years, signed by itself.
fn certificate(place: &Path, host: &str, (from, to): (i32, i32)) -> Tls {
    let mut params = CertificateParams::new(vec![host.to_owned()]).unwrap();
    params.not_before = date_time_ymd(from, 1, 1);
    params.not_after = date_time_ymd(to, 1, 1);
    let key = KeyPair::generate().unwrap();
    let [shown, private] = ["robot.pem", "robot.key"].map(|name| place.join(name));
    fs::write(&shown, params.self_signed(&key).unwrap().pem()).unwrap();
    fs::write(&private, key.serialize_pem()).unwrap();
    fs::set_permissions(&private, fs::Permissions::from_mode(0o600)).unwrap();
    Tls { certificate: Some(shown), key: Some(private), ..Tls::default() }
}

#[test]
fn a_certificate_that_has_expired_is_told_on_both_sides_and_one_that_is_gone_too() {
    let (place, address) = (tempfile::tempdir().unwrap(), address());
    let host = address.split(':').next().unwrap();
    let endpoint = format!("tls/{address}");
    let tls = certificate(place.path(), host, (2000, 2001));
    let shown = tls.certificate.clone().unwrap();
    let robot = Zenoh::open(&Options { listen: vec![endpoint.clone()], tls, ..alone() }).unwrap();
    let told = only(&robot).what;
    assert_eq!(
        told,
        format!(
            "the certificate for TLS, {}, expired at Jan  1 00:00:00 2001 +00:00",
            shown.display()
        )
    );
    let trust = Tls { authority: Some(shown.clone()), ..Tls::default() };
    let desk = Options { connect: vec![endpoint.clone()], tls: trust, ..alone() };
    let found = Zenoh::open(&desk).unwrap().trouble();
    let told: Vec<_> = found.iter().map(|one| one.what.as_str()).collect();
    assert!(told.iter().any(|what| what.contains("the authority for TLS")), "{told:?}");
    let session = format!("there is no session with {endpoint}");
    assert!(told.iter().any(|what| what.starts_with(&session)), "{told:?}");

    fs::remove_file(&shown).unwrap();
    let told = only(&robot).what;
    assert!(told.contains("robot.pem, cannot be read: No such file"), "{told}");
}

/// A configuration of zenoh that a session is opened with.
fn file(place: &Path, text: &str) -> PathBuf {
    let path = place.join("zenoh.json5");
    fs::write(&path, text).unwrap();
    path
}

#[test]
fn a_rule_of_access_control_that_keeps_samples_back_is_named() {
    let (place, address) = (tempfile::tempdir().unwrap(), address());
    let config = file(
        place.path(),
        &format!(
            "{{ mode: 'peer', listen: {{ endpoints: ['tcp/{address}'] }},
               scouting: {{ multicast: {{ enabled: false }} }},
               access_control: {{
                 enabled: true, default_permission: 'allow',
                 rules: [{{ id: 'still', permission: 'deny', messages: ['put', 'reply'],
                            flows: ['egress'], key_exprs: ['demo/secret'] }}],
                 subjects: [{{ id: 'everybody' }}],
                 policies: [{{ rules: ['still'], subjects: ['everybody'] }}] }} }}"
        ),
    );
    let robot = Zenoh::open(&Options { config_file: Some(config), ..alone() }).unwrap();
    let desk = connected(&format!("tcp/{address}"));
    let [open, secret] = ["open", "secret"].map(|name| Address::new("demo", name));
    let ty = state();
    let mut writers = [&secret, &open].map(|at| robot.publisher(&PortSpec::new(at, &ty)).unwrap());
    let told = only(&robot).what;
    assert_eq!(
        told,
        "rule `still` of access_control denies put (egress) of demo/secret, with subjects everybody"
    );
    // So it is.
    let mut readers = [&secret, &open]
        .map(|at| desk.subscription(&PortSpec::new(at, &ty), Policy::Latest).unwrap());
    let mut got = Record::new(&ty);
    let mut arrives = |writer: &mut Box<dyn Publisher>, n: u64| {
        eventually("what is allowed arrives", || {
            writer.publish(&numbered(n)).unwrap();
            readers[1].read(&mut got).unwrap() == Reading::New && number(&got) == n
        });
    };
    // The rule names replies too: a reader asks its writer for the last sample whenever it learns of
    // it, be that before or after something was written.
    arrives(&mut writers[1], 7);
    writers[0].publish(&numbered(8)).unwrap();
    arrives(&mut writers[1], 8);
    assert_eq!(readers[0].read(&mut got).unwrap(), Reading::Never);
}

#[test]
fn a_session_that_can_find_nobody_is_told() {
    let place = tempfile::tempdir().unwrap();
    let text = "{ mode: 'peer', listen: { endpoints: ['tcp/127.0.0.1:0'] },
                  scouting: { multicast: { enabled: false } } }";
    let config = file(place.path(), text);
    let session = Zenoh::open(&Options { config_file: Some(config), ..alone() }).unwrap();
    let told = only(&session).what;
    assert!(told.starts_with("it finds nobody, and nobody finds it"), "{told}");
    // One that meets others in a folder does.
    let folder = tempfile::tempdir().unwrap();
    let rendezvous = Some(folder.path().to_owned());
    let session = Zenoh::open(&Options { rendezvous, ..Options::default() }).unwrap();
    assert_eq!(session.trouble(), []);
}
