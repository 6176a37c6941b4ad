//! The middlewares of this daemon. The one place that knows which there are.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;

use genom_middleware::Middleware;
use genom_protocol::nearest::{nearest, nearest_key};
use serde::Deserialize;

/// A middleware this daemon was built with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    /// What `--backend` calls it.
    pub(crate) name: &'static str,
    /// Version of the library behind it.
    pub(crate) version: &'static str,
    /// Refuses a section of the configuration that makes no sense, and opens nothing.
    check: fn(&toml::Table) -> Result<(), String>,
    /// Opens it with its section of the configuration.
    open: fn(&toml::Table) -> Result<Arc<dyn Middleware>, String>,
}

/// Every middleware there is; adding one means adding a line here.
pub(crate) fn known() -> &'static [Known] {
    &[
        Known {
            name: "local",
            version: env!("CARGO_PKG_VERSION"),
            check: |options| read::<NoOptions>(options).map(drop),
            open: |options| {
                read::<NoOptions>(options)?;
                Ok(Arc::new(genom_local::Local::new()))
            },
        },
        Known {
            name: "shm",
            version: "iceoryx2 0.10",
            check: |options| read::<ShmOptions>(options)?.options().map(drop),
            open: |options| match genom_shm::Shm::open(read::<ShmOptions>(options)?.options()?) {
                Ok(shm) => Ok(Arc::new(shm)),
                Err(error) => Err(error.to_string()),
            },
        },
        Known {
            name: "zenoh",
            version: "zenoh 1.10",
            check: |options| read::<ZenohOptions>(options).map(drop),
            open: |options| match genom_zenoh::Zenoh::open(&read::<ZenohOptions>(options)?.into()) {
                Ok(zenoh) => Ok(zenoh),
                Err(error) => Err(error.to_string()),
            },
        },
        Known {
            name: "ros2",
            // The same on the wire since ROS 2 Iron.
            version: "rustdds 0.15, ROS 2 Iron to Kilted",
            check: |options| read::<Ros2Options>(options).map(drop),
            open: |options| {
                let options = read::<Ros2Options>(options)?.over_environment()?;
                match genom_ros2::Ros2::open(&options) {
                    Ok(ros2) => Ok(ros2),
                    Err(error) => Err(error.to_string()),
                }
            },
        },
    ]
}

/// The sections of a configuration file that middlewares read: for a look at them beforehand,
/// while the file's lines are known.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Sections {
    #[allow(dead_code, reason = "read to see that it can be")]
    backends: EachSection,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
#[allow(dead_code, reason = "read to see that they can be")]
struct EachSection {
    local: Option<NoOptions>,
    shm: Option<ShmOptions>,
    zenoh: Option<ZenohOptions>,
    ros2: Option<Ros2Options>,
}

/// `[backends.local]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct NoOptions {}

/// `[backends.shm]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ShmOptions {
    /// Start of the names of shared memory: daemons with another prefix do not meet.
    prefix: Option<String>,
    /// Directory of the files that say what is there.
    root: Option<PathBuf>,
    /// Readers a port may have.
    readers: Option<usize>,
    /// Unread samples a reader may hold.
    depth: Option<usize>,
}

impl ShmOptions {
    fn options(self) -> Result<genom_shm::Options, String> {
        let Self { prefix, root, readers, depth } = self;
        let default = genom_shm::Options::default();
        let within = |key: &str, value: Option<usize>, default: usize, least: usize| {
            let value = value.unwrap_or(default);
            let fits = (least..=genom_shm::Options::MOST).contains(&value);
            fits.then_some(value).ok_or_else(|| {
                format!("{key} = {value}: give {least} to {}", genom_shm::Options::MOST)
            })
        };
        let readers = within("readers", readers, default.readers, 1)?;
        let depth = within("depth", depth, default.depth, 2)?;
        Ok(genom_shm::Options { prefix, root, readers, depth, ..default })
    }
}

/// `[backends.zenoh]`; `configs/zenoh.toml` explains it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct ZenohOptions {
    mode: ZenohMode,
    /// Folder where daemons of this machine find each other; empty: they do not.
    rendezvous: PathBuf,
    listen: Vec<String>,
    connect: Vec<String>,
    prefix: String,
    config: Option<PathBuf>,
    tls: ZenohTls,
    /// Whether anybody may come in from other machines.
    insecure: bool,
    /// Keys of zenoh's own configuration.
    set: toml::Table,
}

