//! Plays a script.

use std::collections::HashMap;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use genom_description::model::{CodelIx, Ix as _, ServiceIx, TaskIx};
use genom_runtime::body::Returned;
use genom_runtime::{
    Clock, ConnectionError, Instance, Options, Plan, Stage as _, StartError, Statistics,
    Supervision, TaskOptions, Turn, input_record,
};

use crate::body::Scripted;
use crate::error::NotPlayed;
use crate::script::{Move, Script, Step};
use crate::theatre::{Theatre, Waiting};

/// Time for the end of an instance, by the machine's clock.
const END: Duration = Duration::from_secs(5);

/// What is played.
#[derive(Clone, Debug)]
pub struct Component {
    /// The component.
    pub plan: Arc<Plan>,
    /// What the configuration overrides of its tasks.
    pub tasks: HashMap<String, TaskOptions>,
    /// Activities of services that one task may have at the same time.
    pub slots: usize,
}

/// A supervisor that does nothing.
struct Nobody;

impl Supervision for Nobody {
    fn connect_port(&self, _: &str, _: &str) -> Result<(), ConnectionError> {
        Ok(())
    }

    fn connect_service(&self, _: &str, _: &str) -> Result<(), ConnectionError> {
        Ok(())
    }

    fn kill(&self) {}
}

/// Plays a script from the start of the component on; returns what the runtime measured.
///
/// # Errors
/// The component is not where the script says.
pub fn play(component: &Component, script: &Script) -> Result<Statistics, NotPlayed> {
    let theatre = Arc::new(Theatre::default());
    let body = Scripted::new(&component.plan, &theatre)?;
    let mut options = Options::new(component.plan.component().name.clone(), Arc::new(Nobody));
    options.clock = Clock::Staged(Arc::<Theatre>::clone(&theatre));
    options.activity_limit = component.slots;
    options.tasks = component.tasks.clone();
    options.epoch = Some(0);
    let plan = Arc::clone(&component.plan);
    // It returns when the first codels have run, which the script lets them.
    let starter = Arc::clone(&theatre);
    let starting = std::thread::spawn(move || {
        let started = Instance::start(plan, Arc::new(body), options);
        starter.started();
        started
    });
    let mut player = Player {
        plan: &component.plan,
        theatre: &theatre,
        starting: Some(starting),
        instance: None,
        before: Vec::new(),
    };
    let played = script.steps.iter().enumerate().try_for_each(|(at, step)| player.step(at, step));
    let ended = played.and_then(|()| player.instance(script.steps.len(), 0));
    let told = ended.map(|instance| instance.statistics());
    theatre.open();
    player.end();
    told
}

struct Player<'a> {
    plan: &'a Arc<Plan>,
    theatre: &'a Arc<Theatre>,
    starting: Option<JoinHandle<Result<Instance, StartError>>>,
    instance: Option<Instance>,
    /// Ticks that each task had missed before the clock came to its date.
    before: Vec<u64>,
}

