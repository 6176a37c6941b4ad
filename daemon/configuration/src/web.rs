//! The web console: where it listens, and who may stay for how long.

use std::net::SocketAddr;

use serde::{Deserialize, Serialize};

use crate::error::UsageError;
use crate::rpc::Rpc;

/// Section `[web]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct WebSection {
    /// Address of the console; none without one. Port 0: any that is free, again the same one if
    /// that is possible.
    pub listen: Option<SocketAddr>,
    /// Names by which browsers may reach it, besides IP addresses and `localhost`.
    pub hosts: Vec<String>,
    /// Sessions of one user or token; with one more, the one that was not used for longest ends.
    pub max_sessions: usize,
    /// Seconds after which a session ends.
    pub session_time: f64,
    /// Seconds within which a link of `genomctl web` has to be opened.
    pub link_time: f64,
}

impl Default for WebSection {
    fn default() -> Self {
        Self {
            listen: None,
            hosts: Vec::new(),
            max_sessions: 16,
            session_time: 43_200.0,
            link_time: 60.0,
        }
    }
}

/// Greatest number of seconds of `session_time` and `link_time`: a year.
const LONGEST: f64 = 31_536_000.0;

impl WebSection {
    /// Checks the section, to which the command line was already applied.
    ///
    /// # Errors
    /// Other machines could reach the console without TLS, or a value is out of its range.
    pub fn check(&self, rpc: &Rpc) -> Result<(), UsageError> {
        if let Some(address) = self.listen
            && !address.ip().is_loopback()
            && rpc.tls.is_none()
        {
            return Err(UsageError::WebNoTls(address));
        }
        let wrong =
            |key, value: String, what: &str| UsageError::Web { key, value, what: what.into() };
        if self.max_sessions == 0 {
            return Err(wrong("max_sessions", "0".to_owned(), "one at least"));
        }
        for (key, value) in [("session_time", self.session_time), ("link_time", self.link_time)] {
            if !(value > 0.0 && value <= LONGEST) {
                let what = "seconds, more than 0 and at most 31536000, a year";
                return Err(wrong(key, value.to_string(), what));
            }
        }
        let plain = |c: char| c.is_ascii_alphanumeric() || ".-".contains(c);
        match self.hosts.iter().find(|host| host.is_empty() || !host.chars().all(plain)) {
            None => Ok(()),
            Some(host) => {
                let what = "a name without port, such as robot.local";
                Err(wrong("hosts", format!("\"{}\"", host.escape_default()), what))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(section: WebSection) -> Result<(), String> {
        section.check(&Rpc::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn others_reach_the_console_by_tls_only() {
        let at =
            |address: &str| WebSection { listen: address.parse().ok(), ..WebSection::default() };
        assert_eq!(checked(at("127.0.0.1:0")), Ok(()));
        assert_eq!(checked(at("[::1]:7380")), Ok(()));
        let refused = checked(at("0.0.0.0:7380")).unwrap_err();
        assert!(refused.contains("0.0.0.0:7380 can be reached from outside"), "{refused}");
    }

    #[test]
    fn a_value_out_of_its_range_is_named() {
        let usual = WebSection::default;
        for (section, told) in [
            (WebSection { max_sessions: 0, ..usual() }, "web.max_sessions = 0: one at least"),
            (WebSection { link_time: 0.0, ..usual() }, "web.link_time = 0: seconds"),
            (WebSection { session_time: f64::NAN, ..usual() }, "web.session_time = NaN: seconds"),
            (WebSection { session_time: 1e300, ..usual() }, "web.session_time = 1"),
            (
                WebSection { hosts: vec!["http://robot".to_owned()], ..usual() },
                "web.hosts = \"http://robot\": a name",
            ),
        ] {
            let refused = checked(section).unwrap_err();
            assert!(refused.starts_with(told), "{refused}");
        }
    }
}
