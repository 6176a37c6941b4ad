//! The middlewares a daemon is built with: the one place that knows which there are.
//!
//! It reads the options of each, opens one when it is first needed, and keeps it open.

#![forbid(unsafe_code)]

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;

use genom_middleware::{Backend, Middleware};
use genom_nearest::{nearest, nearest_key};
use serde::Deserialize;

/// A middleware this daemon was built with.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// What `--backend` calls it.
    pub name: &'static str,
    /// Version of the library behind it.
    pub version: &'static str,
    /// Refuses a section of the configuration that makes no sense, and opens nothing.
    check: fn(&toml::Table) -> Result<(), String>,
    /// Opens it with its section of the configuration.
    open: fn(&toml::Table) -> Result<Arc<dyn Middleware>, String>,
}

impl Known {
    const fn of<B: Backend>() -> Self {
        Self {
            name: B::NAME,
            version: B::VERSION,
            check: |section| B::check(&read(section)?).map_err(|error| error.to_string()),
            open: |section| B::open(read(section)?).map_err(|error| error.to_string()),
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

// Every middleware there is, by its name; adding one means adding a line here.
backends! {
    local: genom_local::Local,
    shm: genom_shm::Shm,
    zenoh: genom_zenoh::Zenoh,
    ros2: genom_ros2::Ros2,
}

/// Every middleware there is.
pub fn known() -> &'static [Known] {
    KNOWN
}

/// The sections of a configuration file that middlewares read: for a look at them beforehand,
/// while the file's lines are known.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Sections {
    #[allow(dead_code, reason = "read to see that it can be")]
    backends: EachSection,
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
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum BackendError {
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
pub fn check(name: &str) -> Result<Known, BackendError> {
    known()
        .iter()
        .find(|known| known.name == name)
        .copied()
        .ok_or_else(|| BackendError::Unknown { name: name.to_owned() })
}

/// Refuses sections of the configuration that no middleware reads, also of those that are not in
/// use: a component may move there while it runs.
pub fn check_options(options: &BTreeMap<String, toml::Table>) -> Result<(), BackendError> {
    for (name, section) in options {
        let wrong = |why| BackendError::Options { name: name.clone(), why };
        (check(name)?.check)(section).map_err(wrong)?;
    }
    Ok(())
}

/// The middlewares in use. Each is opened when first needed, and stays open.
pub struct Backends {
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
    pub fn new(options: BTreeMap<String, toml::Table>) -> Self {
        Self {
            options,
            open: Mutex::default(),
            opens: OnceLock::new(),
            masquerades: Mutex::default(),
        }
    }

    /// Has `told` called with each middleware when it opens; once, before the first does.
    pub fn on_open(&self, told: impl Fn(&dyn Middleware) + Send + Sync + 'static) {
        let _ = self.opens.set(Box::new(told));
    }

    /// The middleware of that name, open.
    pub fn get(&self, name: &str) -> Result<Arc<dyn Middleware>, BackendError> {
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
    pub fn masquerade(&self, on: &str, ours: &str, foreign: &str) -> Result<(), BackendError> {
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
    pub fn close(&self) {
        self.open.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// The middleware of that name, if something already uses it.
    pub fn opened(&self, name: &str) -> Option<Arc<dyn Middleware>> {
        let open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        open.get(name).map(|(middleware, _)| Arc::clone(middleware))
    }

    /// Since when it is open.
    pub fn open_since(&self, name: &str) -> Option<Instant> {
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
