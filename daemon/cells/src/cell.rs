//! One cell: its process, from start to end and to the next start.

mod again;
mod failing;
mod fall;
mod hearing;
mod reached;
mod standing;
mod supervised;

use std::os::fd::OwnedFd;
use std::pin::pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use genom_configuration::Deployment;
use genom_protocol::routes;
use genom_protocol::{CellState, Change, ReadyParameters};
use rustix::process::Signal;
use tokio::sync::watch;
use tokio::time::{sleep, timeout};

use self::fall::Fall;
use crate::client::Client;
use crate::crashes::{Dump, Known, learn};
use crate::done::Waiting;
use crate::end::End;
use crate::journal::{self, Journal};
use crate::place::Place;
use crate::policy::{Limit, Restarts};
use crate::process::{Gets, Process};
use crate::program::refusal;
use crate::setup::{Setup, Told};

/// Between two tries to reach a process that is starting, or to see what became of one.
const LOOK_AGAIN: Duration = Duration::from_millis(2);

/// How long the end of a process may be behind the end of its connections.
const NOTICE: Duration = Duration::from_millis(500);

/// A cell of this daemon.
pub struct Cell {
    name: String,
    place: Place,
    client: Client,
    setup: Arc<Setup>,
    journal: Journal,
    state: Mutex<State>,
    /// For the report of its crash.
    known: Mutex<Known>,
    phase: watch::Sender<CellState>,
    order: watch::Sender<Order>,
    /// Whether its life is over and its files are gone.
    over: watch::Sender<bool>,
    /// Held while components are loaded into it or taken out of it.
    changing: tokio::sync::Mutex<()>,
}

#[derive(Debug, Default)]
struct State {
    pid: Option<u32>,
    starts: u64,
    last_end: Option<String>,
    components: Vec<String>,
    /// Whether somebody asked for the end of its process.
    asked: bool,
    /// What was taken of its process when it crashed.
    dump: Dump,
    /// Where its process is stepped.
    steps: Option<Arc<OwnedFd>>,
    /// What its last process held: more than the next one, if something is not to come back.
    held: Deployment,
    /// Whether its last process ended though nobody had asked for that.
    fall: Fall,
    /// What is being done of other components since its process failed.
    reacting: Option<Waiting>,
    /// Broken rules that it told within this second.
    rules_told: Limit,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    /// Run, and start again when its policy says so.
    Run,
    /// End.
    Stop,
}

/// A cell that cannot be asked now.
#[derive(Clone, Debug, thiserror::Error)]
#[error("cell {cell} is {state}{}", .last_end.as_ref().map_or(String::new(), |end| format!(", its process ended: {end}")))]
pub struct Down {
    /// Its name.
    pub cell: String,
    /// How it is.
    pub state: CellState,
    /// How its last process ended.
    pub last_end: Option<String>,
}

impl std::fmt::Debug for Cell {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.told().fmt(f)
    }
}

