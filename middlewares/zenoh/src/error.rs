//! Why a session does not open.

use std::path::PathBuf;

/// What configurations and errors call this middleware.
pub(crate) const BACKEND: &str = "zenoh";

/// A session could not be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SessionError {
    /// zenoh does not understand its configuration file.
    #[error("{path} is no zenoh configuration: {why}")]
    ConfigFile {
        /// Which file.
        path: PathBuf,
        /// zenoh's own words.
        why: String,
    },
    /// A key is unknown to zenoh, or its value is wrong.
    #[error("zenoh refuses {key} = {value}: {why}; see zenoh's DEFAULT_CONFIG.json5 for its keys")]
    Setting {
        /// Key of zenoh's configuration.
        key: String,
        /// The value as given.
        value: String,
        /// zenoh's own words.
        why: String,
    },
    /// A certificate or key cannot be read.
    #[error("the {what} for TLS, {path}, cannot be read: {source}")]
    Tls {
        /// Which one.
        what: &'static str,
        /// Path of the certificate or key.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Others could read the private key.
    #[error("others may read the key for TLS, {0}: `chmod 600 {0}`")]
    OpenKey(PathBuf),
    /// Anybody on the network could come in.
    #[error(
        "{0}, who may then call services and write ports: listen on tls/ with `mutual = true` and \
         certificates ([backends.zenoh.tls]), or on 127.0.0.1; or write `insecure = true` where \
         the network is yours alone"
    )]
    Insecure(String),
    /// A certificate without its key, or the other way round.
    #[error("TLS needs `certificate` and `key` together")]
    HalfTls,
    /// The prefix is no beginning of a key.
    #[error("`{0}` is no prefix: write names with / between them, without wild cards")]
    Prefix(String),
    /// A client has nothing to connect to.
    #[error("a zenoh client needs an endpoint to connect to, like `tcp/127.0.0.1:7447`")]
    NoEndpoint,
    /// The folder where sessions meet cannot be used.
    #[error("daemons cannot meet in {path}: {source}; name another folder, or none")]
    Rendezvous {
        /// Which folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// zenoh did not open.
    #[error("zenoh does not open: {0}")]
    Open(String),
    /// A client reached nobody by TLS: zenoh does not say why.
    #[error(
        "zenoh does not open: {0}: is somebody there, did `authority` sign their certificate, and \
         do they ask for a `certificate` of this side? `log = \"info,zenoh=debug\"` says which"
    )]
    Refused(String),
}
