//! Requests: validation, attributes, functions, and the start of activities (genom3.md 7.3).
//!
//! Requests of one service are served in order, those of different services in parallel: a codel
//! that blocks delays only what conflicts with it.

use std::sync::Arc;

use genom_description::model::{CodelIx, ServiceIx, ServiceKind};
use genom_types::Record;
use serde_json::{Value, json};

use super::{Afterwards, Asker, Control, Phase, Request, genom, interrupted};
use crate::api::{Exception, Inputs, Outcome, Partial, Progress, Reply};
use crate::body::{Frame, Returned};
use crate::engine::Engine;
use crate::lock::Guard;
use crate::rules::Happening;
use crate::ticket::Ticket;

/// How often partial inputs are completed anew because codels changed the IDS meanwhile. After
/// that, the request overwrites the change, as one with all inputs does.
const ROUNDS: u32 = 16;

/// Result of a request that did not fail.
enum Performed {
    /// The outputs of an attribute or function.
    Done(Record),
    /// An activity that was validated and has a slot.
    Validated(Box<dyn Frame>),
}

impl Engine {
    /// Queues a request; on a virtual clock it is served at once, on this thread.
    pub(crate) fn submit(
        self: &Arc<Self>,
        service: ServiceIx,
        inputs: Inputs,
        mut reply: Reply,
        ticket: Ticket,
    ) {
        let Some(compiled) = self.shared.plan.services().get(service) else {
            return reply(refused(genom("no_such_service", Value::Null)));
        };
        let fits = match &inputs {
            Inputs::Whole(input) => input.ty().same_as(&compiled.input),
            Inputs::Partial(_) | Inputs::Look => compiled.kind == ServiceKind::Attribute,
        };
        if !fits {
            return reply(refused(genom("serialization", Value::Null)));
        }
        {
            let mut control = self.lock();
            if matches!(control.phase, Phase::Stopping | Phase::Stopped) {
                drop(control);
                return reply(refused(interrupted("kill")));
            }
            let queue = &mut control.services[service];
            queue.waiting.push_back(Request { inputs, reply, ticket });
            if !queue.busy && queue.waiting.len() == 1 {
                control.ready.push_back(service);
            }
        }
        self.find_worker();
    }

    /// Withdraws a request that has not begun; `false` when it has.
    pub(crate) fn withdraw(&self, service: ServiceIx, ticket: &Ticket) -> bool {
        if !ticket.give_up() {
            return false;
        }
        let given_up = {
            let mut control = self.lock();
            let waiting = &mut control.services[service].waiting;
            let place = waiting.iter().position(|request| request.ticket.is(ticket));
            place.and_then(|place| waiting.remove(place))
        };
        // Dropped without the lock, since that drops the reply, whose code is not known here.
        drop(given_up);
        true
    }