/// `[backends.zenoh.tls]`
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct ZenohTls {
    authority: Option<PathBuf>,
    certificate: Option<PathBuf>,
    key: Option<PathBuf>,
    mutual: bool,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ZenohMode {
    Peer,
    Client,
    Router,
}

impl Default for ZenohOptions {
    fn default() -> Self {
        Self {
            mode: ZenohMode::Peer,
            rendezvous: genom_zenoh::default_directory(),
            listen: Vec::new(),
            connect: Vec::new(),
            prefix: String::new(),
            config: None,
            tls: ZenohTls::default(),
            insecure: false,
            set: toml::Table::new(),
        }
    }
}

impl From<ZenohOptions> for genom_zenoh::Options {
    fn from(options: ZenohOptions) -> Self {
        let ZenohOptions { mode, rendezvous, listen, connect, prefix, .. } = options;
        let ZenohOptions { config, tls, set, insecure, .. } = options;
        let ZenohTls { authority, certificate, key, mutual } = tls;
        Self {
            mode: match mode {
                ZenohMode::Peer => genom_zenoh::Mode::Peer,
                ZenohMode::Client => genom_zenoh::Mode::Client,
                ZenohMode::Router => genom_zenoh::Mode::Router,
            },
            rendezvous: Some(rendezvous).filter(|folder| !folder.as_os_str().is_empty()),
            listen,
            connect,
            prefix,
            config_file: config,
            tls: genom_zenoh::Tls { authority, certificate, key, mutual },
            insecure,
            // JSON is JSON5, and a value of TOML is one of JSON.
            set: set.into_iter().map(|(key, value)| (key, json(value))).collect(),
        }
    }
}

/// `[backends.ros2]`; `configs/ros2.toml` explains it.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Ros2Options {
    /// What is not set here is as ROS's variables say.
    domain: Option<u16>,
    networks: Option<Ros2Networks>,
    namespace: String,
    services: Ros2Services,
    qos: Ros2Qos,
    /// Attributes are parameters, too, unless this says no.
    parameters: Option<bool>,
    /// ROS types to use for IDL types.
    masquerade: BTreeMap<String, String>,
    /// Folders of packages that define them.
    interfaces: Vec<PathBuf>,
    /// Bytes.
    greatest_sample: Option<u32>,
    participants: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Ros2Networks {
    Named(Ros2Range),
    Only(Vec<std::net::IpAddr>),
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Ros2Range {
    Loopback,
    All,
}

/// How requests and replies are told apart on the wire.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Ros2Services {
    #[default]
    Enhanced,
    Cyclone,
}

/// `[backends.ros2.qos]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Ros2Qos {
    reliable: bool,
    depth: usize,
    transient_local: bool,
}

impl Default for Ros2Qos {
    fn default() -> Self {
        let genom_ros2::Qos { reliable, depth, transient_local } = genom_ros2::Qos::default();
        Self { reliable, depth, transient_local }
    }
}

impl Ros2Options {
    /// The environment of ROS, with what the configuration says instead.
    fn over_environment(self) -> Result<genom_ros2::Options, String> {
        let environment = genom_ros2::Options::from_env().map_err(|error| error.to_string())?;
        let Self { domain, networks, namespace, services, qos, .. } = self;
        let Self { parameters, masquerade, interfaces, greatest_sample, participants, .. } = self;
        let usual = environment.limits;
        let Ros2Qos { reliable, depth, transient_local } = qos;
        Ok(genom_ros2::Options {
            domain: domain.unwrap_or(environment.domain),
            networks: match networks {
                None => environment.networks,
                Some(Ros2Networks::Named(Ros2Range::Loopback)) => genom_ros2::Networks::Loopback,
                Some(Ros2Networks::Named(Ros2Range::All)) => genom_ros2::Networks::All,
                Some(Ros2Networks::Only(addresses)) => genom_ros2::Networks::Only(addresses),
            },
            namespace,
            services: match services {
                Ros2Services::Enhanced => genom_ros2::ServiceMapping::Enhanced,
                Ros2Services::Cyclone => genom_ros2::ServiceMapping::Cyclone,
            },
            qos: genom_ros2::Qos { reliable, depth, transient_local },
            parameters: parameters.unwrap_or(environment.parameters),
            masquerade,
            interfaces,
            limits: genom_ros2::Limits {
                sample: greatest_sample.unwrap_or(usual.sample),
                participants: participants.unwrap_or(usual.participants),
                ..usual
            },
        })
    }
}

fn json(value: toml::Value) -> String {
    serde_json::to_string(&value).unwrap_or_default()
}

