//! Errors of opening a session.

use std::path::PathBuf;

/// Name of this middleware in configurations and errors.
pub(crate) const BACKEND: &str = "zenoh";

/// A session could not be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SessionError {
    /// zenoh cannot parse its configuration file.
    #[error("{path} is no zenoh configuration: {why}")]
    ConfigFile {
        /// Path of the file.
        path: PathBuf,
        /// zenoh's message.
        why: String,
    },
    /// A key is unknown to zenoh, or its value is wrong.
    #[error("zenoh refuses {key} = {value}: {why}; see zenoh's DEFAULT_CONFIG.json5 for its keys")]
    Setting {
        /// Key of zenoh's configuration.
        key: String,
        /// The value as given.
        value: String,
        /// zenoh's message.
        why: String,
    },
    /// A certificate or key cannot be read.
    #[error("the {what} for TLS, {path}, cannot be read: {source}")]
    Tls {
        /// `authority`, `certificate` or `key`.
        what: &'static str,
        /// Path of the certificate or key.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// Other users can read the private key.
    #[error("others may read the key for TLS, {0}: `chmod 600 {0}`")]
    OpenKey(PathBuf),
    /// The session would be open to anybody on the network.
    #[error(
        "{0}, who may then call services and write ports: listen on tls/ with `mutual = true` and \
         certificates ([backends.zenoh.tls]), or on 127.0.0.1; or write `insecure = true` where \
         the network is yours alone"
    )]
    Insecure(String),
    /// A certificate without its key, or a key without its certificate.
    #[error("TLS needs `certificate` and `key` together")]
    HalfTls,
    /// The prefix is not valid as the beginning of a key expression.
    #[error("`{0}` is no prefix: write names with / between them, without wild cards")]
    Prefix(String),
    /// A client without an endpoint to connect to.
    #[error("a zenoh client needs an endpoint to connect to, like `tcp/127.0.0.1:7447`")]
    NoEndpoint,
    /// The folder of the sessions' sockets cannot be used.
    #[error("daemons cannot meet in {path}: {source}; name another folder, or none")]
    Rendezvous {
        /// Path of the folder.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// zenoh failed; the text is zenoh's.
    #[error("zenoh does not open: {0}")]
    Open(String),
    /// A client reached nobody by TLS; zenoh does not say why.
    #[error(
        "zenoh does not open: {0}: is somebody there, did `authority` sign their certificate, and \
         do they ask for a `certificate` of this side? `log = \"info,zenoh=debug\"` says which"
    )]
    Refused(String),
}
