//! Two sessions that use TLS, with certificates created here.

#![allow(clippy::unwrap_used, reason = "test code that stands outside of test functions")]

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use genom_conformance::eventually;
use genom_conformance::samples::{number, numbered, state};
use genom_middleware::{Address, Policy, PortSpec, Ports, Reading};
use genom_types::Record;
use genom_zenoh::{Mode, Options, SessionError, Tls, Zenoh};
use rcgen::{BasicConstraints, CertificateParams, IsCa, Issuer, KeyPair};
use tempfile::TempDir;

/// Outside the range of ephemeral ports.
const PORT: u16 = 29447;

/// A loopback address that no other test uses: each process has its own.
fn host() -> String {
    static NEXT: AtomicU8 = AtomicU8::new(0);
    let [_, a, b, c] = std::process::id().to_be_bytes();
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    // The two highest bits are free, so that a process has four addresses, more than this file has
    // tests.
    format!("127.{}.{b}.{c}", a ^ (number << 6))
}

/// A certificate authority.
struct Authority {
    place: TempDir,
    issuer: Issuer<'static, KeyPair>,
    certificate: PathBuf,
}

impl Authority {
    fn new() -> Self {
        let place = tempfile::tempdir().unwrap();
        let key = KeyPair::generate().unwrap();
        let mut params = CertificateParams::new(Vec::new()).unwrap();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        let certificate = place.path().join("authority.pem");
        fs::write(&certificate, params.self_signed(&key).unwrap().pem()).unwrap();
        Self { place, issuer: Issuer::new(params, key), certificate }
    }

    /// The certificate of a session at this address.
    fn sign(&self, host: &str) -> Tls {
        let key = KeyPair::generate().unwrap();
        let params = CertificateParams::new(vec![host.to_owned()]).unwrap();
        let certificate = params.signed_by(&key, &self.issuer).unwrap();
        let [shown, private] = ["certificate.pem", "key.pem"].map(|name| {
            let count = fs::read_dir(self.place.path()).unwrap().count();
            self.place.path().join(format!("{count}-{name}"))
        });
        fs::write(&shown, certificate.pem()).unwrap();
        fs::write(&private, key.serialize_pem()).unwrap();
        fs::set_permissions(&private, fs::Permissions::from_mode(0o600)).unwrap();
        Tls { certificate: Some(shown), key: Some(private), ..self.trust() }
    }

    /// What a session needs to trust the certificates of this authority.
    fn trust(&self) -> Tls {
        Tls { authority: Some(self.certificate.clone()), ..Tls::default() }
    }
}

fn alone() -> Options {
    Options { rendezvous: None, ..Options::default() }
}

fn listener(host: &str, tls: Tls) -> Arc<Zenoh> {
    let listen = vec![format!("tls/{host}:{PORT}")];
    Zenoh::open(&Options { listen, tls, ..alone() }).unwrap()
}

/// Opens a client. It has one connection or none, and the result says which.
fn client(host: &str, tls: Tls) -> Result<Arc<Zenoh>, SessionError> {
    let connect = vec![format!("tls/{host}:{PORT}")];
    Zenoh::open(&Options { mode: Mode::Client, connect, tls, ..alone() })
}

fn a_sample_travels(from: &Zenoh, to: &Zenoh) {
    let at = Address::new("demo", "position");
    let mut writer = from.publisher(&PortSpec::new(&at, &state())).unwrap();
    let mut reader = to.subscription(&PortSpec::new(&at, &state()), Policy::Latest).unwrap();
    let mut got = Record::new(&state());
    writer.publish(&numbered(7)).unwrap();
    eventually("the sample arrives", || {
        reader.read(&mut got).unwrap() == Reading::New && number(&got) == 7
    });
}

fn refusal(opened: Result<Arc<Zenoh>, SessionError>) -> String {
    opened.err().unwrap().to_string()
}

#[test]
fn sessions_that_trust_the_authority_talk_over_tls() {
    let (authority, host) = (Authority::new(), host());
    let robot = listener(&host, authority.sign(&host));
    let desk = client(&host, authority.trust()).unwrap();
    a_sample_travels(&robot, &desk);
}

#[test]
fn another_authority_is_refused_and_said() {
    let (authority, host) = (Authority::new(), host());
    let _robot = listener(&host, authority.sign(&host));
    let told = refusal(client(&host, Authority::new().trust()));
    assert!(told.contains(&host) && told.contains("authority"), "{told}");
    // The robot is reachable by a client that trusts the right authority.
    assert!(client(&host, authority.trust()).is_ok());
}

#[test]
fn who_shows_no_certificate_is_refused_where_both_sides_must() {
    let (authority, host) = (Authority::new(), host());
    let mutual = |tls: Tls| Tls { mutual: true, ..tls };
    let robot = listener(&host, mutual(authority.sign(&host)));
    let told = refusal(client(&host, authority.trust()));
    assert!(told.contains(&host) && told.contains("certificate"), "{told}");
    let desk = client(&host, mutual(authority.sign("desk"))).unwrap();
    a_sample_travels(&robot, &desk);
}

#[test]
fn files_that_are_not_there_are_named() {
    let authority = Authority::new();
    let missing = Tls { authority: Some("/no/such/ca.pem".into()), ..Tls::default() };
    let told = refusal(client("127.0.0.1", missing));
    assert!(told.contains("authority") && told.contains("/no/such/ca.pem"), "{told}");
    let half = Tls { certificate: authority.sign("x").certificate, ..Tls::default() };
    let told = refusal(client("127.0.0.1", half));
    assert!(told.contains("`key`"), "{told}");
    let whole = authority.sign("y");
    fs::set_permissions(whole.key.as_ref().unwrap(), fs::Permissions::from_mode(0o644)).unwrap();
    let told = refusal(client("127.0.0.1", whole));
    assert!(told.contains("others may read the key") && told.contains("chmod 600"), "{told}");
}