impl Cell {
    /// A cell whose process is started, or found; it lives until somebody stops it.
    pub(crate) fn begin(
        name: &str,
        place: Place,
        setup: &Arc<Setup>,
        found: Option<Process>,
    ) -> Arc<Self> {
        let cell = Arc::new(Self {
            name: name.to_owned(),
            client: Client::new(&place.socket()),
            journal: Journal::new(place.journal()),
            place,
            setup: Arc::clone(setup),
            state: Mutex::default(),
            known: Mutex::default(),
            phase: watch::Sender::new(CellState::Starting),
            order: watch::Sender::new(Order::Run),
            over: watch::Sender::new(false),
            changing: tokio::sync::Mutex::default(),
        });
        tokio::spawn(Arc::clone(&cell).live(found));
        cell
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of its process, while it has one.
    pub(crate) fn pid(&self) -> Option<u32> {
        self.with(|state| state.pid)
    }

    /// What supervisors see of it.
    #[must_use]
    pub fn told(&self) -> genom_protocol::Cell {
        self.with(|state| genom_protocol::Cell {
            name: self.name.clone(),
            state: *self.phase.borrow(),
            pid: state.pid,
            components: state.components.clone(),
            starts: state.starts,
            last_end: state.last_end.clone(),
            socket: self.place.socket(),
        })
    }

    /// Whether it is a gateway.
    pub(crate) fn is_gateway(&self) -> bool {
        genom_gateway::middleware_of(&self.name).is_some()
    }

    /// Whether a component is in it, or is to be when it is back.
    #[must_use]
    pub fn holds(&self, component: &str) -> bool {
        self.with(|state| state.components.iter().any(|one| one == component))
    }

    pub(crate) fn client(&self) -> &Client {
        &self.client
    }

    pub(crate) fn setup(&self) -> &Setup {
        &self.setup
    }

    /// What its journal says that it holds: nothing where that is no journal, as for its next process.
    pub(crate) fn written(&self) -> Arc<Deployment> {
        self.journal.read().unwrap_or_default()
    }

    pub(crate) fn place(&self) -> &Place {
        &self.place
    }

    /// Whether its life is over.
    pub(crate) fn is_over(&self) -> bool {
        *self.over.borrow()
    }

    /// Waits until its life is over.
    pub(crate) async fn ended(&self) {
        let mut over = self.over.subscribe();
        let _ = over.wait_for(|over| *over).await;
    }

    /// Whether it is to hold nothing.
    pub(crate) fn is_empty(&self) -> bool {
        self.with(|state| state.components.is_empty())
    }

    pub(crate) async fn changing(&self) -> tokio::sync::MutexGuard<'_, ()> {
        self.changing.lock().await
    }

    /// Starts its process again, when it has none.
    pub(crate) fn start_again(&self) {
        self.phase.send_if_modified(|phase| {
            let down = matches!(phase, CellState::Failed | CellState::Waiting);
            if down {
                *phase = CellState::Starting;
            }
            down
        });
        self.order.send_if_modified(|order| *order == Order::Run);
    }

    /// Starts its process again, when it has none and will get none.
    pub(crate) fn start_if_failed(&self) {
        if *self.phase.borrow() == CellState::Failed {
            self.start_again();
        }
    }

    /// Asks for its end: its components stop as they should.
    pub(crate) fn ask_to_stop(&self) {
        self.order.send_replace(Order::Stop);
    }

