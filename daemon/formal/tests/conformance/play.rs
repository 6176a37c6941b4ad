//! A random run of the runtime on a stepped clock.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_description::model::{Ix as _, ServiceIx};
use genom_description::{Options as Reading, read_text};
use genom_formal::{Bounds, End, System, Told, Variant};
use genom_runtime::plan::Builtin;
use genom_runtime::{
    Clock, ConnectionError, Exception, Instance, Options, Outcome, Plan, Progress, Supervision,
    VirtualClock, input_record,
};
use serde_json::json;

use super::body::{Aborts, Script, Scripted, Seen, abort};
use super::components::component;
use super::random::Random;

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

/// A run: the component, its limit on activities, and what was seen.
pub(crate) struct Played {
    pub(crate) text: String,
    pub(crate) plan: Arc<Plan>,
    pub(crate) slots: usize,
    pub(crate) log: Vec<Seen>,
}

impl Played {
    /// The system that should accept the run, or one with a changed rule.
    pub(crate) fn system(&self, variant: Option<Variant>) -> System {
        let bounds = Bounds { slots: self.slots, ..Bounds::default() };
        System::with(&self.plan, bounds, variant)
    }
}

/// The plan of a description.
pub(crate) fn plan(text: &str) -> Arc<Plan> {
    let analysis = read_text("random.gen", text, &Reading::default());
    assert!(!analysis.has_errors(), "{text}\n{:#?}", analysis.diagnostics);
    Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap())
}

/// The run of this seed: always the same.
pub(crate) fn play(seed: u64) -> Played {
    play_with(seed, component, |_, _| {})
}

/// The same of a component described in this way, and of an instance with other options.
pub(crate) fn play_with(
    seed: u64,
    describe: impl FnOnce(&mut Random) -> String,
    set: impl FnOnce(&Plan, &mut Options),
) -> Played {
    let mut random = Random(seed);
    let text = describe(&mut random);
    let plan = plan(&text);
    let slots = 1 + random.below(4);
    let commands = random.below(50);
    let clock = Arc::new(VirtualClock::new());
    clock.step(Duration::from_millis(random.below(9).try_into().unwrap()));
    let script = Arc::new(Mutex::new(Script::new(Random(seed ^ 0x5eed))));
    let system = Arc::new(System::new(&plan, Bounds::default()));
    let (epoch, shared) = (clock.now(), Arc::clone(&clock));
    let body = Scripted { system, script: Arc::clone(&script), clock: shared, epoch };
    let mut options = Options::new("demo", Arc::new(Nobody));
    options.clock = Clock::Virtual(Arc::clone(&clock));
    options.activity_limit = slots;
    set(&plan, &mut options);
    let seen = |what: Seen| script.lock().unwrap().log.push(what);
    let mut hangs = None;
    if let Ok(instance) = Instance::start(Arc::clone(&plan), Arc::new(body), options) {
        seen(Seen::Started);
        let instance = Arc::new(instance);
        let weak = Arc::downgrade(&instance);
        let client: Aborts = Arc::new(move |activity| {
            weak.upgrade().is_some_and(|instance| instance.abort(activity).is_ok())
        });
        {
            let mut script = script.lock().unwrap();
            (script.started, script.client) = (true, Some(Arc::clone(&client)));
        }
        for _ in 0..commands {
            command(&mut random, (&instance, &client), &clock, epoch, &script);
            let list = instance.activities().into_iter();
            let list = list.map(|a| (a.id, a.phase, a.stopped_by.is_some()));
            seen(Seen::Activities(list.collect()));
        }
        let killed = script.lock().unwrap().log.len();
        seen(Seen::Killed);
        script.lock().unwrap().stops = true;
        // This thread does all that is to be done: there is nothing to wait for.
        hangs = instance.shutdown(Duration::ZERO).is_err().then_some(killed);
    }
    seen(Seen::Stopped);
    let mut log = std::mem::take(&mut script.lock().unwrap().log);
    if let Some(killed) = hangs {
        // An activity that was asked to stop sleeps, and gets no event: what the runtime does when a
        // shutdown takes too long is no matter of the model.
        log.truncate(killed);
    }
    Played { text, plan, slots, log }
}

/// A request, an abort, an external event or a step of the clock.
fn command(
    random: &mut Random,
    (instance, client): (&Instance, &Aborts),
    clock: &Arc<VirtualClock>,
    epoch: u64,
    script: &Arc<Mutex<Script>>,
) {
    let seen = |what: Seen| script.lock().unwrap().log.push(what);
    let plan = instance.plan();
    let activity = 1 + u32::try_from(random.below(12)).unwrap();
    match random.below(10) {
        0..4 => request(random, instance, activity, (clock, epoch), script),
        4 => abort(script, client, clock.now() - epoch, activity),
        5 if !plan.component().sinks.is_empty() => {
            let sink = random.below(plan.component().sinks.len());
            seen(Seen::Fired(u16::try_from(sink).unwrap()));
            instance.fire(sink).unwrap();
        }
        _ => {
            clock.step(Duration::from_millis(random.below(12).try_into().unwrap()));
            seen(Seen::Advanced(clock.now() - epoch));
        }
    }
}

fn request(
    random: &mut Random,
    instance: &Instance,
    activity: u32,
    (clock, epoch): (&Arc<VirtualClock>, u64),
    script: &Arc<Mutex<Script>>,
) {
    let plan = instance.plan();
    let served = |service: &ServiceIx| {
        matches!(plan.services()[*service].builtin, None | Some(Builtin::AbortActivity))
    };
    let services: Vec<ServiceIx> = plan.services().places().filter(served).collect();
    let service = *random.one(&services);
    let aborts = plan.services()[service].builtin.is_some();
    let mut input = input_record(plan, service).unwrap().unwrap();
    if aborts {
        input.merge_json(&json!({ "activity": activity })).unwrap();
    }
    let (number, replies) = (u16::try_from(service.index()).unwrap(), Arc::clone(script));
    replies.lock().unwrap().log.push(Seen::Requested(number, aborts.then_some(activity)));
    let (mut accepted, clock) = (None, Arc::clone(clock));
    let reply = Box::new(move |progress| {
        let told = match progress {
            Progress::Accepted { activity } => {
                accepted = Some(activity);
                Told::Accepted(activity)
            }
            Progress::Ended(outcome) => match accepted {
                Some(activity) => Told::Ended(activity, end(&outcome)),
                None => Told::Answered(number, refused(&outcome)),
            },
        };
        let date = clock.now() - epoch;
        replies.lock().unwrap().log.push(Seen::Told(date, told));
    });
    instance.request(service, input, reply);
}

fn end(outcome: &Outcome) -> End {
    match outcome {
        Outcome::Success(_) => End::Success,
        Outcome::Exception(Exception { name, .. }) if name == "::genom::interrupted" => {
            End::Interrupted
        }
        Outcome::Exception(_) => End::Failed,
    }
}

/// How a request ended that was not accepted as an activity.
fn refused(outcome: &Outcome) -> End {
    if matches!(outcome, Outcome::Success(_)) { End::Success } else { End::Failed }
}
