//! Files for TLS that cannot be used, now.

use std::collections::BTreeMap;

use genom_middleware::Obstacle;
use x509_parser::pem::Pem;
use x509_parser::time::ASN1Time;
use zenoh::Config;

use crate::settings::text;

/// Settings with the path of certificates.
const CERTIFICATES: [(&str, &str); 3] = [
    ("root_ca_certificate", "authority"),
    ("listen_certificate", "certificate"),
    ("connect_certificate", "certificate"),
];

/// Settings with the path of a key.
const KEYS: [&str; 2] = ["listen_private_key", "connect_private_key"];

/// Certificates and keys that cannot be read, or are of another time.
pub(crate) fn unusable(config: &Config) -> Vec<Obstacle> {
    let path = |name: &str| text(config, &format!("transport/link/tls/{name}"));
    // One file may be in several settings.
    let mut all = BTreeMap::new();
    for (name, what) in CERTIFICATES {
        all.extend(path(name).map(|path| (path, Some(what))));
    }
    for name in KEYS {
        all.extend(path(name).map(|path| (path, None)));
    }
    all.iter().filter_map(|(path, what)| problem(path, *what)).collect()
}

/// What is wrong with a file: of certificates if `what` says which, or of a key.
fn problem(path: &str, what: Option<&str>) -> Option<Obstacle> {
    let name = what.unwrap_or("key");
    let obstacle = |why: &str, fix: String| {
        Some(Obstacle { what: format!("the {name} for TLS, {path}, {why}"), fix })
    };
    let text = match std::fs::read(path) {
        Ok(text) => text,
        Err(error) => {
            let fix = format!("put it there, readable by the user of this daemon: {path}");
            return obstacle(&format!("cannot be read: {error}"), fix);
        }
    };
    what?;
    let mut some = false;
    for pem in Pem::iter_from_buffer(&text).flatten() {
        let Ok(certificate) = pem.parse_x509() else { continue };
        some = true;
        let validity = certificate.validity();
        if validity.is_valid() {
            continue;
        }
        let renew = "have it issued anew".to_owned();
        if validity.not_after < ASN1Time::now() {
            return obstacle(&format!("expired at {}", validity.not_after), renew);
        }
        let fix = "set the clock of this machine right, or have it issued anew".to_owned();
        return obstacle(&format!("is valid from {} only", validity.not_before), fix);
    }
    if some {
        return None;
    }
    obstacle("has no certificate in it", "a file in PEM: BEGIN CERTIFICATE".to_owned())
}

#[cfg(test)]
mod tests {
    use rcgen::{CertificateParams, KeyPair, date_time_ymd};

    use super::*;

    /// A configuration with a certificate of these years.
    fn with(years: Option<(i32, i32)>) -> (tempfile::TempDir, Config) {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("robot.pem");
        if let Some((from, to)) = years {
            let mut params = CertificateParams::new(vec!["robot".to_owned()]).unwrap();
            params.not_before = date_time_ymd(from, 1, 1);
            params.not_after = date_time_ymd(to, 1, 1);
            let key = KeyPair::generate().unwrap();
            std::fs::write(&path, params.self_signed(&key).unwrap().pem()).unwrap();
        }
        let mut config = Config::default();
        let json = serde_json::json!(path).to_string();
        config.insert_json5("transport/link/tls/listen_certificate", &json).unwrap();
        (place, config)
    }

    #[test]
    fn certificates_of_another_time_and_files_that_are_not_there_are_told() {
        let told = |years| {
            let (_place, config) = with(years);
            unusable(&config).into_iter().map(|one| one.what).collect::<Vec<_>>()
        };
        assert_eq!(told(Some((2000, 4000))), [""; 0]);
        assert!(told(Some((2000, 2001)))[0].contains("robot.pem, expired at Jan  1 00:00:00 2001"));
        assert!(told(Some((3000, 4000)))[0].contains("is valid from Jan  1 00:00:00 3000"));
        assert!(told(None)[0].contains("robot.pem, cannot be read: No such file"));
        let (place, config) = with(None);
        std::fs::write(place.path().join("robot.pem"), "hello").unwrap();
        assert!(unusable(&config)[0].what.ends_with("has no certificate in it"));
    }
}
