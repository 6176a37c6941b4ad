//! A running instance of a component: the interface for the daemon.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use genom_description::model::{Codel, CodelIx, PortIx, ServiceIx, TaskIx};
use genom_types::Record;
use serde_json::Value;

use crate::api::{Inputs, OnShutdown, Reply};
use crate::body::Body;
use crate::clock::nanos;
use crate::engine::{ActivityStatus, Engine, NoSuchActivity, OVER};
use crate::freeze::FreezeError;
use crate::frozen::{Frozen, Resume};
use crate::handover::HeirIds;
use crate::lock::lock;
use crate::options::Options;
use crate::plan::{Plan, owner_name};
use crate::rest::{NoRest, Rest};
use crate::rules::Happening;
use crate::running::{HeldUp, RunningCodel};
use crate::shutdown::ShutdownError;
use crate::start::StartError;
use crate::statistics::{CodelStatistics, Statistics, TaskHistograms, TaskStatistics};
use crate::ticket::Ticket;
use crate::unpaused::Unpaused;
use crate::waits::CannotWait;

/// Timeout of the shutdown when an instance is dropped without one.
const LAST_CHANCE: Duration = Duration::from_secs(1);

/// A running component. Share it by `Arc`; any thread may call any method, except the threads of
/// the instance's own tasks.
pub struct Instance {
    engine: Arc<Engine>,
}

/// The component has no external event with this index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no external event number {sink}: the component has {known}")]
pub struct NoSuchEvent {
    /// The requested index.
    pub sink: usize,
    /// How many the component has.
    pub known: usize,
}

impl Instance {
    /// Starts an instance of a component (genom3.md 7.2).
    ///
    /// Bind ports before, so that start codels find them. Blocks until the first codel of every
    /// task has run; then requests are served.
    ///
    /// # Errors
    /// A start codel failed or hangs, or the system provides no thread. What had been started is
    /// undone.
    pub fn start(
        plan: Arc<Plan>,
        body: Arc<dyn Body>,
        options: Options,
    ) -> Result<Self, StartError> {
        Engine::start(&plan, body, options).map(|engine| Self { engine })
    }

    /// The compiled component.
    #[must_use]
    pub fn plan(&self) -> &Arc<Plan> {
        &self.engine.shared.plan
    }