    fn with<T>(&self, work: impl FnOnce(&mut State) -> T) -> T {
        work(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn enter(&self, phase: CellState) {
        self.phase.send_replace(phase);
    }

    pub(crate) fn is_stopping(&self) -> bool {
        *self.order.borrow() == Order::Stop
    }

    async fn told_to_stop(&self) {
        let mut order = self.order.subscribe();
        let _ = order.wait_for(|order| *order == Order::Stop).await;
    }

    async fn live(self: Arc<Self>, mut found: Option<Process>) {
        let mut restarts = Restarts::default();
        let mut order = self.order.subscribe();
        if found.is_none() {
            self.report_left();
        }
        loop {
            let end = match found.take() {
                Some(process) => {
                    self.setup.boxes.adopt(&self.name, process.pid());
                    self.run(&process, true).await
                }
                None => self.start_and_run().await,
            };
            self.react_to(&end);
            let asked = self.report(&end);
            self.with(|state| {
                (state.pid, state.steps) = (None, None);
                state.last_end = Some(self.setup.explain(&self.name, &end));
            });
            order.mark_unchanged();
            // A gateway that nobody uses ends by itself.
            let unused = self.is_gateway() && end == End::Exited(0);
            if self.is_stopping() || unused {
                break;
            }
            let delay = self.after(&end, asked, &mut restarts);
            // Others are safe before a new process takes its part of the processors.
            self.reacted().await;
            let told_otherwise = order.changed();
            match delay {
                Some(delay) => {
                    let _ = timeout(delay, told_otherwise).await;
                }
                None => {
                    let _ = told_otherwise.await;
                    restarts.forget();
                }
            }
            if self.is_stopping() {
                break;
            }
        }
        self.place.remove();
        self.enter(CellState::Stopping);
        self.over.send_replace(true);
    }

    /// What follows an end: how long to wait before the next start, if there is to be one.
    /// After one that somebody asked for, all comes back.
    fn after(&self, end: &End, asked: bool, restarts: &mut Restarts) -> Option<Duration> {
        let held = journal::read(&self.place.journal()).unwrap_or_else(|error| {
            tracing::error!("cell {}: {error}; it starts with nothing", self.name);
            Deployment::default()
        });
        let lost: Vec<String> = held.component.iter().map(|one| one.instance()).collect();
        let kept = match asked {
            true => held.clone(),
            false => journal::kept(held.clone(), end.is_failure()),
        };
        self.with(|state| {
            state.held = held;
            state.fall = if asked { Fall::None } else { Fall::Down { told: false } };
        });
        let names: Vec<String> = kept.component.iter().map(|one| one.instance()).collect();
        if !self.is_gateway()
            && let Err(error) = journal::write(&self.place.journal(), &kept)
        {
            tracing::error!("cell {}: its journal cannot be written: {error}", self.name);
        }
        self.with(|state| state.components.clone_from(&names));
        let (cell, why) = (self.name.clone(), self.setup.explain(&self.name, end));
        let delay = if matches!(end, End::Refused(_)) {
            tracing::error!("cell {cell} does not start: {why}");
            None
        } else if names.is_empty() && !self.is_gateway() {
            tracing::error!("cell {cell} ended: {why}; nothing in it is to be restarted");
            None
        } else {
            let (settings, now) = (&self.setup.settings, Instant::now());
            let delay = if self.is_gateway() {
                let longest = self.setup.config.gateways.longest_delay();
                let ran = *self.phase.borrow() == CellState::Running;
                Some(restarts.next_of_gateway(settings, longest, ran, now))
            } else {
                restarts.next(settings, now)
            };
            match delay {
                Some(delay) => {
                    tracing::warn!(
                        "cell {cell} ended: {why}; restarted in {} s",
                        delay.as_secs_f64()
                    );
                }
                None => tracing::error!(
                    "cell {cell} ended: {why}; it ended too often, and is not restarted: \
                     `genomctl cells --restart {cell}` starts it again"
                ),
            }
            delay
        };
        self.enter(if delay.is_some() { CellState::Waiting } else { CellState::Failed });
        let restarts = delay.is_some();
        self.setup.tell(Told::Cell(Change::CellEnded { cell, why, components: lost, restarts }));
        delay
    }

    async fn start_and_run(&self) -> End {
        self.enter(CellState::Starting);
        self.with(|state| state.starts += 1);
        // Of a process whose end no daemon saw.
        if let Some((why, _)) = self.place.taken_broken_rule() {
            tracing::warn!("cell {} had been ended by its supervision: {why}", self.name);
        }
        let started = match self.setup.write_config(&self.name, &self.place) {
            Ok(()) => {
                let memory = self.setup.boxes.begin(&self.name);
                let command = self.setup.command(&self.place);
                let dumps = self.setup.config.crashes.minidump;
                let gets = Gets { dumps, steps: self.setup.embedded && !self.is_gateway() };
                Process::start(command, &self.name, &self.place, memory.as_deref(), gets)
                    .map_err(|error| error.to_string())
            }
            Err(error) => Err(error.to_string()),
        };
        match started {
            Ok(process) => self.run(&process, false).await,
            Err(why) => End::NotStarted(why),
        }
    }

    /// Until the process ends.
    async fn run(&self, process: &Process, adopted: bool) -> End {
        self.with(|state| {
            (state.pid, state.dump) = (Some(process.pid()), process.dump());
            state.steps = process.steps();
        });
        let limit = self.setup.settings.ready_timeout;
        tokio::select! {
            end = self.end_of(process) => return match refusal(&self.place, &end).await {
                Some(why) => End::Refused(why),
                None => self.for_a_rule(end).await,
            },
            ready = timeout(limit, self.ready()) => if ready.is_err() {
                return self.kill_for(process, End::NotReady(limit)).await;
            },
            () = self.told_to_stop() => return self.stop(process).await,
        }
        if let Ok(all) = self.client.ask(&routes::components()).await {
            let names = all.components.into_iter().map(|one| one.name).chain(all.loading).collect();
            self.with(|state| state.components = names);
        }
        self.with(|state| state.fall = state.fall.and_up());
        // Read now, so that a failure waits for no reading.
        let _ = self.journal.read();
        self.enter(CellState::Running);
        let (cell, pid) = (self.name.clone(), process.pid());
        tracing::info!("cell {cell} {}, process {pid}", if adopted { "found" } else { "runs" });
        self.setup.tell(Told::Cell(Change::CellRuns { cell, pid, adopted }));
        let after = if adopted { None } else { Some(0) };
        let end = self.follow_until(after, async {
            tokio::select! {
                end = self.end_of(process) => end,
                limit = self.silent() => self.kill_for(process, End::Silent(limit)).await,
                () = self.told_to_stop() => self.stop(process).await,
            }
        });
        let end = end.await;
        self.for_a_rule(end).await
    }

    /// Hears what it tells until its process has ended, and what it told before that and was not
    /// heard yet.
    async fn follow_until(&self, after: Option<u64>, ended: impl Future<Output = End>) -> End {
        let (mut follow, mut ended) = (pin!(self.follow(after)), pin!(ended));
        tokio::select! {
            end = &mut ended => {
                let _ = timeout(NOTICE, follow).await;
                end
            }
            () = &mut follow => ended.await,
        }
    }

    /// Waits until it has loaded what it is to hold.
    async fn ready(&self) {
        let wait = ReadyParameters { wait: Some(10.0), deployed: None };
        let route = routes::ready().with(&wait);
        while self.client.ask(&route).await.is_err() {
            sleep(LOOK_AGAIN).await;
        }
    }

    /// Keeps the list of its components.
    fn heard(&self, change: &serde_json::Value) {
        let Some(name) = change["component"].as_str() else { return };
        self.with(|state| match change["event"].as_str() {
            Some("component_loaded") if !state.components.iter().any(|one| one == name) => {
                state.components.push(name.to_owned());
            }
            Some("component_unloaded") => state.components.retain(|one| one != name),
            _ => {}
        });
    }

    /// A component was loaded into it: known before the reply, and before the event is.
    pub(crate) fn loaded(&self, name: &str) {
        let change = serde_json::json!({"event": "component_loaded", "component": name});
        self.heard(&change);
    }

    /// A component was taken out of it.
    pub(crate) fn unloaded(&self, name: &str) {
        let change = serde_json::json!({"event": "component_unloaded", "component": name});
        self.heard(&change);
    }

    /// Asks again and again whether it answers; returns the limit when it did not for so long.
    async fn silent(&self) -> Duration {
        let limit = self.setup.settings.alive_timeout;
        loop {
            if timeout(limit, self.client.ask(&routes::about())).await.is_err() {
                return limit;
            }
            let _ = timeout(limit / 4, learn(&self.client, &self.known)).await;
            let _ = self.journal.read();
            sleep(limit / 4).await;
        }
    }

    /// Asks it to stop, and ends it when it does not in time.
    async fn stop(&self, process: &Process) -> End {
        self.enter(CellState::Stopping);
        let limit = self.setup.stop_timeout + Duration::from_secs(2);
        let asked = async {
            if self.client.ask(&routes::shutdown()).await.is_err() {
                process.signal(Signal::TERM);
            }
            process.ended().await
        };
        match timeout(limit, asked).await {
            Ok(end) => end,
            Err(_) => {
                tracing::error!("cell {} did not stop in time, and is killed", self.name);
                process.signal(Signal::KILL);
                process.ended().await
            }
        }
    }
}
