//! A supervisor of components: what its parts share, and its end.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use genom_configuration::ClockKind;
use genom_ports::dates::Dates;
use genom_registry::Backends;
use genom_runtime::{Clock, VirtualClock};

use crate::bus::{Bus, Change};
use crate::components::{Components, Hosted, UnloadError};
use crate::connections::{self, Connections, Opening};
use crate::flag::Flag;
use crate::known::Known;
use crate::recording::{Recordings, Session};
use crate::settings::Settings;
use crate::vigil;

/// Runs components. It may be shared by any number of threads.
pub struct Supervisor {
    /// What holds for all components.
    pub settings: Settings,
    /// The middlewares in use.
    pub backends: Arc<Backends>,
    /// Descriptions and libraries that were read and compared already.
    pub known: Known,
    /// The components that run, or are about to.
    pub components: Arc<Components>,
    /// Time of all components: they live in one world.
    pub clock: Clock,
    /// Where changes are told.
    pub bus: Arc<Bus>,
    /// The recordings under way.
    pub recordings: Arc<Recordings>,
    /// Their connections.
    pub connections: Connections,
    /// Held while a deployment is applied: one at a time.
    deploying: Mutex<()>,
    /// Somebody asked to stop: nothing is loaded any more.
    stop: Flag,
    /// When that was.
    stop_asked: OnceLock<Instant>,
    /// Somebody asked again: what hangs is left behind.
    pub forced: Flag,
    /// Everything stopped: streams and connections end.
    pub closed: Flag,
}

impl Supervisor {
    /// A supervisor without components.
    pub fn new(settings: Settings) -> Arc<Self> {
        let clock = match settings.clock {
            ClockKind::Monotonic => Clock::Monotonic,
            ClockKind::Virtual => Clock::Virtual(Arc::new(VirtualClock::new())),
        };
        let dates = Dates::of(&clock);
        let backends = Arc::new(Backends::new(settings.backends.clone()));
        let components = Arc::new(Components::default());
        let bus = Arc::new(Bus::new(dates.clone()));
        let recordings = Arc::new(Recordings::new(dates));
        let opening = Opening {
            backends: Arc::clone(&backends),
            recordings: Arc::clone(&recordings),
            clock: clock.clone(),
        };
        let offers = settings.offers.clone();
        let connections = Connections::new(&components, &bus, opening, offers);
        Arc::new(Self {
            backends,
            known: Known::default(),
            components,
            connections,
            clock,
            bus,
            recordings,
            deploying: Mutex::default(),
            stop: Flag::new(),
            stop_asked: OnceLock::new(),
            forced: Flag::new(),
            closed: Flag::new(),
            settings,
        })
    }

    /// Looks after connections and after codels that do not return, until it stops.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn watch(&self) -> std::io::Result<()> {
        connections::watch(self.connections.clone(), self.stop.clone())?;
        let (components, bus) = (Arc::clone(&self.components), Arc::clone(&self.bus));
        vigil::watch(components, bus, self.closed.clone())
    }

    /// Tells that a component runs, and records what it has.
    pub fn runs(&self, hosted: &Hosted) {
        hosted.record();
        let backend = hosted.ties.bindings.component();
        tracing::info!(instance = hosted.name, "runs on {backend}");
        self.bus.tell(&Change::ComponentLoaded {
            component: hosted.name.clone(),
            backend: backend.to_string(),
        });
    }

    /// Starts a recording of these ports and components, of all when there are none; samples
    /// are taken from now on. Blocks while codels are excluded.
    pub fn record(&self, wanted: Vec<String>) -> Arc<Session> {
        let session = self.recordings.start(wanted);
        self.components.all().iter().for_each(|hosted| hosted.record());
        session
    }

    /// A recording is over: nothing is taken for it any more. Blocks while codels are excluded.
    pub fn recording_ended(&self, session: &Session) {
        self.recordings.forget(session);
        self.components.all().iter().for_each(|hosted| hosted.recording_ended(session.number));
    }

    /// Stops a component and closes its library. Blocks until its codels have ended.
    pub fn unload(&self, name: &str) -> Result<(), UnloadError> {
        self.unload_these(&[name.to_owned()]).pop().map_or(Ok(()), |(_, error)| Err(error))
    }

    /// Stops components side by side, given in the order they were loaded; those that could not
    /// be stopped. Blocks.
    pub fn unload_these(&self, names: &[String]) -> Vec<(String, UnloadError)> {
        let failed = Mutex::new(Vec::new());
        self.components.remove(names, self.settings.stop_timeout, &|name, stopped| {
            let component = name.to_owned();
            match stopped {
                Ok(()) => {
                    tracing::info!(instance = name, "unloaded");
                    self.bus.tell(&Change::ComponentUnloaded { component });
                }
                Err(error) => {
                    if let UnloadError::Stuck { why, .. } = error {
                        self.bus.tell(&Change::ComponentLeft { component, why: why.to_string() });
                    }
                    let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                    failed.push((name.to_owned(), error.clone()));
                }
            }
        });
        failed.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for the deployment under way, if there is one.
    pub fn deploying(&self) -> MutexGuard<'_, ()> {
        self.deploying.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Unloads everything; those that could not be stopped.
    pub fn unload_all(&self) -> Vec<(String, UnloadError)> {
        let all = self.components.all();
        let names: Vec<String> = all.iter().map(|hosted| hosted.name.clone()).collect();
        // Nobody but the threads that stop it holds a component.
        drop(all);
        self.unload_these(&names)
    }

    /// Asks for the end; asking again changes nothing.
    pub fn ask_to_stop(&self, why: &str) {
        self.stop_asked.get_or_init(Instant::now);
        if self.stop.raise() {
            tracing::info!("stopping: {why}");
            self.bus.tell(&Change::Stopping {});
        }
    }

    /// How long ago the end was asked for.
    pub fn stopping_for(&self) -> Option<Duration> {
        self.stop_asked.get().map(Instant::elapsed)
    }

    /// Whether a start codel had its time since the end was asked for: nothing waits for it then.
    pub fn start_is_given_up(&self) -> bool {
        self.stopping_for().is_some_and(|time| time >= self.settings.stop_timeout)
    }

    /// Whether the end was asked for.
    pub fn stopping(&self) -> bool {
        self.stop.is_up()
    }

    /// Waits until the end is asked for.
    pub async fn asked_to_stop(&self) {
        self.stop.raised().await;
    }
}

impl Drop for Supervisor {
    /// Nobody asked for its end: what watches it ends all the same.
    fn drop(&mut self) {
        self.stop.raise();
        self.closed.raise();
    }
}
