//! The list of all middlewares: the only place that names them.

use std::collections::BTreeMap;
use std::fmt::{self, Display};
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};

use genom_middleware::{Backend, Middleware, NoForeignName};
use genom_nearest::{nearest, nearest_key};
use genom_plugin_host::{Library, LibraryError};
use serde::Deserialize;

/// A middleware that this daemon was built with, or found in a library.
#[derive(Clone, Copy)]
pub struct Known {
    /// Its name, as given to `--backend`.
    pub name: &'static str,
    /// Version of the library that implements it.
    pub version: &'static str,
    /// Whether it can be opened in a process of its own.
    pub gateway: bool,
    source: Source,
}

/// Where a middleware is.
#[derive(Clone, Copy)]
enum Source {
    BuiltIn {
        check: fn(&toml::Table) -> Result<(), SectionError>,
        places: fn(&toml::Table) -> Result<Vec<PathBuf>, SectionError>,
        open: fn(&toml::Table) -> Result<Arc<dyn Middleware>, SectionError>,
    },
    Plugin(&'static Library),
}

impl fmt::Debug for Known {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, version, .. } = self;
        write!(f, "Known({name}, {version})")
    }
}

impl Known {
    const fn of<B: Backend>() -> Self {
        let source = Source::BuiltIn {
            check: |section| B::check(&read(section)?).map_err(SectionError::refused),
            places: |section| Ok(B::places(&read(section)?)),
            open: |section| B::open(read(section)?).map_err(SectionError::refused),
        };
        Self { name: B::NAME, version: B::VERSION, gateway: B::GATEWAY, source }
    }

    pub(crate) fn plugin(library: &'static Library) -> Self {
        Self {
            name: library.name(),
            version: library.version(),
            gateway: library.wants_gateway(),
            source: Source::Plugin(library),
        }
    }

    /// Where the library is that it was found in, if it is not part of this daemon.
    #[must_use]
    pub fn library(&self) -> Option<&'static Path> {
        match self.source {
            Source::BuiltIn { .. } => None,
            Source::Plugin(library) => Some(library.path()),
        }
    }

    /// Checks its section of the configuration, without opening anything. A plugin checks it when
    /// it is opened.
    pub(crate) fn check(&self, section: &toml::Table) -> Result<(), SectionError> {
        match self.source {
            Source::BuiltIn { check, .. } => check(section),
            Source::Plugin(_) => Ok(()),
        }
    }

    /// Where it makes files, with its section of the configuration.
    fn places(&self, section: &toml::Table) -> Result<Vec<PathBuf>, SectionError> {
        match self.source {
            Source::BuiltIn { places, .. } => places(section),
            Source::Plugin(_) => Ok(Vec::new()),
        }
    }

    /// Opens it with its section of the configuration.
    pub(crate) fn open(&self, section: &toml::Table) -> Result<Arc<dyn Middleware>, SectionError> {
        match self.source {
            Source::BuiltIn { open, .. } => open(section),
            Source::Plugin(library) => {
                let options = options(section)?;
                library.middleware(&options).map_err(SectionError::refused)
            }
        }
    }
}

macro_rules! backends {
    ($($name:ident: $backend:ty),+ $(,)?) => {
        /// The middlewares that are part of this daemon.
        pub(crate) static BUILT_IN: &[Known] = &[$(Known::of::<$backend>()),+];

        #[derive(Debug, Default, Deserialize)]
        #[serde(default)]
        #[allow(dead_code, reason = "read to see that they can be")]
        struct EachSection {
            $($name: Option<<$backend as Backend>::Options>,)+
        }
    };
}

// The list of all middlewares, by name; adding one means adding a line here.
backends! {
    local: genom_local::Local,
    shm: genom_shm::Shm,
    zenoh: genom_zenoh::Zenoh,
    ros2: genom_ros2::Ros2,
}

/// The key of `[backends.NAME]` that says where its library is.
pub const LIBRARY: &str = "library";