    /// The instance name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.engine.name
    }

    /// Requests a service (genom3.md 7.3). `input` is a record of the service's input struct, see
    /// [`input_record`](crate::input_record); a control thread calls `reply` with the progress. On
    /// a virtual clock, attributes and functions are served before this returns, and activities run
    /// when the clock is stepped.
    pub fn request(&self, service: ServiceIx, input: Record, reply: Reply) -> Ticket {
        let ticket = Ticket::default();
        self.request_by(&ticket, service, Inputs::Whole(input), reply);
        ticket
    }

    /// As [`request`](Self::request), with a ticket that the caller has from the beginning, so that
    /// another thread can give the request up even on a virtual clock; inputs may be partial.
    pub fn request_by(&self, ticket: &Ticket, service: ServiceIx, inputs: Inputs, reply: Reply) {
        self.engine.submit(service, inputs, reply, ticket.clone());
    }

    /// Withdraws a request that has not begun because a stuck codel blocks it: it never runs, and
    /// its reply is dropped. `None` when no stuck codel blocks it, or when it has begun.
    #[must_use]
    pub fn give_up(&self, service: ServiceIx, ticket: &Ticket) -> Option<HeldUp> {
        if ticket.has_begun() {
            return None;
        }
        let held_up = self.engine.holds_up_service(service)?;
        self.engine.withdraw(service, ticket).then_some(held_up)
    }

    /// Whether the calling thread may wait for the outcome of a request of this service. With
    /// [`Execution::Single`](crate::Execution::Single) the shared thread, on which a codel calls a
    /// service of another component, would have to serve the request itself.
    ///
    /// # Errors
    /// It would wait for ever.
    pub fn may_wait_here(&self, service: ServiceIx) -> Result<(), CannotWait> {
        self.engine.may_wait_here(service)
    }

    /// Asks an activity to stop on behalf of its client; it ends with `interrupted { by: "client"
    /// }`.
    ///
    /// # Errors
    /// There is no such activity: its end was reported, or it is the permanent one of a task.
    pub fn abort(&self, activity: u32) -> Result<(), NoSuchActivity> {
        self.engine.abort(activity, "client")?;
        // genom3.md 7.5: a paused activity wakes up, as after `abort_activity`.
        self.engine.shared.wake_tasks();
        Ok(())
    }

    /// Asks all activities of services to stop, as [`abort`](Self::abort) does for one; returns ids
    /// and services of those that have not ended, including those asked earlier.
    pub fn abort_all(&self) -> Vec<(u32, ServiceIx)> {
        let told = self.engine.abort_all("client");
        self.engine.shared.wake_tasks();
        told
    }

    /// Fires an external event: activities that handle its state get a token there (dialects.md A);
    /// others are not affected.
    ///
    /// # Errors
    /// The component has no such event.
    pub fn fire(&self, sink: usize) -> Result<(), NoSuchEvent> {
        let known = self.plan().component().sinks.len();
        if sink >= known {
            return Err(NoSuchEvent { sink, known });
        }
        self.engine.happens(Happening::Fire(sink), 0);
        self.engine.shared.tasks.iter().for_each(|task| task.fire(sink));
        Ok(())
    }

    /// Runs `work` while all codels that it could disturb are excluded, to bind ports and remotes
    /// (genom3.md 7.8). Async codels without port or remote are not excluded. Codels must not call
    /// this.
    ///
    /// # Errors
    /// A codel is stuck, or did not return in time; `work` was not run.
    pub fn exclusively<R>(&self, work: impl FnOnce(&dyn Body) -> R) -> Result<R, HeldUp> {
        self.engine.exclusively(work)
    }

    /// Runs `work` at a moment when no codel runs, not even an async one, and each activity is at a
    /// pause, to exchange the code that codels are made of. Codels must not call this.
    ///
    /// # Errors
    /// There was no such moment within `limit`; `work` was not run.
    pub fn at_rest<R>(
        &self,
        limit: Duration,
        work: impl FnOnce(Rest<'_>) -> R,
    ) -> Result<R, NoRest> {
        self.engine.at_rest(limit, work)
    }

    /// Sets the build date, after code was exchanged.
    pub fn set_date(&self, date: String) {
        *lock(&self.engine.date) = date;
        self.engine.write_state();
    }

    /// What it is between two passes of its tasks, which are kept from the next one while this
    /// copies its memory and does `also`, which must not block. Waits at most `patience` until no
    /// codel runs.
    ///
    /// # Errors
    /// Codels ran whenever it looked, or the instance stops.
    pub fn freeze(
        &self,
        patience: Duration,
        also: &mut dyn FnMut(),
    ) -> Result<Frozen, FreezeError> {
        self.engine.freeze(patience, also)
    }

    /// Hands its state over to `heir`, which [`Resume::hold`] holds, at a moment of rest between two
    /// ticks: the heir serves the next one. Activities go on there with their numbers. This instance
    /// shuts down, within `timeout`, without them; wait for that with
    /// [`finish_shutdown`](Self::finish_shutdown).
    ///
    /// `convert` makes what the heir takes, for which it may change its IDS at once, and `exchange` gives the ports of the first body to the
    /// second; no codel of the two runs meanwhile, and neither may block.
    ///
    /// # Errors
    /// There was no such moment within `limit`, or `convert` failed. Nothing was done.
    pub fn hand_over<E>(
        &self,
        heir: &Self,
        (limit, timeout): (Duration, Duration),
        convert: impl FnOnce(Frozen, &HeirIds<'_>) -> Result<Resume, E>,
        exchange: impl FnOnce(&dyn Body, &dyn Body),
    ) -> Result<Result<(), E>, NoRest> {
        let limits = (limit, Instant::now() + limit + timeout);
        self.engine.hand_over(&heir.engine, limits, convert, exchange)
    }

    /// The date from which its ticks are counted.
    #[must_use]
    pub fn epoch(&self) -> u64 {
        self.engine.epoch
    }

    /// Lets the tasks go on that [`Resume::hold`] holds.
    pub fn go_on(&self) {
        self.engine.go_on();
    }

    /// Whether its tasks wait for [`go_on`](Self::go_on).
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.engine.shared.held.load(Ordering::Relaxed)
    }

    /// What of [`Options::resume`] could not be resumed, and why.
    #[must_use]
    pub fn unresumed(&self) -> Vec<String> {
        lock(&self.engine.unresumed).clone()
    }

    /// Codels that run now, with the durations of their calls so far.
    #[must_use]
    pub fn running_codels(&self) -> Vec<RunningCodel> {
        self.engine.running_codels()
    }

    /// The codel that has been stuck for longest; `None` if none is.
    #[must_use]
    pub fn stuck(&self) -> Option<RunningCodel> {
        let all = self.running_codels().into_iter();
        all.filter(|codel| codel.stuck).max_by_key(|codel| codel.for_ns)
    }

    /// Looks for codels that have not returned in time, and for ticks that are missed meanwhile, by
    /// [`Options::rules`]; watchers are told before this returns. All other rules are looked at
    /// without it.
    ///
    /// Returns when to look again; `None` if no rule needs that. On a virtual clock ticks are looked
    /// at by the thread that steps it, and only a codel that counts as stuck is too late.
    pub fn supervise(&self) -> Option<Duration> {
        self.engine.supervise()
    }

    /// How often each rule of [`Options::rules`] was broken.
    #[must_use]
    pub fn violations(&self) -> Vec<u64> {
        let rules = &self.engine.shared.rules;
        rules.counts()
    }

    /// What orders and formulas did not hear of, since more happened at once than they keep.
    #[must_use]
    pub fn unheard(&self) -> u64 {
        self.engine.shared.rules.unheard()
    }

    /// Rounds of the control thread so far. `None` when there is no such thread: on a virtual
    /// clock, with [`Execution::Single`](crate::Execution::Single), and once the instance has
    /// stopped.
    #[must_use]
    pub fn control_rounds(&self) -> Option<u64> {
        self.engine.shared.control.get()?;
        Some(self.engine.rounds.load(Ordering::Relaxed)).filter(|rounds| *rounds != OVER)
    }

    /// Asks the control thread for another round.
    pub fn wake_control(&self) {
        self.engine.shared.wake_control();
    }

    /// Tasks whose cycle has lasted for long although none of their codels is stuck.
    #[must_use]
    pub fn unpaused(&self) -> Vec<Unpaused> {
        self.engine.unpaused()
    }

    /// Activities that were accepted and have not ended, in order of acceptance, including
    /// permanent ones.
    #[must_use]
    pub fn activities(&self) -> Vec<ActivityStatus> {
        self.engine.activities()
    }

    /// Last value of a port, as codels wrote or read it; `None` before the first.
    #[must_use]
    pub fn port_value(&self, port: PortIx, element: Option<&str>) -> Option<Value> {
        self.engine.shared.body.port_value(port, element)
    }

    /// The last value as a record, bit by bit; `None` also when no copy was kept, as for large
    /// values while nobody asks for them.
    #[must_use]
    pub fn last_value(&self, port: PortIx, element: Option<&str>) -> Option<Record> {
        self.engine.shared.body.last_value(port, element)
    }

    /// The last value as a CDR message.
    #[must_use]
    pub fn port_message(&self, port: PortIx, element: Option<&str>) -> Option<Vec<u8>> {
        self.engine.shared.body.port_message(port, element)
    }

    /// A description of where codels wrote past their memory, if that was detected.
    #[must_use]
    pub fn damage(&self) -> Option<String> {
        self.engine.shared.body.damage()
    }

    /// Statistics of tasks and codels since the start.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        let shared = &self.engine.shared;
        let now = shared.clock.now();
        let model = self.plan().component();
        let task = |(ix, task): (TaskIx, &genom_description::model::Task)| {
            let shared = &shared.tasks[ix];
            TaskStatistics {
                name: task.name.clone(),
                period_ns: shared.timing.map(|timing| timing.period),
                real_time: shared.real_time.load(Ordering::Relaxed),
                cycles: shared.figures.cycles.read(now),
                lateness: shared.figures.lateness.read(),
                stuck: self.engine.codel_of_task(ix).filter(|codel| codel.stuck),
                unpaused: self.engine.unpaused_task(ix, now),
                overruns: shared.figures.overruns.read(shared.timing, now),
            }
        };
        let codel = |(ix, codel): (CodelIx, &Codel)| {
            let figures = &shared.codels[ix];
            CodelStatistics {
                name: codel.name.clone(),
                owner: owner_name(model, codel.owner).to_owned(),
                durations: figures.durations.read(),
                yielded: self.plan().yields(ix).told(self.plan().events(), &figures.yielded),
                wcet_ns: codel.wcet.map(nanos),
                above_wcet: figures.above_wcet.read(),
            }
        };
        Statistics {
            tasks: model.tasks.pairs().map(task).collect(),
            codels: model
                .codels
                .pairs()
                .map(codel)
                .filter(|codel| codel.durations.count > 0)
                .collect(),
            lost_changes: shared.lost.read(),
        }
    }

    /// How often its tasks took how long, since the start.
    #[must_use]
    pub fn histograms(&self) -> Vec<TaskHistograms> {
        let task = |(ix, task): (TaskIx, &genom_description::model::Task)| {
            let shared = &self.engine.shared.tasks[ix];
            TaskHistograms {
                name: task.name.clone(),
                period_ns: shared.timing.map(|timing| timing.period),
                cycles: shared.figures.cycles.buckets(),
                lateness: shared.figures.lateness.buckets(),
            }
        };
        self.plan().component().tasks.pairs().map(task).collect()
    }

    /// Shuts the instance down (genom3.md 7.7): activities are asked to stop by "kill" and their
    /// clients answered, then permanent activities stop in reverse order of tasks, then the threads
    /// end. A second call does nothing.
    ///
    /// Threads of the instance must not call this, neither in a codel nor in a reply.
    ///
    /// # Errors
    /// Something did not end within `timeout`; the error names the codels. Other instances are not
    /// affected.
    pub fn shutdown(&self, timeout: Duration) -> Result<(), ShutdownError> {
        self.engine.shutdown(timeout)
    }

    /// Begins a [`shutdown`](Self::shutdown) and returns. `ended` is called once, by any thread,
    /// when no codel runs any more. Returns `false` when a shutdown had begun before. On a virtual
    /// clock all codels that have to run do so before this returns.
    pub fn begin_shutdown(&self, ended: OnShutdown, timeout: Duration) -> bool {
        self.engine.begin_shutdown(Some(ended), Instant::now() + timeout)
    }

    /// Waits for the end of a shutdown that has begun, until `deadline`.
    ///
    /// # Errors
    /// As for [`shutdown`](Self::shutdown).
    pub fn finish_shutdown(&self, deadline: Instant) -> Result<(), ShutdownError> {
        self.engine.finish_shutdown(deadline)
    }

    /// Whether no codel runs any more, or ever will. After a shutdown that timed out: whether the
    /// codels that hung have returned.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.engine.is_over()
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Err(error) = self.engine.shutdown(LAST_CHANCE) {
            tracing::error!("{error}");
        }
    }
}

impl fmt::Debug for Instance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Instance({})", self.name())
    }
}
