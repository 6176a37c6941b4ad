//! The middlewares in use: each opened when first needed, and open from then on.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Instant;

use genom_middleware::Middleware;

use crate::known::{BackendError, check};

/// What is to be shown as what, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Disguise {
    /// The middleware.
    pub(crate) on: &'static str,
    /// Full IDL name of the type or service.
    pub(crate) ours: String,
    pub(crate) foreign: String,
}

/// The middlewares in use. Each is opened when first needed, and stays open.
pub struct Backends {
    /// Their sections of the configuration, by name.
    options: BTreeMap<String, toml::Table>,
    pub(crate) open: Mutex<Open>,
    /// Told of each when it opens.
    opens: OnceLock<Box<OnOpen>>,
    /// What descriptions say is to be shown as something foreign, the first of several that differ
    /// before the others; with how many hold it.
    masquerades: Mutex<Vec<(Disguise, usize)>>,
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
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((middleware, _)) = open.get(name) {
            return Ok(Arc::clone(middleware));
        }
        let known = check(name)?;
        let middleware = (known.open)(self.options.get(known.name).unwrap_or(&toml::Table::new()))
            .map_err(|why| BackendError::Closed { name: name.to_owned(), why })?;
        open.insert(known.name, (Arc::clone(&middleware), Instant::now()));
        let masquerades = self.masquerades();
        for (one, _) in masquerades.iter().filter(|(one, _)| one.on == known.name) {
            middleware.masquerade(&one.ours, &one.foreign)?;
        }
        drop(masquerades);
        drop(open);
        if let Some(told) = self.opens.get() {
            told(middleware.as_ref());
        }
        Ok(middleware)
    }

    /// Adds one that the program brings itself, open, under the name that it has.
    pub fn add(&self, middleware: Arc<dyn Middleware>) {
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        open.insert(middleware.name(), (middleware, Instant::now()));
    }

    pub(crate) fn masquerades(&self) -> MutexGuard<'_, Vec<(Disguise, usize)>> {
        self.masquerades.lock().unwrap_or_else(PoisonError::into_inner)
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