/// Those that are part of this daemon, and those that were added. Replaced as a whole, and never
/// freed: each library is added once.
static ALL: RwLock<&'static [Known]> = RwLock::new(&[]);

/// The middlewares this daemon was built with, and those of libraries that were named when it
/// started.
pub fn known() -> &'static [Known] {
    match *ALL.read().unwrap_or_else(PoisonError::into_inner) {
        [] => BUILT_IN,
        all => all,
    }
}

/// Adds that of a library, unless it is there already.
pub(crate) fn add(library: &'static Library) -> Result<Known, BackendError> {
    let new = Known::plugin(library);
    let mut all = ALL.write().unwrap_or_else(PoisonError::into_inner);
    let before = if all.is_empty() { BUILT_IN } else { *all };
    if let Some(known) = before.iter().find(|known| known.name == new.name) {
        if known.library() == new.library() {
            return Ok(*known);
        }
        let (path, name) = (library.path().to_owned(), new.name.to_owned());
        let other = known.library().map(|library| library.display().to_string());
        let other = other.unwrap_or_else(|| "one of its own".to_owned());
        return Err(BackendError::NameTaken { path, name, other });
    }
    *all = Box::leak([before, &[new]].concat().into_boxed_slice());
    Ok(new)
}

/// The options of a plugin: its section without the key that is not its own.
fn options(section: &toml::Table) -> Result<String, SectionError> {
    let mut section = section.clone();
    section.remove(LIBRARY);
    serde_json::to_string(&section).map_err(SectionError::refused)
}

/// Directories in which middlewares make files on this machine, with these sections of the
/// configuration.
pub fn places(sections: &BTreeMap<String, toml::Table>) -> Vec<PathBuf> {
    let none = toml::Table::new();
    let of = |known: &Known| known.places(sections.get(known.name).unwrap_or(&none));
    // A section that cannot be read is reported when the configuration is checked.
    known().iter().filter_map(|known| of(known).ok()).flatten().collect()
}

/// The sections `[backends.NAME]` of a configuration file, typed as each middleware reads them:
/// deserialising them reports mistakes with their line.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Sections {
    #[allow(dead_code, reason = "read to see that it can be")]
    backends: EachSection,
}

fn read<T: serde::de::DeserializeOwned>(options: &toml::Table) -> Result<T, SectionError> {
    options.clone().try_into().map_err(|error: toml::de::Error| {
        let message = error.message().to_owned();
        SectionError::Unreadable { nearest: nearest_key(&message), message }
    })
}

/// Why a backend cannot be opened with its section of the configuration.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum SectionError {
    /// There is an unknown key, or a value of the wrong type.
    #[error("{message}{}", suggestion(.nearest.as_deref()))]
    Unreadable { message: String, nearest: Option<String> },
    /// The message of the backend, whose error type is not known here.
    #[error("{0}")]
    Refused(String),
}

impl SectionError {
    pub(crate) fn refused(error: impl Display) -> Self {
        Self::Refused(error.to_string())
    }
}

fn suggestion(nearest: Option<&str>) -> String {
    nearest.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default()
}

/// A middleware cannot be used.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum BackendError {
    /// There is no middleware of that name.
    #[error("unknown backend `{name}`{}. This daemon knows: {}{}", meant(.name), names(), named(.name))]
    Unknown { name: String },
    /// There is a library under its name, or it was named, and it is no middleware.
    #[error("no backend `{name}`: {why}")]
    Library { name: String, why: LibraryError },
    /// The library has another middleware than its name says, or than it was named for.
    #[error("{path} has a middleware named `{found}`, not `{name}`: write `{found}`, or rename it")]
    OtherName { path: PathBuf, found: String, name: String },
    /// The library has a name that is taken.
    #[error("{path} has a middleware named `{name}`, and this daemon has one already: {other}")]
    NameTaken { path: PathBuf, name: String, other: String },
    /// Its section of the configuration is not valid.
    #[error("[backends.{name}]: {why}")]
    Options { name: String, why: SectionError },
    /// It cannot be opened on this machine.
    #[error("backend {name} cannot be opened: {why}")]
    Closed { name: String, why: SectionError },
    /// It cannot be opened in a process of its own.
    #[error("{name} has no gateway: gateways are for {}", with_gateway())]
    NoGateway { name: String },
    /// A foreign type that a description names is not valid.
    #[error("#pragma masquerade: {0}")]
    Masquerade(#[from] NoForeignName),
}