fn read<T: serde::de::DeserializeOwned>(options: &toml::Table) -> Result<T, String> {
    options.clone().try_into().map_err(|error: toml::de::Error| {
        let message = error.message().to_owned();
        let near = nearest_key(&message).map(|near| format!("; did you mean `{near}`?"));
        message + &near.unwrap_or_default()
    })
}

/// A middleware could not be had.
#[derive(Debug, thiserror::Error)]
pub(crate) enum BackendError {
    /// No such middleware.
    #[error("unknown backend `{name}`{}. This daemon knows: {}", meant(.name), names())]
    Unknown { name: String },
    /// Its section of the configuration makes no sense.
    #[error("[backends.{name}]: {why}")]
    Options { name: String, why: String },
    /// It does not open on this machine.
    #[error("backend {name} cannot be opened: {why}")]
    Closed { name: String, why: String },
    /// What a description says of a foreign type makes no sense.
    #[error("#pragma masquerade: {0}")]
    Masquerade(String),
}

fn meant(name: &str) -> String {
    nearest(name, known().iter().map(|known| known.name))
        .map(|near| format!(" (did you mean `{near}`?)"))
        .unwrap_or_default()
}

fn names() -> String {
    known().iter().map(|known| known.name).collect::<Vec<_>>().join(", ")
}

/// Refuses a name that stands for no middleware.
pub(crate) fn check(name: &str) -> Result<Known, BackendError> {
    known()
        .iter()
        .find(|known| known.name == name)
        .copied()
        .ok_or_else(|| BackendError::Unknown { name: name.to_owned() })
}

/// Refuses sections of the configuration that no middleware reads, also of those that are not in
/// use: a component may move there while it runs.
pub(crate) fn check_options(options: &BTreeMap<String, toml::Table>) -> Result<(), BackendError> {
    for (name, section) in options {
        let wrong = |why| BackendError::Options { name: name.clone(), why };
        (check(name)?.check)(section).map_err(wrong)?;
    }
    Ok(())
}

/// The middlewares in use. Each is opened when first needed, and stays open.
pub(crate) struct Backends {
    /// Their sections of the configuration, by name.
    options: BTreeMap<String, toml::Table>,
    open: Mutex<Open>,
    /// Told of each when it opens.
    opens: OnceLock<Box<OnOpen>>,
    /// What descriptions say is to be shown as a foreign type, by middleware, IDL name and foreign
    /// name: for middlewares that open later.
    masquerades: Mutex<Vec<(String, String, String)>>,
}

/// Those that are open, each since this date.
type Open = BTreeMap<&'static str, (Arc<dyn Middleware>, Instant)>;

type OnOpen = dyn Fn(&dyn Middleware) + Send + Sync;

impl Backends {
    /// None open yet.
    pub(crate) fn new(options: BTreeMap<String, toml::Table>) -> Self {
        Self {
            options,
            open: Mutex::default(),
            opens: OnceLock::new(),
            masquerades: Mutex::default(),
        }
    }

    /// Has `told` called with each middleware when it opens; once, before the first does.
    pub(crate) fn on_open(&self, told: impl Fn(&dyn Middleware) + Send + Sync + 'static) {
        let _ = self.opens.set(Box::new(told));
    }

    /// The middleware of that name, open.
    pub(crate) fn get(&self, name: &str) -> Result<Arc<dyn Middleware>, BackendError> {
        let known = check(name)?;
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((middleware, _)) = open.get(known.name) {
            return Ok(Arc::clone(middleware));
        }
        let middleware = (known.open)(self.options.get(known.name).unwrap_or(&toml::Table::new()))
            .map_err(|why| BackendError::Closed { name: name.to_owned(), why })?;
        open.insert(known.name, (Arc::clone(&middleware), Instant::now()));
        let masquerades = self.masquerades.lock().unwrap_or_else(PoisonError::into_inner);
        for (_, ours, foreign) in masquerades.iter().filter(|(on, ..)| on == known.name) {
            middleware.masquerade(ours, foreign).map_err(BackendError::Masquerade)?;
        }
        drop(masquerades);
        drop(open);
        if let Some(told) = self.opens.get() {
            told(middleware.as_ref());
        }
        Ok(middleware)
    }

