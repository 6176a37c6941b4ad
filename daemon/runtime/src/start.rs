//! Start-up (genom3.md 7.2): threads, permanent activities, and what happens when one fails.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use genom_description::model::{Ix as _, Owner, Task, TaskIx};
use rtrb::RingBuffer;

use crate::api::Exception;
use crate::body::{Body, Frame};
use crate::clock::{Clock, nanos};
use crate::control::{Control, Entry, Phase, Stage, TaskLink};
use crate::engine::Engine;
use crate::executor::Member;
use crate::lock::lock;
use crate::options::{Execution, GiveUp, Options, TaskOptions};
use crate::plan::Plan;
use crate::rules::{MOST_RULES, Rules};
use crate::running::{RunningCodel, seconds};
use crate::shared::Shared;
use crate::task::driven::DrivenTask;
use crate::task::gate::TaskSide;
use crate::task::runner::Runner;
use crate::task::timing::Timing;
use crate::task::{scheduling, thread};

/// Stack of a task that declares none, in bytes (genom3.md 7.4).
const STACK: u64 = 8 << 20;
/// Capacity of the ring of notices to watchers.
const NOTICES: usize = 4096;
/// Capacity of the ring of broken rules; further ones are counted only.
const BROKEN: usize = 64;
/// Timeout of undoing a failed start-up.
const UNDO: Duration = Duration::from_secs(5);

/// An instance did not start. What had been started was undone.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// A task's first codel, or one that followed without pause, ended with an exception.
    #[error("task {task} of {instance} failed at start: {exception}")]
    Failed {
        /// The instance.
        instance: String,
        /// The task.
        task: String,
        /// The exception.
        exception: Box<Exception>,
    },
    /// A task's first codel did not return in time. Its thread is left behind.
    #[error(
        "codel {codel} of task {task} of {instance} has not returned after {}: \
         give it more time, or look at what it waits for",
        seconds(nanos(*.after))
    )]
    Hangs {
        /// The instance.
        instance: String,
        /// The task.
        task: String,
        /// The codel.
        codel: String,
        /// The timeout that passed.
        after: Duration,
    },
    /// A codel of another instance, which does not return, has the thread that the task shares.
    #[error(
        "task {task} of {instance} does not start: {by} has the one thread of all tasks \
         (execution = \"single\")"
    )]
    HeldUp {
        /// The instance.
        instance: String,
        /// The task.
        task: String,
        /// The codel; its owner is `INSTANCE/OWNER`.
        by: Box<RunningCodel>,
    },
    /// The system provides no thread.
    #[error(
        "task {task} of {instance} has no thread: {source} (the limits of threads are `ulimit -u`, \
         `TasksMax=` of a systemd unit and `pids.max` of a container; memory may be another)"
    )]
    NoThread {
        /// The instance.
        instance: String,
        /// The task.
        task: String,
        /// The error of the system.
        #[source]
        source: std::io::Error,
    },
}

/// The ticks of a task: the period is that of the configuration, else that of the `.gen`.
fn timing(task: &Task, options: &TaskOptions, epoch: u64) -> Option<Timing> {
    let period = options.period.filter(|_| task.period.is_some()).or(task.period)?;
    Some(Timing::new(epoch, nanos(period), nanos(task.delay)))
}

