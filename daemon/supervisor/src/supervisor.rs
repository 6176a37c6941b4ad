//! The supervisor: the state its parts share, and how it stops.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::Thread;
use std::time::{Duration, Instant};

use genom_blackbox::Memory;
use genom_bus::withheld::Withheld;
use genom_configuration::{BlackBoxSection, ClockKind, ExecutionKind};
use genom_ports::dates::Dates;
use genom_protocol::RecordingRequest;
use genom_protocol::frames::Channel;
use genom_registry::Backends;
use genom_runtime::{Clock, Execution, Executor, VirtualClock};

use crate::components::{Components, Hosted, UnloadError};
use crate::connections::{self, Connections, Opening};
use crate::reactor::Reactions;
use crate::recording::{Apart, BlackBox, Recordings, Session, Watch, heads};
use crate::settings::Settings;
use crate::vigil;
use genom_bus::flag::Flag;
use genom_bus::{Bus, Change};
use genom_finder::Known;

/// Runs components. It can be shared between threads.
pub struct Supervisor {
    /// Settings that apply to all components.
    pub settings: Settings,
    /// The middlewares in use.
    pub backends: Arc<Backends>,
    /// Descriptions and libraries that were read and checked already.
    pub known: Known,
    /// The components that are running or being loaded.
    pub components: Arc<Components>,
    /// The clock of all components.
    pub clock: Clock,
    /// Which threads execute the components.
    pub execution: Execution,
    /// What broken rules of supervision ask for.
    pub reactions: Arc<Reactions>,
    /// Signs of life that the service manager does not get.
    pub withheld: Arc<Withheld>,
    /// The thread that watches codels.
    vigil: OnceLock<Thread>,
    /// Where changes are reported.
    pub bus: Arc<Bus>,
    /// The running recordings.
    pub recordings: Arc<Recordings>,
    /// The connections of the components.
    pub connections: Connections,
    /// Locked while a deployment is applied, so that only one is at a time.
    deploying: Mutex<()>,
    /// Raised when somebody asked it to stop: nothing is loaded any more.
    stop: Flag,
    /// When that was.
    stop_asked: OnceLock<Instant>,
    /// Raised when somebody asked again: components that do not stop are left behind at once.
    pub forced: Flag,
    /// Raised when everything has stopped, to end streams and connections.
    pub closed: Flag,
}

impl Supervisor {
    /// A supervisor without components.
    pub fn new(settings: Settings) -> Arc<Self> {
        let clock = match settings.clock {
            ClockKind::Monotonic => Clock::Monotonic,
            ClockKind::Virtual | ClockKind::Ros => Clock::Virtual(Arc::new(VirtualClock::new())),
        };
        let execution = match settings.execution {
            ExecutionKind::Threads => Execution::Threads,
            ExecutionKind::Single => Execution::Single(Arc::new(Executor::new("genomd-tasks"))),
        };
        let dates = Dates::of(&clock);
        let backends = Backends::new(settings.backends.clone()).simulated(settings.simulated);
        let backends = Arc::new(backends.through(settings.gateways.clone()));
        let components = Arc::new(Components::default());
        let bus = Arc::new(Bus::new(dates.clone()));
        let recordings = Arc::new(Recordings::new(dates));
        let opening = Opening {
            backends: Arc::clone(&backends),
            recordings: Arc::clone(&recordings),
            clock: clock.clone(),
            needs: Arc::default(),
        };
        let offers = settings.offers.clone();
        let connections = Connections::new(&components, &bus, opening, offers);
        Arc::new(Self {
            backends,
            known: Known::default(),
            components,
            connections,
            clock,
            execution,
            bus,
            reactions: Arc::default(),
            withheld: Arc::default(),
            vigil: OnceLock::new(),
            recordings,
            deploying: Mutex::default(),
            stop: Flag::new(),
            stop_asked: OnceLock::new(),
            forced: Flag::new(),
            closed: Flag::new(),
            settings,
        })
    }

    /// Starts the threads that keep connections up and report codels that do not return.
    ///
    /// # Errors
    /// The system cannot create a thread.
    pub fn watch(&self) -> std::io::Result<()> {
        connections::watch(self.connections.clone(), self.stop.clone())?;
        let (components, bus) = (Arc::clone(&self.components), Arc::clone(&self.bus));
        let thread = vigil::watch(components, bus, self.closed.clone())?;
        let _ = self.vigil.set(thread);
        Ok(())
    }

    /// Rounds so far of the thread that all components share; `None` if they share none.
    pub fn shared_rounds(&self) -> Option<u64> {
        match &self.execution {
            Execution::Threads => None,
            Execution::Single(executor) => executor.rounds(),
        }
    }

    /// Asks the thread that all components share for another round.
    pub fn wake_shared(&self) {
        if let Execution::Single(executor) = &self.execution {
            executor.wake();
        }
    }