impl Player<'_> {
    fn step(&mut self, number: usize, step: &Step) -> Result<(), NotPlayed> {
        let at = step.at;
        let tasks = self.plan.component().tasks.len();
        if self.starting.is_some() && self.theatre.have_begun(tasks) {
            // The thread that starts them has nothing more to wait for. It must not be late: what
            // fails from here on is no failure of the start.
            self.instance(number, at)?;
        }
        if at > self.theatre.now() {
            // What was missed before the clock came to this date.
            self.theatre.set(at - 1);
            self.before = self.theatre.missed();
            self.theatre.set(at);
        }
        if let Move::Late(task) = &step.what {
            return self.late(number, at, task);
        }
        match &step.what {
            Move::Pass(name) => self.pass(number, at, name)?,
            Move::Returns { codel, task, yields } => {
                self.returns(number, at, codel, task.as_deref(), yields)?;
            }
            Move::Request(name) => {
                let service = self.plan.service(name);
                let service = service.ok_or_else(|| no_such(number, "service", name))?;
                let input = self.input(number, service, name)?;
                // Nobody waits for the reply: what comes of it is seen of the tasks.
                self.instance(number, at)?.request(service, input, Box::new(|_| ()));
            }
            Move::Abort(activity) => {
                let abort = self.instance(number, at)?.abort(*activity);
                abort.map_err(|error| elsewhere(number, at, error.to_string()))?;
            }
            Move::Fire(name) => {
                let mut sinks = self.plan.component().sinks.iter();
                let sink = sinks.position(|sink| sink.name == *name);
                let sink = sink.ok_or_else(|| no_such(number, "event", name))?;
                let fired = self.instance(number, at)?.fire(sink);
                fired.map_err(|error| elsewhere(number, at, error.to_string()))?;
            }
            Move::Control => {
                self.instance(number, at)?;
                if !self.theatre.call(|one| *one == Waiting::Turn(Turn::Control), None) {
                    return Err(elsewhere(number, at, "control is at work".to_owned()));
                }
            }
            Move::Late(_) => {}
        }
        if self.theatre.settle() {
            return Ok(());
        }
        Err(elsewhere(number, at, "the component does not come to rest".to_owned()))
    }

    fn task(&self, number: usize, name: &str) -> Result<TaskIx, NotPlayed> {
        let task = self.plan.component().tasks.find(|task| task.name == name);
        task.ok_or_else(|| no_such(number, "task", name))
    }

    fn pass(&mut self, number: usize, at: u64, name: &str) -> Result<(), NotPlayed> {
        let own = self.task(number, name)?.index();
        let due = |one: &Waiting| match *one {
            Waiting::Turn(Turn::Pass { task, due }) if task == own => {
                due.is_none_or(|due| due <= at)
            }
            _ => false,
        };
        if self.theatre.call(due, None) {
            return Ok(());
        }
        let why = format!("task {name} does not make a pass: {}", self.whereabouts(own));
        Err(elsewhere(number, at, why))
    }

    fn returns(
        &mut self,
        number: usize,
        at: u64,
        name: &str,
        task: Option<&str>,
        yields: &str,
    ) -> Result<(), NotPlayed> {
        let task = task.map(|task| self.task(number, task)).transpose()?;
        let tasks = self.plan.component().tasks.len();
        let of = |codel: CodelIx| &self.plan.component().codels[codel].name;
        let is = |one: &Waiting| match *one {
            Waiting::Codel { codel, context } if of(codel) == name => match task {
                Some(task) => task.index() == context,
                None => context >= tasks,
            },
            _ => false,
        };
        let waits = || self.theatre.waiting().into_iter().find(|one| is(one));
        // It may be about to begin: a thread that waited for another codel.
        let Some(Waiting::Codel { codel, .. }) = waits().or_else(|| {
            self.theatre.settle();
            waits()
        }) else {
            let all: Vec<String> = (0..tasks).map(|task| self.whereabouts(task)).collect();
            let why = format!("{name} is not being executed: {}", all.join(", "));
            return Err(elsewhere(number, at, why));
        };
        let returned = self.returned(codel, yields);
        let returned = returned
            .ok_or_else(|| no_such(number, "event", &format!("{yields} that {name} may yield")))?;
        self.theatre.call(is, Some(returned));
        Ok(())
    }

    /// What a codel returns, by its name.
    fn returned(&self, codel: CodelIx, yields: &str) -> Option<Returned> {
        match yields {
            "ok" => Some(Returned::Ok),
            "exception" => Some(Returned::Failed),
            state => {
                let name = format!("{}::{state}", self.plan.component().scope());
                let event = self.plan.event(&name)?;
                let known = self.plan.transitions(codel).get(usize::from(event.0));
                known.map(|_| Returned::Event(event))
            }
        }
    }

    fn input(
        &self,
        number: usize,
        service: ServiceIx,
        name: &str,
    ) -> Result<genom_types::Record, NotPlayed> {
        let input = input_record(self.plan, service).ok().flatten();
        input.ok_or_else(|| no_such(number, "defaults of inputs of service", name))
    }

    /// The tick that comes at this date is missed, and none between the step before and this.
    fn late(&self, number: usize, at: u64, name: &str) -> Result<(), NotPlayed> {
        let task = self.task(number, name)?.index();
        let of = |missed: &[u64]| missed.get(task).copied().unwrap_or_default();
        let (before, after) = (of(&self.before), of(&self.theatre.missed()));
        if after == before + 1 {
            return Ok(());
        }
        let place = self.whereabouts(task);
        let why =
            format!("task {name} missed {} ticks then: {place}", after.saturating_sub(before));
        Err(elsewhere(number, at, why))
    }

    /// Where a task is, for people.
    fn whereabouts(&self, task: usize) -> String {
        let model = self.plan.component();
        let name = model.tasks.get(TaskIx::new(task)).map_or("", |task| task.name.as_str());
        let at = self.theatre.waiting().into_iter().find_map(|one| match one {
            Waiting::Turn(Turn::Pass { task: own, due: Some(due) }) if own == task => {
                Some(format!("waits for {due} ns"))
            }
            Waiting::Turn(Turn::Pass { task: own, due: None }) if own == task => {
                Some("waits for something to happen".to_owned())
            }
            Waiting::Codel { codel, context } if context == task => {
                Some(format!("executes {}", model.codels[codel].name))
            }
            _ => None,
        });
        format!("{name} {}", at.unwrap_or_else(|| "waits for a codel of another task".to_owned()))
    }

    /// The instance, once its start is over.
    fn instance(&mut self, number: usize, at: u64) -> Result<&Instance, NotPlayed> {
        if let Some(starting) = self.starting.take() {
            // It is over if all tasks have made their first passes, as far as the script goes.
            let end = std::time::Instant::now() + END;
            while !starting.is_finished() && std::time::Instant::now() < end {
                std::thread::yield_now();
            }
            if !starting.is_finished() {
                self.starting = Some(starting);
                let why = "the start of the component is not over".to_owned();
                return Err(elsewhere(number, at, why));
            }
            match starting.join() {
                Ok(started) => self.instance = Some(started?),
                Err(_) => {
                    let why = "the start of the component failed".to_owned();
                    return Err(elsewhere(number, at, why));
                }
            }
        }
        let why = || elsewhere(number, at, "the component did not start".to_owned());
        self.instance.as_ref().ok_or_else(why)
    }

    /// Ends the instance; everything goes on by itself.
    fn end(&mut self) {
        if let Some(starting) = self.starting.take()
            && let Ok(Ok(instance)) = starting.join()
        {
            self.instance = Some(instance);
        }
        if let Some(instance) = self.instance.take() {
            // What was played is over: how it ends is no matter.
            let _ = instance.shutdown(END);
        }
    }
}

fn no_such(step: usize, kind: &str, name: &str) -> NotPlayed {
    NotPlayed::NoSuch { step, what: format!("{kind} {name}") }
}

fn elsewhere(step: usize, at: u64, why: String) -> NotPlayed {
    NotPlayed::Elsewhere { step, at, why }
}