impl Engine {
    /// Starts an instance; requests are served when this returns.
    pub(crate) fn start(
        plan: &Arc<Plan>,
        body: Arc<dyn Body>,
        mut options: Options,
    ) -> Result<Arc<Self>, StartError> {
        let model = plan.component();
        let clock = options.clock.clone();
        let of_task: Vec<TaskOptions> = model
            .tasks
            .iter()
            .map(|task| options.tasks.remove(&task.name).unwrap_or_default())
            .collect();
        for name in options.tasks.keys() {
            tracing::warn!(instance = options.name, "there is no task `{name}` to configure");
        }
        let single = match (&clock, &options.execution) {
            (Clock::Monotonic, Execution::Single(executor)) => Some(Arc::clone(executor)),
            (Clock::Virtual(_) | Clock::Staged(_), _) | (_, Execution::Threads) => None,
        };
        if let Some(executor) = &single {
            scheduling::tell_not_applied(&options.name, model, &of_task, STACK);
            executor.open().map_err(|source| StartError::NoThread {
                instance: options.name.clone(),
                task: model.tasks.iter().next().map_or_else(String::new, |task| task.name.clone()),
                source,
            })?;
        }
        let call = single.as_ref().map(|executor| Arc::new(executor.call()));
        let first = || single.as_ref().map_or_else(|| clock.now(), |executor| executor.epoch());
        let epoch = options.epoch.unwrap_or_else(first);
        options.epoch = Some(epoch);
        let timings =
            model.tasks.iter().zip(&of_task).map(|(task, o)| timing(task, o, epoch)).collect();
        let mut rules = std::mem::take(&mut options.rules);
        rules.truncate(MOST_RULES);
        let supervised = !rules.is_empty();
        let rules = Rules::new(plan, rules, options.resume.is_some());
        let shared = Arc::new(Shared::new(plan, body, clock.clone(), timings, call, rules));
        let watched = options.watcher.is_some();
        let (links, sides): (Vec<_>, Vec<_>) =
            model.tasks.iter().map(|_| rings(options.activity_limit, watched, supervised)).unzip();
        let resume = options.resume.take();
        shared.held.store(resume.is_some(), Ordering::Release);
        let runner = |(task, side)| Runner::new(Arc::clone(&shared), task, side);
        let runners: Vec<Runner> = shared.tasks.places().zip(sides).map(runner).collect();
        let gates = runners.iter().map(|runner| Arc::clone(runner.gate())).collect();
        let control = Control::new(plan, links.into_iter().collect());
        let patience = Patience { timeout: options.start_timeout, give_up: options.give_up.take() };
        let virtual_time = matches!(clock, Clock::Virtual(_));
        let driven = virtual_time.then(|| Vec::with_capacity(runners.len()));
        let engine = Arc::new(Self::new(options, shared, control, gates, driven, single));
        engine.write_state();
        if let Clock::Staged(stage) = &clock {
            let engine: Arc<dyn crate::clock::OnStage> = Arc::<Self>::clone(&engine);
            stage.enters(Arc::downgrade(&engine));
        }
        let seat = engine.enter_executor();
        for (runner, task_options) in runners.into_iter().zip(of_task) {
            let started = engine.start_task(runner, task_options, &patience, seat);
            if let Err(error) = started.and_then(|()| engine.check_failure()) {
                if let Err(hang) = engine.shutdown(UNDO) {
                    tracing::error!(instance = engine.name, "{hang}");
                }
                return Err(error);
            }
        }
        if let Some(resume) = resume {
            engine.resume(resume);
        }
        engine.open(&clock);
        Ok(engine)
    }

    /// genom3.md 7.2.3: starts a task, and waits until the first codel of its permanent activity
    /// has run.
    fn start_task(
        self: &Arc<Self>,
        runner: Runner,
        options: TaskOptions,
        patience: &Patience,
        seat: Option<u64>,
    ) -> Result<(), StartError> {
        let rank = runner.task();
        self.send_permanent(rank, false);
        if let Some(driven) = &self.driven {
            let mut task = DrivenTask::new(runner);
            task.start(self.shared.clock.now());
            lock(driven).push(task);
            return Ok(());
        }
        let me = &self.shared.tasks[rank];
        me.set_starter(std::thread::current());
        match (&self.single, seat) {
            (Some(executor), Some(seat)) => executor.add_task(seat, runner),
            _ => self.spawn(runner, options)?,
        }
        let begin = Instant::now();
        while !me.is_started() {
            let spent = begin.elapsed();
            if patience.is_over(spent) {
                let model = self.shared.plan.component();
                let none_here = self.shared.current(rank.index()).is_none();
                let other = self.single.as_ref().and_then(|executor| executor.running());
                if let Some(by) = other.filter(|_| none_here) {
                    return Err(StartError::HeldUp {
                        instance: self.name.clone(),
                        task: model.tasks[rank].name.clone(),
                        by: Box::new(by),
                    });
                }
                let codel =
                    self.shared.current(rank.index()).map(|codel| model.codels[codel].name.clone());
                return Err(StartError::Hangs {
                    instance: self.name.clone(),
                    task: model.tasks[rank].name.clone(),
                    codel: codel.unwrap_or_default(),
                    after: spent,
                });
            }
            match patience.slice(spent) {
                Some(slice) => std::thread::park_timeout(slice),
                None => std::thread::park(),
            }
        }
        Ok(())
    }

    /// Takes part in the thread that it shares with other instances, if it does.
    fn enter_executor(self: &Arc<Self>) -> Option<u64> {
        let (executor, call) = (self.single.as_ref()?, self.shared.call.as_ref()?);
        // The shared thread counts as one thread of the instance, until it has released it.
        self.lock().alive += 1;
        let member: Arc<dyn Member> = Arc::<Self>::clone(self);
        Some(executor.enter(member, &self.shared, call))
    }

    /// Creates the permanent activity of a task, and sends it to the task.
    pub(crate) fn send_permanent(&self, task: TaskIx, at_stop: bool) {
        // The machines of permanent activities come first, in the order of tasks.
        let frame = self.shared.body.frame(Owner::Task(task));
        self.send_permanent_with(&mut self.lock(), task, frame, at_stop);
    }

