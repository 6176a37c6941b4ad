//! Options for opening a session, and the zenoh configuration made from them.

use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use zenoh::Config;

use crate::error::SessionError;
use crate::reach;
use crate::rendezvous;
use crate::settings;

/// Role of the session in the network.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Communicates with other peers directly.
    #[default]
    Peer,
    /// Communicates through a single router or peer; needs an endpoint to connect to.
    Client,
    /// Also forwards what others send.
    Router,
}

/// Section `[backends.zenoh]` of the configuration; `configs/zenoh.toml` explains it.
///
/// By default the session stays within this machine: it listens on a Unix socket that only this
/// user can access, does not scout on a network, and finds all other sessions that do the same.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Peer, client or router. Ignored if there is a `config_file`, which then sets the mode.
    pub mode: Mode,
    /// Folder in which sessions of this machine find each other. `None` (an empty string in a
    /// configuration) turns this off.
    #[serde(deserialize_with = "settings::folder")]
    pub rendezvous: Option<PathBuf>,
    /// Further endpoints to listen on, such as `tcp/127.0.0.1:7447` or `tcp/0.0.0.0:7447`.
    pub listen: Vec<String>,
    /// Further endpoints to connect to; retried for as long as the session exists.
    pub connect: Vec<String>,
    /// Prefix of all keys, to separate groups of robots.
    pub prefix: String,
    /// Path of a zenoh configuration (JSON5 or YAML) that replaces the local defaults. Key:
    /// `config`.
    #[serde(rename = "config")]
    pub config_file: Option<PathBuf>,
    /// Certificates for endpoints `tls/HOST:PORT`.
    pub tls: Tls,
    /// Whether other machines may connect without certificates. Anybody who connects may call
    /// services.
    pub insecure: bool,
    /// Settings of zenoh's own configuration with JSON5 values, applied last, such as
    /// `("scouting/multicast/enabled", "true")`. A table in a configuration.
    #[serde(deserialize_with = "settings::of_zenoh")]
    pub set: Vec<(String, String)>,
}

/// Section `[backends.zenoh.tls]`: certificates of a session, as PEM files.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(default, deny_unknown_fields)]
pub struct Tls {
    /// Certificate authority: peers whose certificate it signed are trusted. `None`: the public
    /// certificate authorities of the web.
    pub authority: Option<PathBuf>,
    /// Certificate of this session. When it connects to others, it shows this only if
    /// [`mutual`](Tls::mutual) is set there.
    pub certificate: Option<PathBuf>,
    /// Private key of the certificate.
    pub key: Option<PathBuf>,
    /// Whether those who connect must show a certificate, too.
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
            tls: Tls::default(),
            insecure: false,
            set: Vec::new(),
        }
    }
}

impl Options {
    /// zenoh's configuration for a session that listens on `own` and connects to `others`.
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
                why: genom_zenoh_doctor::mistake(&error.to_string()),
            })?,
            None => Config::default(),
        };
        let own = own.map(rendezvous::endpoint);
        let listen: Vec<_> = own.iter().chain(&self.listen).cloned().collect();
        let others = others.iter().map(|socket| rendezvous::endpoint_of_other(socket));
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
                // Queries and replies are not sent in shared memory: under load zenoh may free it
                // while they are in transit (eclipse-zenoh/zenoh#2628).
                ("transport/shared_memory/transport_optimization/messages", "[\"put\"]"),
            ] {
                insert(&mut config, key, value)?;
            }
        }
        // Without this zenoh would listen on all network interfaces.
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

    /// The folder of the sessions' sockets, if this session has no other links. A program that
    /// connects to the sessions there then reaches everything that this one reaches.
    pub(crate) fn sole_meeting(&self) -> Option<&Path> {
        let more = [&self.listen, &self.connect].iter().any(|endpoints| !endpoints.is_empty());
        self.meeting().filter(|_| !more && self.set.is_empty() && self.mode == Mode::Peer)
    }

    /// The folder of the sessions' sockets. `None` for a client, which does not listen, and with a
    /// `config_file`, which decides everything.
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
        // zenoh opens these files only when it connects, and then reports only that it cannot.
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
        assert!(get("connect/endpoints").starts_with(r#"["unixsock-stream//run/y.sock#retry"#));
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
        // Opening the session to anybody must be requested explicitly.
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

    #[test]
    fn options_are_read_and_wrong_ones_are_named() {
        let given = "mode = \"client\"\nconnect = [\"tcp/127.0.0.1:7447\"]\nrendezvous = \"\"\n\
                     config = \"/z.json5\"\n[tls]\nauthority = \"/ca.pem\"\nmutual = true\n\
                     [set]\n\"transport/link/tx/queue/size/data\" = 4\n";
        let options: Options = toml::from_str(given).unwrap();
        assert_eq!((options.mode, &options.rendezvous), (Mode::Client, &None));
        assert_eq!(options.config_file, Some("/z.json5".into()));
        assert!(options.tls.mutual);
        assert_eq!(options.tls.authority, Some("/ca.pem".into()));
        assert_eq!(options.set, [("transport/link/tx/queue/size/data".into(), "4".into())]);
        assert_eq!(toml::from_str::<Options>("").unwrap(), Options::default());
        for (given, known) in [("lisen = []", "`listen`"), ("[tls]\nkee = 1", "`key`")] {
            let error = toml::from_str::<Options>(given).unwrap_err().to_string();
            assert!(error.contains("unknown field") && error.contains(known), "{error}");
        }
    }
}
