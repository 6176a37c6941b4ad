//! A body whose codels return random events, and that keeps what happened.

use std::sync::{Arc, Mutex};

use genom_description::model::{CodelIx, CodelKind, Ix as _, Owner, PortIx, RemoteIx, ServiceIx};
use genom_formal::{Answer, System, Told};
use genom_middleware::{Publisher, Subscription};
use genom_runtime::body::{Body, EventId, Frame, Opener, RemoteCall, Returned};
use genom_runtime::plan::Transition;
use genom_runtime::{ActivityPhase, VirtualClock};
use genom_types::Record;
use serde_json::Value;

use super::random::Random;

/// Codels that may run at one date before they are made to end.
const MOST_CALLS: usize = 60;

/// What was seen of the runtime, or asked of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Seen {
    /// A codel ran at this date, in the context of a task or in that of a worker, for the activity
    /// with this number.
    Called { date: u64, task: Option<u16>, number: u32, codel: u16, answer: Answer },
    /// A client was told, at this date.
    Told(u64, Told),
    /// A service was requested; `abort_activity` with the number of an activity.
    Requested(u16, Option<u32>),
    /// An activity was asked to stop, at this date; whether there was one.
    Aborted { date: u64, activity: u32, found: bool },
    /// An external event was fired.
    Fired(u16),
    /// The clock shows this date, and everything that was due has been done.
    Advanced(u64),
    /// Activities that there are: number, phase, whether they were asked to stop.
    Activities(Vec<(u32, ActivityPhase, bool)>),
    /// The start-up has ended.
    Started,
    /// A shutdown begins.
    Killed,
    /// Nothing runs any more.
    Stopped,
}

/// Asks an activity to stop; tells whether there is one.
pub(crate) type Aborts = Arc<dyn Fn(u32) -> bool + Send + Sync>;

/// What the codels share.
pub(crate) struct Script {
    pub(crate) random: Random,
    pub(crate) log: Vec<Seen>,
    /// The last date at which codels ran, and how many did then.
    calls: (u64, usize),
    /// The component serves requests.
    pub(crate) started: bool,
    /// The component shuts down. A task without period that pauses then would wait for ever.
    pub(crate) stops: bool,
    /// A client that asks for aborts while codels are executed.
    pub(crate) client: Option<Aborts>,
}

impl Script {
    pub(crate) fn new(random: Random) -> Self {
        Self { random, log: Vec::new(), calls: (0, 0), started: false, stops: false, client: None }
    }
}

/// Asks an activity to stop, and keeps that this was asked.
pub(crate) fn abort(script: &Mutex<Script>, client: &Aborts, date: u64, activity: u32) {
    let asked = |found: bool| Seen::Aborted { date, activity, found };
    let place = {
        let log = &mut script.lock().unwrap().log;
        log.push(asked(false));
        log.len() - 1
    };
    // Others are told meanwhile, and write that down.
    let found = client(activity);
    script.lock().unwrap().log[place] = asked(found);
}

#[derive(Clone)]
pub(crate) struct Scripted {
    pub(crate) system: Arc<System>,
    pub(crate) script: Arc<Mutex<Script>>,
    pub(crate) clock: Arc<VirtualClock>,
    /// The date at which the instance starts.
    pub(crate) epoch: u64,
}

impl Body for Scripted {
    fn frame(&self, owner: Owner) -> Box<dyn Frame> {
        let service = match owner {
            Owner::Service(service) => service,
            Owner::Task(_) => ServiceIx::new(0),
        };
        let output = Record::new(&self.system.plan().services()[service].output);
        Box::new(ScriptedFrame { body: self.clone(), number: 0, output })
    }

    fn bind_out(&self, _: PortIx, _: Option<&str>, _: Option<Box<dyn Publisher>>) {}
    fn bind_in(&self, _: PortIx, _: Option<&str>, _: Option<Box<dyn Subscription>>) {}
    fn bind_remote(&self, _: RemoteIx, _: Option<Box<dyn RemoteCall>>) {}
    fn set_opener(&self, _: Box<dyn Opener>) {}
    fn port_value(&self, _: PortIx, _: Option<&str>) -> Option<Value> {
        None
    }
    fn write_port(&self, _: PortIx, _: &Record) {}
}

struct ScriptedFrame {
    body: Scripted,
    number: u32,
    output: Record,
}