    /// The same, with a frame that there is.
    pub(crate) fn send_permanent_with(
        &self,
        control: &mut Control,
        task: TaskIx,
        frame: Box<dyn Frame>,
        at_stop: bool,
    ) {
        let mut run = self.new_run(control.new_id(), task.index(), frame);
        run.at_stop = at_stop;
        control.entries.push(Entry {
            id: run.id,
            service: None,
            task,
            marker: Arc::clone(&run.marker),
            stage: Stage::Sent,
            by: None,
            reply: None,
            accepted: self.shared.clock.now(),
            asked: None,
            late: 0,
        });
        control.send(task, run);
    }

    fn spawn(self: &Arc<Self>, runner: Runner, options: TaskOptions) -> Result<(), StartError> {
        let rank = runner.task();
        let task = &self.shared.plan.component().tasks[rank];
        let name = format!("{}:{}", self.name, task.name);
        let stack = usize::try_from(task.stack.unwrap_or(STACK)).unwrap_or(usize::MAX);
        let wanted = scheduling::Wanted::new(task, options);
        let engine = Arc::clone(self);
        self.lock().alive += 1;
        let spawned = std::thread::Builder::new().name(name).stack_size(stack).spawn(move || {
            let shared = &engine.shared;
            shared.tasks[rank].set_thread();
            wanted.apply(&engine.name, rank, shared);
            thread::run(runner);
            engine.thread_ended();
        });
        match spawned {
            Ok(handle) => {
                lock(&self.threads).push(handle);
                Ok(())
            }
            Err(source) => {
                let mut control = self.lock();
                control.alive -= 1;
                // No thread will run the permanent activity, so the shutdown must not wait for it.
                control.entries.retain(|entry| entry.task != rank);
                drop(control);
                Err(StartError::NoThread {
                    instance: self.name.clone(),
                    task: task.name.clone(),
                    source,
                })
            }
        }
    }

    fn check_failure(&self) -> Result<(), StartError> {
        self.attend();
        match self.lock().failure.clone() {
            None => Ok(()),
            Some((task, exception)) => Err(StartError::Failed {
                instance: self.name.clone(),
                task: self.shared.plan.component().tasks[task].name.clone(),
                exception: Box::new(exception),
            }),
        }
    }

    /// genom3.md 7.2.4: from here on requests are served.
    fn open(self: &Arc<Self>, clock: &Clock) {
        self.lock().phase = Phase::Running;
        self.shared.rules.await_beats(self.shared.clock.now());
        if let Clock::Virtual(clock) = clock {
            let engine: Arc<dyn crate::clock::Driven> = Arc::<Self>::clone(self);
            clock.drive(Arc::downgrade(&engine));
            return;
        }
        if let Some(call) = &self.shared.call {
            return call.ring();
        }
        let engine = Arc::clone(self);
        let name = format!("{}:control", self.name);
        let control = std::thread::Builder::new().name(name).spawn(move || {
            let _ = engine.shared.control.set(std::thread::current());
            engine.attend_until_stopped();
        });
        match control {
            Ok(handle) => lock(&self.threads).push(handle),
            Err(error) => tracing::error!(instance = self.name, "no control thread: {error}"),
        }
    }
}

/// How long to wait for a first codel.
struct Patience {
    timeout: Option<Duration>,
    give_up: Option<GiveUp>,
}

impl Patience {
    fn is_over(&self, spent: Duration) -> bool {
        let late = self.timeout.is_some_and(|timeout| spent >= timeout);
        late || self.give_up.as_ref().is_some_and(|give_up| give_up())
    }

    /// Time until the next check; `None` when only the codel's return ends the wait.
    fn slice(&self, spent: Duration) -> Option<Duration> {
        /// Interval of asking whether to give up.
        const LOOK: Duration = Duration::from_millis(100);
        let left = self.timeout.map(|timeout| timeout.saturating_sub(spent));
        let look = self.give_up.as_ref().map(|_| LOOK);
        left.into_iter().chain(look).min()
    }
}

/// Creates the rings between control and one task.
fn rings(limit: usize, watched: bool, supervised: bool) -> (TaskLink, TaskSide) {
    // Room for every slot, the permanent activity, and the one created again at shutdown.
    let (to, inbox) = RingBuffer::new(limit + 2);
    let (outbox, from) = RingBuffer::new(limit + 2);
    let (sender, receiver) = watched.then(|| RingBuffer::new(NOTICES)).unzip();
    let (tell, told) = supervised.then(|| RingBuffer::new(BROKEN)).unzip();
    (
        TaskLink { to, from, notices: receiver, broken: told, used: 0 },
        TaskSide { inbox, outbox, notices: sender, broken: tell },
    )
}