    /// Serves the oldest request of a service that is ready; unlocks meanwhile.
    pub(crate) fn serve_one<'a>(
        &'a self,
        mut control: Guard<'a, Control>,
        service: ServiceIx,
        context: usize,
    ) -> Guard<'a, Control> {
        let queue = &mut control.services[service];
        let Some(request) = queue.waiting.pop_front() else { return control };
        let Request { inputs, reply, ticket } = request;
        let asker = Asker::new(reply);
        queue.busy = true;
        queue.asker = Some(asker.clone());
        control.serving += 1;
        drop(control);
        self.serve(service, inputs, &asker, &ticket, context);
        let mut control = self.lock();
        control.serving -= 1;
        let queue = &mut control.services[service];
        queue.busy = false;
        queue.asker = None;
        if !queue.waiting.is_empty() {
            control.ready.push_back(service);
        }
        if control.step.is_some() {
            // A shutdown waits for this.
            self.shared.wake_control();
        }
        self.quiet.notify_all();
        control
    }

    fn serve(
        &self,
        service: ServiceIx,
        mut inputs: Inputs,
        asker: &Asker,
        ticket: &Ticket,
        context: usize,
    ) {
        if let Inputs::Look = inputs {
            let now = self.look(service, context);
            return answer(asker, Progress::Ended(Outcome::Success(now)));
        }
        let performed = self.perform(service, &mut inputs, context, ticket);
        // genom3.md 7.3.8: something happened in the component, whatever the outcome.
        self.shared.wake_tasks();
        match performed {
            Err(exception) => answer(asker, refused(exception)),
            Ok(Performed::Done(output)) => {
                self.interrupt_from(service);
                answer(asker, Progress::Ended(Outcome::Success(output)));
            }
            Ok(Performed::Validated(frame)) => match asker.take() {
                Some(reply) => self.accept(service, frame, reply),
                // A shutdown has answered the request: it does not start any more.
                None => {
                    self.release_slot(service);
                    self.give_frame(service, frame);
                }
            },
        }
    }

    /// genom3.md 7.3.10: an attribute or function interrupts without waiting, and counts as run.
    fn interrupt_from(&self, service: ServiceIx) {
        let mut after = Afterwards::default();
        {
            let mut control = self.lock();
            control.services[service].ran = true;
            self.interrupt(&mut control, service, None, &mut after);
            self.examine(&mut control, &mut after);
        }
        self.finish_off(after);
    }

    fn perform(
        &self,
        service: ServiceIx,
        inputs: &mut Inputs,
        context: usize,
        ticket: &Ticket,
    ) -> Result<Performed, Exception> {
        let compiled = &self.shared.plan.services()[service];
        let activity = compiled.kind == ServiceKind::Activity;
        if activity {
            self.take_slot(service)?;
        }
        let performed = self.perform_with_slot(service, inputs, context, ticket);
        if activity && performed.is_err() {
            self.release_slot(service);
        }
        performed
    }

    fn perform_with_slot(
        &self,
        service: ServiceIx,
        inputs: &mut Inputs,
        context: usize,
        ticket: &Ticket,
    ) -> Result<Performed, Exception> {
        let compiled = &self.shared.plan.services()[service];
        self.check_order(service)?;
        if let (Some(builtin), Inputs::Whole(input)) = (compiled.builtin, &*inputs) {
            begin(ticket)?;
            self.builtin(builtin, input)?;
            return Ok(Performed::Done(Record::new(&compiled.output)));
        }
        let mut frame = self.take_frame(service);
        match self.run_codels(service, frame.as_mut(), inputs, context, ticket) {
            Err(exception) => {
                self.give_frame(service, frame);
                Err(exception)
            }
            Ok(()) if compiled.kind == ServiceKind::Activity => Ok(Performed::Validated(frame)),
            Ok(()) => {
                let output = frame.output().clone();
                self.give_frame(service, frame);
                Ok(Performed::Done(output))
            }
        }
    }

    /// genom3.md 7.3.1: an activity needs a slot of its task.
    fn take_slot(&self, service: ServiceIx) -> Result<(), Exception> {
        let Some(task) = self.shared.plan.services()[service].task else { return Ok(()) };
        let mut control = self.lock();
        if control.links[task].used >= self.activity_limit {
            return Err(genom("too_many_activities", Value::Null));
        }
        control.links[task].used += 1;
        Ok(())
    }

    fn release_slot(&self, service: ServiceIx) {
        if let Some(task) = self.shared.plan.services()[service].task {
            self.lock().links[task].used -= 1;
        }
    }

    /// genom3.md 7.3.3, 7.6: `before` and `after` are checked at request time only.
    fn check_order(&self, service: ServiceIx) -> Result<(), Exception> {
        let model = &self.shared.plan.component().services[service];
        let control = self.lock();
        let ran = |other: &ServiceIx| control.services[*other].ran;
        let allowed = model.after.iter().all(ran) && !model.before.iter().any(ran);
        if allowed { Ok(()) } else { Err(genom("disallowed", Value::Null)) }
    }

    /// genom3.md 7.3.5 to 7.3.7: validation, transfers, simple codels.
    fn run_codels(
        &self,
        service: ServiceIx,
        frame: &mut dyn Frame,
        inputs: &mut Inputs,
        context: usize,
        ticket: &Ticket,
    ) -> Result<(), Exception> {
        let plan = &self.shared.plan;
        let compiled = &plan.services()[service];
        let node = plan.nodes().transfer(service);
        let mut seen = None;
        match inputs {
            Inputs::Whole(input) => frame.begin(input),
            Inputs::Partial(fill) => {
                let mut now = Record::new(&compiled.input);
                let permit = self.shared.exclusion.enter(context, node);
                frame.current(&mut now);
                drop(permit);
                complete(frame, fill, &now)?;
                seen = Some(now);
            }
            Inputs::Look => {}
        }
        self.validate(service, frame, context, ticket)?;
        let executed = compiled.kind != ServiceKind::Activity;
        if executed {
            self.happens(Happening::Start(service), 0);
        }
        let done = self.execute(service, frame, (inputs, seen), context, ticket);
        if executed {
            self.happens(Happening::End(service), 0);
        }
        done
    }

    /// genom3.md 7.3.6, 7.3.7: what follows validation.
    fn execute(
        &self,
        service: ServiceIx,
        frame: &mut dyn Frame,
        (inputs, seen): (&mut Inputs, Option<Record>),
        context: usize,
        ticket: &Ticket,
    ) -> Result<(), Exception> {
        let plan = &self.shared.plan;
        let (model, compiled) = (&plan.component().services[service], &plan.services()[service]);
        let node = plan.nodes().transfer(service);
        if compiled.through_ids {
            self.transfer(service, frame, (inputs, seen), context, ticket)?;
        }
        if compiled.kind == ServiceKind::Activity {
            return begin(ticket);
        }
        for &codel in &model.codels {
            match self.call(frame, codel, context, ticket)? {
                Returned::Ok => {}
                returned => return Err(self.filtered(service, frame, returned)),
            }
        }
        if compiled.through_ids && compiled.kind == ServiceKind::Function {
            let _permit = self.shared.exclusion.enter(context, node);
            frame.fetch();
        }
        Ok(())
    }

    /// The values of the IDS where an attribute stores its inputs.
    fn look(&self, service: ServiceIx, context: usize) -> Record {
        let plan = &self.shared.plan;
        let mut now = Record::new(&plan.services()[service].input);
        let mut frame = self.take_frame(service);
        let permit = self.shared.exclusion.enter(context, plan.nodes().transfer(service));
        frame.current(&mut now);
        drop(permit);
        self.give_frame(service, frame);
        now
    }

    fn validate(
        &self,
        service: ServiceIx,
        frame: &mut dyn Frame,
        context: usize,
        ticket: &Ticket,
    ) -> Result<(), Exception> {
        for &codel in &self.shared.plan.component().services[service].validates {
            match self.call(frame, codel, context, ticket)? {
                Returned::Ok => {}
                // Reported even if not declared: exceptions of validation are not filtered.
                returned => return Err(self.as_it_is(frame, returned)),
            }
        }
        Ok(())
    }

    /// genom3.md 7.3.6. Inputs that were completed with values `seen` in the IDS are completed and
    /// validated again when codels changed these meanwhile, so that members that the request omits
    /// keep what the codels wrote.
    fn transfer(
        &self,
        service: ServiceIx,
        frame: &mut dyn Frame,
        (inputs, mut seen): (&mut Inputs, Option<Record>),
        context: usize,
        ticket: &Ticket,
    ) -> Result<(), Exception> {
        let compiled = &self.shared.plan.services()[service];
        let node = self.shared.plan.nodes().transfer(service);
        for round in 0.. {
            // Allocated before the exclusion is entered.
            let now = seen.as_ref().map(|seen| Record::new(seen.ty()));
            let permit = self.shared.exclusion.enter(context, node);
            begin(ticket)?;
            if let (Inputs::Partial(fill), Some(before), Some(mut now)) = (&mut *inputs, &seen, now)
                && round < ROUNDS
            {
                frame.current(&mut now);
                if !now.holds_same(before) {
                    drop(permit);
                    complete(frame, fill, &now)?;
                    self.validate(service, frame, context, ticket)?;
                    seen = Some(now);
                    continue;
                }
            }
            frame.store();
            if compiled.kind == ServiceKind::Attribute {
                frame.fetch();
            }
            break;
        }
        Ok(())
    }

    fn call(
        &self,
        frame: &mut dyn Frame,
        codel: CodelIx,
        context: usize,
        ticket: &Ticket,
    ) -> Result<Returned, Exception> {
        let shared = &self.shared;
        let permit = shared.exclusion.enter(context, shared.plan.nodes().codel(codel));
        begin(ticket)?;
        let called = shared.clock.now();
        shared.calls(codel, |rule, fact| self.violated_aside(rule, fact));
        let bound = shared.rules.bound(codel);
        if bound.called.others {
            let what = (Happening::Call(codel), 0, called);
            shared.rules.hear_elsewhere(what, |seen| self.seen_aside(seen));
        }
        let (at_work, since) = (&shared.at_work[context], shared.clock.real(called));
        at_work.begins(codel, 0, since);
        let returned = frame.call(codel, context);
        at_work.ends();
        if bound.returns.others || bound.writes {
            let (now, aside) = (shared.clock.now(), |seen| self.seen_aside(seen));
            shared.rules.wrote(shared.body.as_ref(), codel, 0, now, None, aside);
            shared.rules.hear_elsewhere((Happening::Return(codel), 0, now), aside);
        }
        drop(permit);
        let ns = shared.clock.now().saturating_sub(called);
        let call = (context, since);
        shared.called(codel, (returned, ns), call, |rule, fact| self.violated_aside(rule, fact));
        Ok(returned)
    }

    /// The exception that a codel returned, unfiltered.
    fn as_it_is(&self, frame: &dyn Frame, returned: Returned) -> Exception {
        let detail = frame.detail().unwrap_or(Value::Null);
        match returned {
            Returned::Event(event) => {
                Exception { name: self.shared.plan.event_name(event).to_owned(), detail }
            }
            Returned::Failed => genom("unkex", detail),
            Returned::Unknown | Returned::Ok => Exception { name: frame.returned(), detail },
        }
    }

    /// genom3.md 7.3.7: an exception that the function does not declare becomes `unkex`, with its
    /// name.
    fn filtered(&self, service: ServiceIx, frame: &dyn Frame, returned: Returned) -> Exception {
        let throws = &self.shared.plan.services()[service].throws;
        let exception = self.as_it_is(frame, returned);
        match returned {
            Returned::Event(event) if throws.contains(event) => exception,
            Returned::Failed => exception,
            _ => genom("unkex", json!({ "what": exception.name })),
        }
    }
}

/// Answers the request, unless a shutdown did.
fn answer(asker: &Asker, progress: Progress) {
    if let Some(mut reply) = asker.take() {
        reply(progress);
    }
}

fn refused(exception: Exception) -> Progress {
    Progress::Ended(Outcome::Exception(exception))
}

/// Begins the run with the current values of the IDS, overwritten by what the request gives.
fn complete(frame: &mut dyn Frame, fill: &mut Partial, now: &Record) -> Result<(), Exception> {
    let mut input = now.clone();
    fill(&mut input)?;
    frame.begin(&input);
    Ok(())
}

/// Marks the request as begun, unless its sender gave it up.
fn begin(ticket: &Ticket) -> Result<(), Exception> {
    if ticket.begin() { Ok(()) } else { Err(interrupted("client")) }
}
