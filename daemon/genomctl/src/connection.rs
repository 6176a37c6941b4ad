//! Options that select the daemon; `target` turns them into a connection.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;

/// Options that select the daemon.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct Connection {
    /// Socket of the daemon [default: $XDG_RUNTIME_DIR/genomd.sock, else /tmp/genomd-UID/genomd.sock].
    #[arg(long, global = true, value_name = "PATH", env = "GENOMD_SOCKET")]
    pub(crate) socket: Option<PathBuf>,
    /// Where the daemon is, if not at the socket: 127.0.0.1:7300 (`genomd --listen`),
    /// https://robot:7300 on another machine, or zenoh:NAME, one of those that the daemon at the
    /// socket sees over zenoh (`genomctl daemons`).
    #[arg(long, global = true, value_name = "HOST")]
    pub(crate) host: Option<Host>,
    /// Root of the daemon's certificate, in PEM.
    #[arg(long, global = true, value_name = "FILE")]
    pub(crate) ca: Option<PathBuf>,
    /// Your own certificate and its key, in PEM, for a daemon that asks for one.
    #[arg(long, global = true, value_name = "FILE")]
    pub(crate) cert: Option<PathBuf>,
    /// File with your token, which only you may read.
    #[arg(long, global = true, value_name = "FILE", env = "GENOMD_TOKEN_FILE")]
    pub(crate) token_file: Option<PathBuf>,
    /// Give up when the daemon answers no request at all for this many seconds [default: 10].
    ///
    /// A single request may take longer, as long as the daemon answers others.
    #[arg(long, global = true, value_name = "SECONDS")]
    pub(crate) timeout: Option<f64>,
    /// Name of a context: options kept under a name by `genomctl context`.
    #[arg(long, global = true, value_name = "NAME")]
    pub(crate) context: Option<String>,
}

/// A daemon given by `--host`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Host {
    /// At an address.
    Tcp(Tcp),
    /// A daemon that the one at the socket sees over zenoh, under this name.
    Zenoh(String),
}

/// The text is not the address of a daemon.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum HostError {
    #[error("expected zenoh:NAME; `genomctl daemons` lists names")]
    NoName,
    #[error("`{0}://` is neither http nor https")]
    Scheme(String),
    #[error("expected ADDRESS:PORT, https://NAME:PORT or zenoh:NAME")]
    NoPort,
}

impl FromStr for Host {
    type Err = HostError;

    fn from_str(text: &str) -> Result<Self, HostError> {
        match text.strip_prefix("zenoh:") {
            Some("") => Err(HostError::NoName),
            Some(name) => Ok(Self::Zenoh(name.to_owned())),
            None => text.parse().map(Self::Tcp),
        }
    }
}

impl std::fmt::Display for Host {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Tcp(tcp) => tcp.fmt(f),
            Self::Zenoh(name) => write!(f, "zenoh:{name}"),
        }
    }
}

/// A host name or IP address, and a port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Tcp {
    /// Whether `https://` or `http://` was given; `None` if neither.
    pub(crate) tls: Option<bool>,
    pub(crate) name: String,
    pub(crate) port: u16,
}

impl FromStr for Tcp {
    type Err = HostError;

    fn from_str(text: &str) -> Result<Self, HostError> {
        let (tls, rest) = match text.split_once("://") {
            Some(("https", rest)) => (Some(true), rest),
            Some(("http", rest)) => (Some(false), rest),
            Some((scheme, _)) => return Err(HostError::Scheme(scheme.to_owned())),
            None => (None, text),
        };
        let parts = rest.trim_end_matches('/').rsplit_once(':');
        let parsed = parts.and_then(|(name, port)| Some((name, port.parse().ok()?)));
        match parsed {
            Some((name, port)) if !name.is_empty() => {
                let name = name.trim_start_matches('[').trim_end_matches(']').to_owned();
                Ok(Self { tls, name, port })
            }
            _ => Err(HostError::NoPort),
        }
    }
}

impl std::fmt::Display for Tcp {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.tls {
            Some(true) => f.write_str("https://")?,
            Some(false) => f.write_str("http://")?,
            None => {}
        }
        if self.name.contains(':') {
            write!(f, "[{}]:{}", self.name, self.port)
        } else {
            write!(f, "{}:{}", self.name, self.port)
        }
    }
}

impl Tcp {
    /// Whether the address is on this machine (loopback).
    pub(crate) fn is_here(&self) -> bool {
        let address: Option<std::net::IpAddr> = self.name.parse().ok();
        self.name == "localhost" || address.is_some_and(|address| address.is_loopback())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts_are_read_as_they_are_written() {
        for text in ["127.0.0.1:7300", "https://robot.local:7300", "http://[::1]:1", "zenoh:arm"] {
            assert_eq!(text.parse::<Host>().unwrap().to_string(), text);
        }
        for wrong in ["robot", "ftp://robot:1", "https://:1", "robot:port", "robot:70000", "zenoh:"]
        {
            assert!(wrong.parse::<Host>().is_err(), "{wrong}");
        }
    }
}
