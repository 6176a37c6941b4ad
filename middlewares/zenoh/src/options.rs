//! What the user may choose, and the zenoh configuration it gives.

use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

use zenoh::Config;

use crate::reach;
use crate::rendezvous;

/// What the session is among others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Talks to other peers directly.
    #[default]
    Peer,
    /// Talks to one router or peer only; needs an endpoint to connect to.
    Client,
    /// Passes on what others send, too.
    Router,
}

/// How to open a session. The default stays within this machine: it listens on a Unix socket of
/// this user only, looks for nobody on a network, and finds all others that do the same.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Peer, client or router. Ignored with a `config_file`, which says it.
    pub mode: Mode,
    /// Folder in which sessions of this machine find each other; none: they do not.
    pub rendezvous: Option<PathBuf>,
    /// Endpoints to listen on besides: `tcp/127.0.0.1:7447`, `tcp/0.0.0.0:7447`.
    pub listen: Vec<String>,
    /// Endpoints to connect to besides; retried as long as the session lives.
    pub connect: Vec<String>,
    /// Put before all keys, to keep groups of robots apart.
    pub prefix: String,
    /// A zenoh configuration (JSON5 or YAML) instead of the local defaults.
    pub config_file: Option<PathBuf>,
    /// Keys of zenoh's configuration with JSON5 values, applied last:
    /// `("scouting/multicast/enabled", "true")`.
    pub set: Vec<(String, String)>,
    /// For endpoints `tls/HOST:PORT`.
    pub tls: Tls,
    /// Whether anybody may come in from other machines: who reaches a session calls services.
    pub insecure: bool,
}

/// Certificates of a session, in PEM files.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tls {
    /// Whoever shows a certificate that this one signed is trusted. None: who has one of the
    /// authorities known to the web.
    pub authority: Option<PathBuf>,
    /// What this session shows: to those it connects to when [`mutual`](Tls::mutual) is asked for.
    pub certificate: Option<PathBuf>,
    /// The private key to it.
    pub key: Option<PathBuf>,
    /// Those who connect must show a certificate, too.
    pub mutual: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            rendezvous: Some(rendezvous::default_directory()),
            listen: Vec::new(),
            connect: Vec::new(),
            prefix: String::new(),
            config_file: None,
            set: Vec::new(),
            tls: Tls::default(),
            insecure: false,
        }
    }
}

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
        /// The key.
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
        /// The file.
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

impl Options {
    /// zenoh's configuration, when this session listens on `own` and connects to `others`.
    pub(crate) fn to_zenoh(
        &self,
        own: Option<&Path>,
        others: &[PathBuf],
    ) -> Result<Config, SessionError> {
        let client = self.mode == Mode::Client && self.config_file.is_none();
        if client && self.connect.is_empty() {
            return Err(SessionError::NoEndpoint);
        }
        let mut config = match &self.config_file {
            Some(path) => Config::from_file(path).map_err(|error| SessionError::ConfigFile {
                path: path.clone(),
                why: error.to_string(),
            })?,
            None => Config::default(),
        };
        let own = own.map(rendezvous::endpoint);
        let listen: Vec<_> = own.iter().chain(&self.listen).cloned().collect();
        let others = others.iter().map(|socket| rendezvous::endpoint(socket));
        let connect: Vec<_> = others.chain(self.connect.iter().cloned()).collect();
        if self.config_file.is_none() {
            let mode = match self.mode {
                Mode::Peer => "\"peer\"",
                Mode::Client => "\"client\"",
                Mode::Router => "\"router\"",
            };
            for (key, value) in [
                ("mode", mode),
                ("scouting/multicast/enabled", "false"),
                ("scouting/gossip/enabled", "false"),
                ("adminspace/enabled", "false"),
                // Queries and replies stay out of shared memory: under load zenoh may take it
                // back while they are under way (eclipse-zenoh/zenoh#2628).
                ("transport/shared_memory/transport_optimization/messages", "[\"put\"]"),
            ] {
                insert(&mut config, key, value)?;
            }
        }
        // Without this zenoh would listen on every network interface.
        if self.config_file.is_none() || !listen.is_empty() {
            insert(&mut config, "listen/endpoints", &json(&listen))?;
        }
        if self.config_file.is_none() || !connect.is_empty() {
            insert(&mut config, "connect/endpoints", &json(&connect))?;
        }
        self.tls.insert(&mut config)?;
        for (key, value) in &self.set {
            insert(&mut config, key, value)?;
        }
        match reach::open_to_all(&config).filter(|_| !self.insecure) {
            Some(open) => Err(SessionError::Insecure(open.0)),
            None => Ok(config),
        }
    }