impl ScriptedFrame {
    /// Mostly an event that the codel may return, seldom another one. Where an activity could go on
    /// for ever without time passing, it is made to end.
    fn choose(&self, script: &mut Script, codel: CodelIx, task: Option<usize>) -> Returned {
        let system = &self.body.system;
        let plan = system.plan();
        let model = &plan.component().codels[codel];
        if !matches!(model.kind, CodelKind::Fsm { .. }) {
            return if script.random.percent(85) { Returned::Ok } else { Returned::Failed };
        }
        let table = plan.transitions(codel).iter().zip(0u16..);
        // Clients could not tell a codel that throws this from a stop request.
        let interrupted = plan.event("::genom::interrupted");
        let allowed: Vec<(Transition, EventId)> = table
            .filter(|(to, id)| **to != Transition::Bad && Some(EventId(*id)) != interrupted)
            .map(|(to, id)| (*to, EventId(id)))
            .collect();
        let aperiodic = task.is_some_and(|task| system.periods()[task].is_none());
        let too_many = script.calls.1 > MOST_CALLS;
        if too_many || (script.stops && aperiodic) {
            let end = allowed.iter().find(|(to, _)| *to == Transition::End);
            return end.map_or(Returned::Failed, |(_, id)| Returned::Event(*id));
        }
        let permanent = matches!(model.owner, Owner::Task(_));
        if script.random.percent(if permanent { 1 } else { 6 }) {
            let events = plan.events().len();
            let any = EventId(u16::try_from(script.random.below(events)).unwrap());
            let any = if Some(any) == interrupted { EventId(0) } else { any };
            let odd = [Returned::Ok, Returned::Failed, Returned::Unknown, Returned::Event(any)];
            return *script.random.one(&odd);
        }
        let may_throw = allowed.iter().any(|(to, _)| *to == Transition::Throw);
        let throws = may_throw && script.random.percent(if permanent { 1 } else { 5 });
        let kind = |(to, _): &&(Transition, EventId)| (*to == Transition::Throw) == throws;
        let of_kind: Vec<_> = allowed.iter().filter(kind).collect();
        Returned::Event(script.random.one(&of_kind).1)
    }

    /// At times a client asks this or another activity to stop while its codel is executed: what
    /// comes of it in the same cycle is seen.
    fn interfere(&self, date: u64) {
        let mut script = self.body.script.lock().unwrap();
        let busy = script.started && !script.stops;
        let asks = busy && script.random.percent(8);
        let Some(client) = script.client.clone().filter(|_| asks) else { return };
        let other = 1 + u32::try_from(script.random.below(12)).unwrap();
        let activity = if script.random.percent(60) { self.number } else { other };
        drop(script);
        abort(&self.body.script, &client, date, activity);
    }
}

impl Frame for ScriptedFrame {
    fn begin(&mut self, _: &Record) {
        self.number = 0;
    }

    fn number(&mut self, activity: u32) {
        self.number = activity;
    }

    fn store(&mut self) {}
    fn fetch(&mut self) {}

    fn call(&mut self, codel: CodelIx, context: usize) -> Returned {
        let date = self.body.clock.now() - self.body.epoch;
        let system = &self.body.system;
        let task = Some(context).filter(|context| *context < system.periods().len());
        if task.is_some() {
            self.interfere(date);
        }
        let mut script = self.body.script.lock().unwrap();
        let before = if script.calls.0 == date { script.calls.1 } else { 0 };
        script.calls = (date, before + 1);
        let returned = self.choose(&mut script, codel, task);
        let in_machine = task.is_some();
        let answer = match returned {
            Returned::Event(event) if in_machine => system.answer(codel, event),
            Returned::Ok if !in_machine => Answer::Ok,
            _ => Answer::Fail,
        };
        // A permanent activity that fails at the start ends the component.
        script.stops |= answer == Answer::Fail && !script.started;
        script.log.push(Seen::Called {
            date,
            task: task.map(|task| u16::try_from(task).unwrap()),
            number: self.number,
            codel: u16::try_from(codel.index()).unwrap(),
            answer,
        });
        returned
    }

    fn returned(&self) -> String {
        "::unknown".into()
    }

    fn detail(&self) -> Option<Value> {
        None
    }

    fn output(&self) -> &Record {
        &self.output
    }
}
