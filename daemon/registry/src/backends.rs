//! The middlewares in use. Each is opened when it is first needed, and stays open.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::Instant;

use genom_gateway::{Proxy, Reach};
use genom_middleware::Middleware;

use crate::known::{BackendError, Known, SectionError, check};

/// A type or service that a middleware shows under a foreign name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Disguise {
    /// Name of the middleware.
    pub(crate) on: &'static str,
    /// Full IDL name of the type or service.
    pub(crate) ours: String,
    pub(crate) foreign: String,
}

/// Middlewares that are opened in processes of their own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Gateways {
    /// Their names.
    pub of: Vec<String>,
    /// Where their processes are.
    pub reach: Reach,
}

impl Gateways {
    fn has(&self, name: &str) -> bool {
        self.of.iter().any(|one| one == name)
    }
}

/// The middlewares in use. Each is opened when first needed, and stays open.
pub struct Backends {
    /// Their sections of the configuration, by name.
    options: BTreeMap<String, toml::Table>,
    gateways: Option<Gateways>,
    /// Whether the time of components is that of a simulator.
    simulated: bool,
    pub(crate) open: Mutex<Open>,
    /// Locked while one is being opened, which may take long: others can be used meanwhile.
    opening: Mutex<()>,
    /// Why middlewares were not opened when they were needed last, by name.
    closed: Mutex<BTreeMap<&'static str, String>>,
    /// Called with each middleware when it opens.
    opens: RwLock<Vec<Box<OnOpen>>>,
    /// The foreign names that descriptions ask for, each with its number of holders. If several
    /// differ for one type, the first applies.
    masquerades: Mutex<Vec<(Disguise, usize)>>,
}

/// The open middlewares, by name, and when each was opened.
type Open = BTreeMap<&'static str, (Arc<dyn Middleware>, Instant)>;

type OnOpen = dyn Fn(&Arc<dyn Middleware>) + Send + Sync;

impl Backends {
    /// No middleware is open at first. `options` are the sections `[backends.NAME]` of the
    /// configuration.
    pub fn new(options: BTreeMap<String, toml::Table>) -> Self {
        Self {
            options,
            gateways: None,
            simulated: false,
            open: Mutex::default(),
            opening: Mutex::default(),
            closed: Mutex::default(),
            opens: RwLock::default(),
            masquerades: Mutex::default(),
        }
    }

    /// The same, with some of them in processes of their own.
    #[must_use]
    pub fn through(self, gateways: Option<Gateways>) -> Self {
        Self { gateways, ..self }
    }

    /// The same, with components whose time is that of a simulator, or not.
    #[must_use]
    pub fn simulated(self, simulated: bool) -> Self {
        Self { simulated, ..self }
    }

    fn make(&self, known: &Known) -> Result<Arc<dyn Middleware>, SectionError> {
        if let Some(Gateways { reach, .. }) =
            self.gateways.as_ref().filter(|all| all.has(known.name))
        {
            let proxy = Proxy::open(known.name, reach.clone()).map_err(SectionError::refused)?;
            return Ok(Arc::new(proxy));
        }
        known.open(self.options.get(known.name).unwrap_or(&toml::Table::new()))
    }

    /// Whether the middleware of that name is opened in a process of its own.
    pub fn is_gateway(&self, name: &str) -> bool {
        self.gateways.as_ref().is_some_and(|all| all.has(name))
    }

    /// Has a function called with each middleware that opens from now on.
    pub fn on_open(&self, told: impl Fn(&Arc<dyn Middleware>) + Send + Sync + 'static) {
        let mut opens = self.opens.write().unwrap_or_else(PoisonError::into_inner);
        opens.push(Box::new(told));
    }

    /// The middleware of that name; opens it if needed, and blocks as long as that takes.
    pub fn get(&self, name: &str) -> Result<Arc<dyn Middleware>, BackendError> {
        if let Some(middleware) = self.opened(name) {
            return Ok(middleware);
        }
        let turn = self.opening.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(middleware) = self.opened(name) {
            return Ok(middleware);
        }
        let known = check(name)?;
        let middleware = self.make(&known).map_err(|why| {
            self.failures().insert(known.name, why.to_string());
            BackendError::Closed { name: name.to_owned(), why }
        })?;
        self.failures().remove(known.name);
        if self.simulated {
            middleware.simulated_time();
        }
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        open.insert(known.name, (Arc::clone(&middleware), Instant::now()));
        let masquerades = self.masquerades();
        for (one, _) in masquerades.iter().filter(|(one, _)| one.on == known.name) {
            middleware.masquerade(&one.ours, &one.foreign)?;
        }
        drop(masquerades);
        drop((open, turn));
        let opens = self.opens.read().unwrap_or_else(PoisonError::into_inner);
        opens.iter().for_each(|told| told(&middleware));
        Ok(middleware)
    }

    fn failures(&self) -> MutexGuard<'_, BTreeMap<&'static str, String>> {
        self.closed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Why the middleware of that name was not opened when it was needed last, unless it is open
    /// now or was never needed.
    pub fn closed(&self, name: &str) -> Option<String> {
        self.failures().get(name).cloned()
    }

    /// Adds an open middleware that the program provides itself, under that middleware's own name.
    pub fn add(&self, middleware: Arc<dyn Middleware>) {
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        open.insert(middleware.name(), (middleware, Instant::now()));
    }

    pub(crate) fn masquerades(&self) -> MutexGuard<'_, Vec<(Disguise, usize)>> {
        self.masquerades.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Releases all middlewares: each closes when its last user has released it, too.
    pub fn close(&self) {
        self.open.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// The middleware of that name if it is open already.
    pub fn opened(&self, name: &str) -> Option<Arc<dyn Middleware>> {
        let open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        open.get(name).map(|(middleware, _)| Arc::clone(middleware))
    }

    /// When the middleware of that name was opened.
    pub fn open_since(&self, name: &str) -> Option<Instant> {
        let open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        open.get(name).map(|(_, since)| *since)
    }
}
