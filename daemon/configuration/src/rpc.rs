//! The control plane: where it listens, who may come in, its limits.

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
    /// Unix socket.
    pub socket: Option<PathBuf>,
    /// TCP address.
    pub listen: Option<SocketAddr>,
    /// Tokens of those who come by TCP or through a middleware.
    pub token_file: Option<PathBuf>,
    /// TLS of the TCP address.
    pub tls: Option<Tls>,
    /// Greatest size of a request's body, in bytes.
    pub max_body: usize,
    /// Connections served at a time, at each address.
    pub max_connections: usize,
    /// Requests under way at a time, at each address, of one token.
    pub max_connections_per_token: usize,
    /// Open streams at a time: of the Unix socket, and of all tokens together.
    pub max_streams: usize,
    /// The same of one token.
    pub max_streams_per_token: usize,
    /// Seconds the result of an ended activity stays readable.
    pub keep_results: u64,
}

/// Section `[rpc.tls]`; files in PEM.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Tls {
    /// The daemon's certificate, and those between it and its root.
    pub cert: PathBuf,
    /// Its key.
    pub key: PathBuf,
    /// Roots of clients' certificates: nobody comes in without one.
    #[serde(default)]
    pub client_ca: Option<PathBuf>,
    /// What a client's certificate is good for.
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

/// Where the control plane listens, who may come in, and its limits.
#[derive(Clone, Debug)]
pub struct RpcSettings {
    /// Unix socket.
    pub socket: PathBuf,
    /// TCP address, if asked for.
    pub listen: Option<SocketAddr>,
    /// Tokens of those who do not come by the Unix socket.
    pub token_file: Option<PathBuf>,
    /// TLS of the TCP address.
    pub tls: Option<Tls>,
    /// Greatest size of a request's body, in bytes.
    pub max_body: usize,
    /// Connections served at a time, at each address; more wait.
    pub max_connections: usize,
    /// Requests under way at a time, at each address, of one token; more are refused.
    pub max_connections_per_token: usize,
    /// Open streams at a time, of the Unix socket and of all tokens together; more are refused.
    pub max_streams: usize,
    /// The same of one token.
    pub max_streams_per_token: usize,
    /// How long the result of an ended activity stays readable.
    pub keep_results: Duration,
}

impl RpcSettings {
    /// What the section comes to, the command line already over it.
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
            // TLS tells the daemon to clients, not clients to the daemon.
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
