//! The control plane: addresses it listens on, who may use it, and its limits.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use genom_protocol::Right;
use genom_protocol::socket::default_path;
use serde::{Deserialize, Serialize};

use crate::error::UsageError;

/// Section `[rpc]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Rpc {
    /// Path of the Unix socket.
    pub socket: Option<PathBuf>,
    /// TCP address to listen on as well.
    pub listen: Option<SocketAddr>,
    /// File of tokens, for clients that connect by TCP or through a middleware.
    pub token_file: Option<PathBuf>,
    /// TLS of the TCP address.
    pub tls: Option<Tls>,
    /// Maximum size of a request's body, in bytes.
    pub max_body: usize,
    /// Connections served at once, per listening address.
    pub max_connections: usize,
    /// Requests under way at once with one token, per listening address.
    pub max_connections_per_token: usize,
    /// Streams open at once: by the Unix socket, and by all tokens together.
    pub max_streams: usize,
    /// Streams open at once with one token.
    pub max_streams_per_token: usize,
    /// Seconds that the result of an ended activity is kept.
    pub keep_results: u64,
}

/// Section `[rpc.tls]`; all files are PEM.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Tls {
    /// The daemon's certificate chain, its own certificate first.
    pub cert: PathBuf,
    /// The daemon's private key.
    pub key: PathBuf,
    /// Root certificates that clients' certificates are checked against. If set, clients without a
    /// certificate are refused.
    #[serde(default)]
    pub client_ca: Option<PathBuf>,
    /// Rights of a client that has a valid certificate.
    #[serde(default = "read_only")]
    pub client_rights: Vec<Right>,
}

fn read_only() -> Vec<Right> {
    vec![Right::Read]
}

impl Default for Rpc {
    fn default() -> Self {
        Self {
            socket: None,
            listen: None,
            token_file: None,
            tls: None,
            max_body: 1 << 20,
            max_connections: 256,
            max_connections_per_token: 64,
            max_streams: 64,
            max_streams_per_token: 16,
            keep_results: 300,
        }
    }
}

/// Settings of the control plane after checks and defaults.
#[derive(Clone, Debug)]
pub struct RpcSettings {
    /// Path of the Unix socket.
    pub socket: PathBuf,
    /// TCP address to listen on as well.
    pub listen: Option<SocketAddr>,
    /// File of tokens, for clients that do not use the Unix socket.
    pub token_file: Option<PathBuf>,
    /// TLS of the TCP address.
    pub tls: Option<Tls>,
    /// Maximum size of a request's body, in bytes.
    pub max_body: usize,
    /// Connections served at once, per listening address; further ones wait.
    pub max_connections: usize,
    /// Requests under way at once with one token, per listening address; further ones are refused.
    pub max_connections_per_token: usize,
    /// Streams open at once, by the Unix socket and by all tokens together; further ones are
    /// refused.
    pub max_streams: usize,
    /// Streams open at once with one token; further ones are refused.
    pub max_streams_per_token: usize,
    /// How long the result of an ended activity is kept.
    pub keep_results: Duration,
}

impl RpcSettings {
    /// Checks the section, to which the command line was already applied, and fills in defaults.
    pub fn new(config: Rpc) -> Result<Self, UsageError> {
        if let Some(address) = config.listen {
            let certified = config.tls.as_ref().is_some_and(|tls| tls.client_ca.is_some());
            if !address.ip().is_loopback() && config.tls.is_none() {
                return Err(UsageError::NoTls(address));
            }
            if config.token_file.is_none() && !certified {
                return Err(UsageError::Anybody(address));
            }
        }
        if config.max_connections == 0 {
            return Err(UsageError::NoConnections);
        }
        Ok(Self {
            socket: config.socket.unwrap_or_else(default_path),
            listen: config.listen,
            token_file: config.token_file,
            tls: config.tls,
            max_body: config.max_body,
            max_connections: config.max_connections,
            max_connections_per_token: config.max_connections_per_token,
            max_streams: config.max_streams,
            max_streams_per_token: config.max_streams_per_token,
            keep_results: Duration::from_secs(config.keep_results),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(
        listen: &str,
        tokens: Option<&str>,
        tls: Option<Tls>,
    ) -> Result<RpcSettings, String> {
        let (listen, token_file) = (listen.parse().ok(), tokens.map(PathBuf::from));
        let section = Rpc { listen, token_file, tls, ..Rpc::default() };
        RpcSettings::new(section).map_err(|error| error.to_string())
    }

    fn tls(client_ca: Option<&str>) -> Option<Tls> {
        let client_ca = client_ca.map(PathBuf::from);
        Some(Tls { cert: "c".into(), key: "k".into(), client_ca, client_rights: read_only() })
    }

    #[test]
    fn nobody_listens_on_tcp_for_anybody() {
        for address in ["127.0.0.1:0", "[::1]:0"] {
            assert!(settings(address, Some("t"), None).is_ok());
            let refused = settings(address, None, None).unwrap_err();
            assert!(refused.contains("--token-file"), "{refused}");
            // With TLS the daemon is authenticated to clients, but clients are not authenticated to
            // the daemon.
            assert!(settings(address, None, tls(None)).is_err());
        }
    }

    #[test]
    fn others_reach_the_daemon_by_tls_only() {
        let address = "0.0.0.0:7300";
        let refused = settings(address, Some("t"), None).unwrap_err();
        assert!(refused.contains("0.0.0.0:7300 can be reached from outside"), "{refused}");
        assert!(settings(address, Some("t"), tls(None)).is_ok());
        assert!(settings(address, None, tls(Some("ca"))).is_ok());
        assert!(settings(address, None, tls(None)).is_err());
    }
}