    /// The folder to meet in, when all that this session reaches is there: who meets them there
    /// too misses nobody.
    pub(crate) fn sole_meeting(&self) -> Option<&Path> {
        let more = [&self.listen, &self.connect].iter().any(|endpoints| !endpoints.is_empty());
        self.meeting().filter(|_| !more && self.set.is_empty() && self.mode == Mode::Peer)
    }

    /// The folder to meet in. A client listens nowhere, and a file of the user's says all.
    pub(crate) fn meeting(&self) -> Option<&Path> {
        let meets = self.mode != Mode::Client && self.config_file.is_none();
        self.rendezvous.as_deref().filter(|_| meets)
    }
}

impl Tls {
    fn insert(&self, config: &mut Config) -> Result<(), SessionError> {
        let Self { authority, certificate, key, mutual } = self;
        if certificate.is_some() != key.is_some() {
            return Err(SessionError::HalfTls);
        }
        // zenoh does not open a file before it connects, and then only says that it cannot.
        for (what, path) in [("authority", authority), ("certificate", certificate), ("key", key)] {
            let Some(path) = path else { continue };
            let read = std::fs::File::open(path).and_then(|file| file.metadata());
            let found =
                read.map_err(|source| SessionError::Tls { what, path: path.clone(), source })?;
            if what == "key" && found.mode() & 0o077 != 0 {
                return Err(SessionError::OpenKey(path.clone()));
            }
        }
        for (name, path) in [
            ("root_ca_certificate", authority),
            ("listen_certificate", certificate),
            ("listen_private_key", key),
            ("connect_certificate", certificate),
            ("connect_private_key", key),
        ] {
            if let Some(path) = path {
                let path = serde_json::Value::from(path.display().to_string()).to_string();
                insert(config, &format!("transport/link/tls/{name}"), &path)?;
            }
        }
        if *mutual { insert(config, "transport/link/tls/enable_mtls", "true") } else { Ok(()) }
    }
}

fn json(list: &[String]) -> String {
    serde_json::Value::from(list).to_string()
}

fn insert(config: &mut Config, key: &str, value: &str) -> Result<(), SessionError> {
    config.insert_json5(key, value).map_err(|error| SessionError::Setting {
        key: key.to_owned(),
        value: value.to_owned(),
        why: error.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_listens_nowhere_but_on_its_socket_and_looks_for_nobody() {
        let own = Path::new("/run/x.sock");
        let config = Options::default().to_zenoh(Some(own), &["/run/y.sock".into()]).unwrap();
        let get = |key: &str| config.get_json(key).unwrap();
        assert_eq!(get("listen/endpoints"), r#"["unixsock-stream//run/x.sock"]"#);
        assert_eq!(get("connect/endpoints"), r#"["unixsock-stream//run/y.sock"]"#);
        assert_eq!(get("scouting/multicast/enabled"), "false");
        assert_eq!(get("scouting/gossip/enabled"), "false");
    }

    #[test]
    fn settings_reach_zenoh_and_wrong_ones_are_named() {
        let set = |key: &str, value: &str| Options {
            set: vec![(key.to_owned(), value.to_owned())],
            ..Options::default()
        };
        let config = set("scouting/gossip/enabled", "true").to_zenoh(None, &[]).unwrap();
        assert_eq!(config.get_json("scouting/gossip/enabled").unwrap(), "true");
        // What lets anybody in has to be asked for twice.
        let open = set("scouting/multicast/enabled", "true");
        let refused = open.to_zenoh(None, &[]).unwrap_err().to_string();
        assert!(refused.contains("insecure = true"), "{refused}");
        assert!(Options { insecure: true, ..open }.to_zenoh(None, &[]).is_ok());
        for (key, value) in [("no/such/key", "1"), ("mode", "\"king\""), ("mode", "{")] {
            let error = set(key, value).to_zenoh(None, &[]).unwrap_err().to_string();
            assert!(error.contains(key), "{error}");
        }
    }

    #[test]
    fn a_file_says_all_and_a_wrong_one_is_named() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("zenoh.json5");
        let options = Options { config_file: Some(path.clone()), ..Options::default() };
        std::fs::write(
            &path,
            "{ mode: 'client', connect: { endpoints: ['tcp/x:1'] }, \
             listen: { endpoints: [] }, scouting: { multicast: { enabled: false } } }",
        )
        .unwrap();
        let config = options.to_zenoh(None, &[]).unwrap();
        assert_eq!(config.get_json("connect/endpoints").unwrap(), r#"["tcp/x:1"]"#);
        assert_eq!(options.meeting(), None);
        std::fs::write(&path, "{ mode: ").unwrap();
        let error = options.to_zenoh(None, &[]).unwrap_err().to_string();
        assert!(error.contains("zenoh.json5"), "{error}");
    }
}