    /// Shows a type or service as a foreign one on a middleware, if that is one of this daemon's.
    pub(crate) fn masquerade(
        &self,
        on: &str,
        ours: &str,
        foreign: &str,
    ) -> Result<(), BackendError> {
        if !known().iter().any(|known| known.name == on) {
            // `#pragma masquerade ros ...` is for GenoM3's own templates.
            return Ok(());
        }
        let open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((middleware, _)) = open.get(on) {
            middleware.masquerade(ours, foreign).map_err(BackendError::Masquerade)?;
        }
        let mut all = self.masquerades.lock().unwrap_or_else(PoisonError::into_inner);
        let one = (on.to_owned(), ours.to_owned(), foreign.to_owned());
        if !all.contains(&one) {
            all.push(one);
        }
        Ok(())
    }

    /// Lets go of all: each closes when its last user has.
    pub(crate) fn close(&self) {
        self.open.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// The middleware of that name, if something already uses it.
    pub(crate) fn opened(&self, name: &str) -> Option<Arc<dyn Middleware>> {
        let open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        open.get(name).map(|(middleware, _)| Arc::clone(middleware))
    }

    /// Since when it is open.
    pub(crate) fn open_since(&self, name: &str) -> Option<Instant> {
        let open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        open.get(name).map(|(_, since)| *since)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_backend_lists_the_known_ones() {
        let told = check("smh").unwrap_err().to_string();
        assert_eq!(
            told,
            "unknown backend `smh` (did you mean `shm`?). This daemon knows: local, shm, zenoh, \
             ros2"
        );
    }

    #[test]
    fn options_are_refused_also_of_middlewares_that_are_not_in_use() {
        let told = |text: &str| check_options(&toml::from_str(text).unwrap()).unwrap_err();
        assert_eq!(
            told("[shm]\nprefx = 'a'").to_string(),
            "[backends.shm]: unknown field `prefx`, expected one of `prefix`, `root`, `readers`, \
             `depth`; did you mean `prefix`?"
        );
        assert_eq!(
            told("[shm]\ndepth = 1").to_string(),
            "[backends.shm]: depth = 1: give 2 to 1024"
        );
        assert!(told("[zenho]").to_string().contains("did you mean `zenoh`?"));
        assert!(check_options(&toml::from_str("[zenoh]\nlisten = []").unwrap()).is_ok());
    }

    #[test]
    fn options_of_ros2_are_read_and_wrong_ones_are_named() {
        let table = |text: &str| text.parse::<toml::Table>().unwrap();
        let given = "domain = 7\nnetworks = [\"192.168.1.7\"]\ngreatest_sample = 4096\n[qos]\n\
                     depth = 4\n\
                     [masquerade]\n\"::demo::pose\" = \"geometry_msgs/msg/Pose\"\n";
        let options = read::<Ros2Options>(&table(given)).unwrap().over_environment().unwrap();
        assert_eq!((options.domain, options.qos.depth, options.qos.reliable), (7, 4, true));
        assert_eq!(options.networks, genom_ros2::Networks::Only(vec![[192, 168, 1, 7].into()]));
        let usual = genom_ros2::Limits::default();
        assert_eq!(options.limits, genom_ros2::Limits { sample: 4096, ..usual });
        assert_eq!(options.masquerade["::demo::pose"], "geometry_msgs/msg/Pose");
        let all = read::<Ros2Options>(&table("networks = \"all\"")).unwrap();
        assert_eq!(all.over_environment().unwrap().networks, genom_ros2::Networks::All);
        let error = read::<Ros2Options>(&table("domian = 7")).unwrap_err();
        assert!(error.contains("`domian`") && error.contains("`domain`"), "{error}");
    }

    #[test]
    fn options_of_zenoh_are_read_and_wrong_ones_are_named() {
        let table = |text: &str| text.parse::<toml::Table>().unwrap();
        let given = "mode = \"client\"\nconnect = [\"tcp/127.0.0.1:7447\"]\nrendezvous = \"\"\n\
                     [tls]\nauthority = \"/ca.pem\"\nmutual = true\n\
                     [set]\n\"transport/link/tx/queue/size/data\" = 4\n";
        let options = genom_zenoh::Options::from(read::<ZenohOptions>(&table(given)).unwrap());
        assert_eq!(options.mode, genom_zenoh::Mode::Client);
        assert_eq!(options.rendezvous, None);
        assert!(options.tls.mutual);
        assert_eq!(options.tls.authority, Some("/ca.pem".into()));
        assert_eq!(options.set, [("transport/link/tx/queue/size/data".into(), "4".into())]);
        let none = genom_zenoh::Options::from(read::<ZenohOptions>(&table("")).unwrap());
        assert_eq!(none, genom_zenoh::Options::default());
        let error = read::<ZenohOptions>(&table("lisen = []")).unwrap_err();
        assert!(error.contains("`lisen`") && error.contains("`listen`"), "{error}");
    }
}