fn meant(name: &str) -> String {
    nearest(name, known().iter().map(|known| known.name))
        .map(|near| format!(" (did you mean `{near}`?)"))
        .unwrap_or_default()
}

/// What to do about a library, which a daemon opens only when it is named at its start.
fn named(name: &str) -> &'static str {
    match name.contains('/') || name.ends_with(".so") {
        true => {
            ". A library is named when a daemon starts: `genomd --backend PATH`, or `library` in \
             [backends.NAME]"
        }
        false => "",
    }
}

fn names() -> String {
    known().iter().map(|known| known.name).collect::<Vec<_>>().join(", ")
}

fn with_gateway() -> String {
    let names = known().iter().filter(|known| known.gateway).map(|known| known.name);
    names.collect::<Vec<_>>().join(" and ")
}

/// Fails if no middleware has that name, or it cannot be opened in a process of its own.
pub fn check_gateway(name: &str) -> Result<(), BackendError> {
    match check(name)?.gateway {
        true => Ok(()),
        false => Err(BackendError::NoGateway { name: name.to_owned() }),
    }
}

/// Fails if no middleware has that name.
pub fn check(name: &str) -> Result<Known, BackendError> {
    known()
        .iter()
        .find(|known| known.name == name)
        .copied()
        .ok_or_else(|| BackendError::Unknown { name: name.to_owned() })
}

/// Checks the sections of the configuration, also those of middlewares not in use yet: a component
/// may move to them while it runs.
pub fn check_options(options: &BTreeMap<String, toml::Table>) -> Result<(), BackendError> {
    for (name, section) in options {
        let wrong = |why| BackendError::Options { name: name.clone(), why };
        check(name)?.check(section).map_err(wrong)?;
    }
    Ok(())
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
    fn a_middleware_of_this_machine_alone_has_no_gateway() {
        assert!(check_gateway("ros2").is_ok());
        let told = check_gateway("shm").unwrap_err().to_string();
        assert_eq!(told, "shm has no gateway: gateways are for zenoh and ros2");
        assert!(check_gateway("zneoh").unwrap_err().to_string().contains("did you mean `zenoh`"));
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
        assert_eq!(
            told("[ros2]\ndomain = 300").to_string(),
            "[backends.ros2]: domain = 300: a domain is a number from 0 to 232"
        );
        assert!(told("[zenho]").to_string().contains("did you mean `zenoh`?"));
        assert!(check_options(&toml::from_str("[zenoh]\nlisten = []").unwrap()).is_ok());
    }

    #[test]
    fn each_section_is_read_by_the_backend_of_its_name() {
        for (name, known) in ["local", "shm", "zenoh", "ros2"].iter().zip(known()) {
            assert_eq!(*name, known.name);
            let wrong = format!("[backends.{name}]\nno_such_key = 1");
            let error = toml::from_str::<Sections>(&wrong).unwrap_err().to_string();
            assert!(error.contains("unknown field `no_such_key`"), "{error}");
            assert!(check_options(&[((*name).to_owned(), toml::Table::new())].into()).is_ok());
        }
    }

    #[test]
    fn options_of_a_plugin_are_its_section_in_json() {
        let section: toml::Table =
            toml::from_str("library = 'x'\nport = 7\nhosts = ['a']").unwrap();
        assert_eq!(options(&section).unwrap(), r#"{"hosts":["a"],"port":7}"#);
    }
}