    /// Reports that a component is running, and attaches running recordings.
    pub fn runs(&self, hosted: &Hosted) {
        hosted.record();
        let backend = hosted.ties.bindings.component();
        if let Some(vigil) =
            self.vigil.get().filter(|_| !hosted.build().request.supervision.is_empty())
        {
            // It looks as often as these rules need.
            vigil.unpark();
        }
        tracing::info!(instance = hosted.name, "runs on {backend}");
        self.bus.tell(&Change::ComponentLoaded {
            component: hosted.name.clone(),
            backend: backend.to_string(),
        });
    }

    /// Keeps what happens from now on in this memory, as `section` says. To be called once, before
    /// components are loaded.
    ///
    /// # Errors
    /// The memory cannot be mapped.
    pub fn keep_in(&self, memory: &Memory, section: &BlackBoxSection) -> std::io::Result<()> {
        self.recordings.keep(BlackBox::begin(memory, section, &self.bus)?);
        Ok(())
    }

    /// Starts a recording of these components and ports, or of everything if `wanted` is empty.
    /// Samples are taken from now on, but not the changes of processes that record theirs themselves.
    /// Blocks while codels are excluded.
    pub fn record(&self, wanted: RecordingRequest, apart: Arc<Apart>) -> Arc<Session> {
        let session = self.recordings.start(wanted, apart);
        self.components.all().iter().for_each(|hosted| hosted.record());
        session
    }

    /// The channels that a recording of everything would have if it began now.
    #[must_use]
    pub fn channels(&self) -> Vec<Channel> {
        let mut all = heads::of_events();
        all.extend(self.components.all().iter().flat_map(|hosted| hosted.channels()));
        for (number, channel) in (0..).zip(&mut all) {
            channel.channel = number;
        }
        all
    }

    /// Detaches a recording that ended. Blocks while codels are excluded.
    pub fn recording_ended(&self, session: &Session) {
        self.recordings.forget(session);
        self.components.all().iter().for_each(|hosted| hosted.recording_ended(session.number));
    }

    /// Takes every sample of these ports of a component, given by their addresses, from now on.
    /// Blocks while its codels are excluded.
    pub fn watch_ports(&self, hosted: &Hosted, ports: Vec<String>) -> Watch {
        let watch = self.recordings.watch(ports);
        hosted.watch(&watch);
        watch
    }

    /// Ends a watch. Blocks while codels of that component are excluded.
    pub fn unwatch_ports(&self, watch: &Watch, component: &str) {
        self.recordings.unwatch(watch);
        // Also those of one that took its place.
        let all = self.components.all();
        let named = all.iter().filter(|hosted| hosted.name == component);
        named.for_each(|hosted| hosted.recording_ended(watch.number()));
    }

    /// Stops a component and closes its library. Blocks until its codels have ended.
    pub fn unload(&self, name: &str) -> Result<(), UnloadError> {
        self.unload_these(&[name.to_owned()]).pop().map_or(Ok(()), |(_, error)| Err(error))
    }

    /// Stops components in parallel; `names` are in the order of loading. Returns those that could
    /// not be stopped. Blocks.
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

    /// Locks out deployments; waits for the one being applied, if any.
    pub fn deploying(&self) -> MutexGuard<'_, ()> {
        self.deploying.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Unloads all components. Returns those that could not be stopped.
    pub fn unload_all(&self) -> Vec<(String, UnloadError)> {
        let all = self.components.all();
        let names: Vec<String> = all.iter().map(|hosted| hosted.name.clone()).collect();
        // From here on only the threads that stop a component hold it.
        drop(all);
        self.unload_these(&names)
    }

    /// Asks the supervisor to stop. Further calls change nothing.
    pub fn ask_to_stop(&self, why: &str) {
        self.stop_asked.get_or_init(Instant::now);
        if self.stop.raise() {
            tracing::info!("stopping: {why}");
            self.bus.tell(&Change::Stopping {});
        }
    }

    /// How long ago it was asked to stop.
    pub fn stopping_for(&self) -> Option<Duration> {
        self.stop_asked.get().map(Instant::elapsed)
    }

    /// Whether a start codel has had its full timeout since the supervisor was asked to stop. If
    /// so, nobody waits for it any more.
    pub fn start_is_given_up(&self) -> bool {
        self.stopping_for().is_some_and(|time| time >= self.settings.stop_timeout)
    }

    /// Whether it was asked to stop.
    pub fn stopping(&self) -> bool {
        self.stop.is_up()
    }

    /// Waits until it is asked to stop.
    pub async fn asked_to_stop(&self) {
        self.stop.raised().await;
    }
}

impl Drop for Supervisor {
    /// Ends the watching threads even if nobody asked it to stop.
    fn drop(&mut self) {
        self.stop.raise();
        self.closed.raise();
    }
}
