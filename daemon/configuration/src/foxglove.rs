//! The live source for Foxglove: where it listens, and what its clients may do and take.

use std::net::SocketAddr;

use genom_protocol::Right;
use serde::{Deserialize, Serialize};

use crate::error::UsageError;
use crate::rpc::Rpc;

/// Section `[foxglove]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct FoxgloveSection {
    /// Address of the source; none without one.
    pub listen: Option<SocketAddr>,
    /// Rights of clients without a token, if the address is of loopback. `wire` and `admin` take a
    /// token.
    pub rights: Vec<Right>,
    /// Names by which clients may reach it, besides IP addresses and `localhost`.
    pub hosts: Vec<String>,
    /// Origins of web pages that may connect: `https://HOST`.
    pub origins: Vec<String>,
    /// Clients at once.
    pub max_clients: usize,
    /// Bytes of samples that may wait for one client; the oldest ones make room.
    pub backlog: usize,
}

impl Default for FoxgloveSection {
    fn default() -> Self {
        Self {
            listen: None,
            rights: vec![Right::Read],
            hosts: Vec::new(),
            origins: vec!["https://app.foxglove.dev".to_owned()],
            max_clients: 8,
            backlog: 16 << 20,
        }
    }
}

/// Bounds of `max_clients` and of `backlog`.
const CLIENTS: usize = 64;
const BACKLOG: (usize, usize) = (64 << 10, 1 << 30);

impl FoxgloveSection {
    /// Checks the section, to which the command line was already applied.
    ///
    /// # Errors
    /// Other machines could reach the source without TLS, or a value is out of its range.
    pub fn check(&self, rpc: &Rpc) -> Result<(), UsageError> {
        if let Some(address) = self.listen
            && !address.ip().is_loopback()
            && (rpc.tls.is_none() || rpc.token_file.is_none())
        {
            return Err(UsageError::FoxgloveNoTls(address));
        }
        let wrong = |key, value: String, what: &str| {
            Err(UsageError::Foxglove { key, value, what: what.to_owned() })
        };
        if let Some(right) = self.rights.iter().find(|right| **right > Right::Call) {
            return wrong(
                "rights",
                format!("\"{right}\""),
                "takes a token: `read` and `call` do not",
            );
        }
        if !(1..=CLIENTS).contains(&self.max_clients) {
            return wrong("max_clients", self.max_clients.to_string(), "1 to 64");
        }
        if !(BACKLOG.0..=BACKLOG.1).contains(&self.backlog) {
            return wrong("backlog", self.backlog.to_string(), "65536 to 1073741824 bytes");
        }
        let quoted = |text: &String| format!("\"{}\"", text.escape_default());
        let plain = |c: char| c.is_ascii_alphanumeric() || ".-".contains(c);
        if let Some(host) =
            self.hosts.iter().find(|host| host.is_empty() || !host.chars().all(plain))
        {
            return wrong("hosts", quoted(host), "a name without port, such as robot.local");
        }
        let whole = |origin: &&String| {
            let name = origin.split_once("://").map(|(_, name)| name);
            name.is_none_or(|name| name.contains('/'))
        };
        match self.origins.iter().find(whole) {
            Some(origin) => wrong("origins", quoted(origin), "SCHEME://HOST, without a path"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(section: FoxgloveSection) -> Result<(), String> {
        section.check(&Rpc::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn others_reach_the_source_by_tls_and_a_token_only() {
        let at = |address: &str| FoxgloveSection {
            listen: address.parse().ok(),
            ..FoxgloveSection::default()
        };
        assert_eq!(checked(at("127.0.0.1:8765")), Ok(()));
        assert_eq!(checked(at("[::1]:0")), Ok(()));
        let refused = checked(at("0.0.0.0:8765")).unwrap_err();
        assert!(refused.contains("0.0.0.0:8765 can be reached from outside"), "{refused}");
    }

    #[test]
    fn a_value_out_of_its_range_is_named() {
        let usual = FoxgloveSection::default;
        for (section, told) in [
            (
                FoxgloveSection { rights: vec![Right::Admin], ..usual() },
                "foxglove.rights = \"admin\"",
            ),
            (
                FoxgloveSection { rights: vec![Right::Wire], ..usual() },
                "foxglove.rights = \"wire\"",
            ),
            (FoxgloveSection { max_clients: 0, ..usual() }, "foxglove.max_clients = 0: 1 to 64"),
            (FoxgloveSection { backlog: 1, ..usual() }, "foxglove.backlog = 1: 65536 to"),
            (FoxgloveSection { hosts: vec!["a:1".into()], ..usual() }, "foxglove.hosts = \"a:1\""),
            (
                FoxgloveSection { origins: vec!["app.foxglove.dev".into()], ..usual() },
                "foxglove.origins = \"app.foxglove.dev\": SCHEME://HOST",
            ),
            (
                FoxgloveSection { origins: vec!["https://a/".into()], ..usual() },
                "foxglove.origins = \"https://a/\"",
            ),
        ] {
            let refused = checked(section).unwrap_err();
            assert!(refused.starts_with(told), "{refused}");
        }
        let both = vec![Right::Read, Right::Call];
        assert_eq!(checked(FoxgloveSection { rights: both, ..usual() }), Ok(()));
    }
}
