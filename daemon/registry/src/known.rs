//! The list of all middlewares: the only place that names them.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::PathBuf;
use std::sync::Arc;

use genom_middleware::{Backend, Middleware, NoForeignName};
use genom_nearest::{nearest, nearest_key};
use serde::Deserialize;

/// A middleware that this daemon was built with.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Its name, as given to `--backend`.
    pub name: &'static str,
    /// Version of the library that implements it.
    pub version: &'static str,
    /// Whether it can be opened in a process of its own.
    pub gateway: bool,
    /// Checks its section of the configuration, without opening anything.
    pub(crate) check: fn(&toml::Table) -> Result<(), SectionError>,
    /// Where it makes files, with its section of the configuration.
    pub(crate) places: fn(&toml::Table) -> Result<Vec<PathBuf>, SectionError>,
    /// Opens it with its section of the configuration.
    pub(crate) open: fn(&toml::Table) -> Result<Arc<dyn Middleware>, SectionError>,
}

impl Known {
    const fn of<B: Backend>() -> Self {
        Self {
            name: B::NAME,
            version: B::VERSION,
            gateway: B::GATEWAY,
            check: |section| B::check(&read(section)?).map_err(SectionError::refused),
            places: |section| Ok(B::places(&read(section)?)),
            open: |section| B::open(read(section)?).map_err(SectionError::refused),
        }
    }
}

macro_rules! backends {
    ($($name:ident: $backend:ty),+ $(,)?) => {
        static KNOWN: &[Known] = &[$(Known::of::<$backend>()),+];

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

/// The middlewares this daemon was built with.
pub fn known() -> &'static [Known] {
    KNOWN
}

/// Directories in which middlewares make files on this machine, with these sections of the
/// configuration.
pub fn places(sections: &BTreeMap<String, toml::Table>) -> Vec<PathBuf> {
    let none = toml::Table::new();
    let of = |known: &Known| (known.places)(sections.get(known.name).unwrap_or(&none));
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
    #[error("unknown backend `{name}`{}. This daemon knows: {}", meant(.name), names())]
    Unknown { name: String },
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
        (check(name)?.check)(section).map_err(wrong)?;
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
}
