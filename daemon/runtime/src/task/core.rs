//! The rules of one task: which activity runs which codel next (genom3.md 7.4, 7.5).
//!
//! It handles states, codels, stop requests and external events, but no threads, clocks or
//! exclusion: the caller says when a pass is due, and calls the codels.

use genom_description::model::{CodelIx, Owner, StateIx};

use super::run::{Bad, Mode, Run, RunOutcome, Status, Token};
use crate::body::Returned;
use crate::plan::{Plan, Transition};

/// Callbacks of the rules.
pub(crate) trait Calls {
    /// Runs a codel of this run.
    fn call(&mut self, run: &mut Run, codel: CodelIx) -> Returned;
    /// A token of this run moved, or paused in the state where it was.
    fn moved(&mut self, run: &Run, token: Token);
    /// This run begins.
    fn begins(&mut self, _run: &Run) {}
    /// A codel of this run yielded another state than its own, or its end: `ether`.
    fn stepped(&mut self, _run: &Run, _from: StateIx, _to: StateIx) {}
    /// A codel yielded a state without pause.
    fn goes_on(&mut self, _codel: CodelIx) {}
}

/// Result of a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Passed {
    /// A codel yielded a state without pause: the next pass is due at once.
    pub(crate) again: bool,
    /// Something happened that others may wait for: all tasks have to be woken.
    pub(crate) moved: bool,
}

/// The activities of one task.
#[derive(Debug)]
pub(crate) struct Core {
    /// In order of start, in which codels run. Boxed, so that control and task exchange them
    /// without copying.
    #[allow(clippy::vec_box)]
    runs: Vec<Box<Run>>,
    /// One transition of each token per tick (dialects.md A).
    by_period: bool,
}

impl Core {
    pub(crate) fn new(room: usize, by_period: bool) -> Self {
        Self { runs: Vec::with_capacity(room), by_period }
    }

    /// Adds a run, which starts at the next pass that allows it.
    pub(crate) fn admit(&mut self, run: Box<Run>) {
        self.runs.push(run);
    }

    /// The activities, in order of start.
    pub(crate) fn runs(&self) -> impl Iterator<Item = &Run> {
        self.runs.iter().map(AsRef::as_ref)
    }

    /// The run of this machine.
    pub(crate) fn run_of(&mut self, machine: usize) -> Option<&mut Run> {
        self.runs.iter_mut().map(AsMut::as_mut).find(|run| run.machine == machine)
    }

    /// Drops all activities.
    pub(crate) fn clear(&mut self) {
        self.runs.clear();
    }

    /// Drops these activities, and lets the others do nothing more before they are asked to stop.
    pub(crate) fn retire(&mut self, moved: &[u32]) {
        self.runs.retain(|run| !moved.contains(&run.id));
        let tokens = self.runs.iter_mut().flat_map(|run| &mut run.tokens);
        tokens.for_each(|token| token.mode = Mode::Asleep);
    }

    /// Whether there is no activity.
    pub(crate) fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// One pass: starts, stops and resumes activities that are due, then each activity runs one
    /// codel for each of its active tokens.
    pub(crate) fn pass(
        &mut self,
        plan: &Plan,
        runnable: bool,
        fired: &[StateIx],
        calls: &mut impl Calls,
    ) -> Passed {
        for run in &mut self.runs {
            // Events first: they affect activities that were active when they were fired.
            fired.iter().for_each(|state| fire(run, plan, *state, calls));
            prepare(run, plan, runnable, calls);
        }
        let mut passed = Passed::default();
        for run in &mut self.runs {
            if run.outcome.is_none() {
                step(run, plan, self.by_period, calls, &mut passed);
            }
            passed.moved |= run.outcome.is_some();
        }
        passed
    }

    /// Hands over the runs that have ended, in order.
    pub(crate) fn take_ended(&mut self, mut take: impl FnMut(Box<Run>)) {
        let mut at = 0;
        while at < self.runs.len() {
            if self.runs[at].outcome.is_some() {
                take(self.runs.remove(at));
            } else {
                at += 1;
            }
        }
    }
}

/// Starts, stops or resumes an activity before codels run (genom3.md 7.4, step 2).
fn prepare(run: &mut Run, plan: &Plan, runnable: bool, calls: &mut impl Calls) {
    let machine = &plan.machines()[run.machine];
    let permanent = matches!(machine.owner, Owner::Task(_));
    let ready = |state| Token { state, mode: Mode::Ready };
    match run.marker.status() {
        Status::Cancelled => run.outcome = Some(RunOutcome::Cancelled),
        Status::Init if run.at_stop && runnable => {
            run.marker.set(Status::Stop);
            calls.begins(run);
            enter(run, ready(machine.stop), machine.codel(machine.stop).is_some(), calls);
        }
        Status::Init if runnable => {
            if run.marker.leave_init(Status::Run) {
                calls.begins(run);
                enter(run, ready(machine.start), machine.codel(machine.start).is_some(), calls);
            } else {
                run.outcome = Some(RunOutcome::Cancelled);
            }
        }
        Status::Run if run.marker.stop_requested() => {
            run.marker.set(Status::Stop);
            run.at_stop = true;
            let stops = machine.codel(machine.stop).is_some();
            enter(run, ready(machine.stop), stops, calls);
            if !stops && !permanent {
                run.outcome = Some(RunOutcome::Interrupted);
            }
        }
        Status::Run | Status::Stop if runnable => {
            let paused = run.tokens.iter_mut().filter(|token| token.mode == Mode::Paused);
            paused.for_each(|token| token.mode = Mode::Ready);
        }
        _ => {}
    }
}

/// Makes `token` the whole marking; if its state has no codel, the run ends with success.
fn enter(run: &mut Run, token: Token, has_codel: bool, calls: &mut impl Calls) {
    run.tokens.clear();
    if has_codel {
        run.tokens.push(token);
        // `start` is shown from the beginning; a move to `stop` has to be reported to watchers.
        if run.marker.show(token) {
            calls.moved(run, token);
        }
    } else {
        run.outcome = Some(RunOutcome::Success);
    }
}

/// An external event puts a ready token in its state, which replaces sleeping ones (dialects.md A).
fn fire(run: &mut Run, plan: &Plan, state: StateIx, calls: &mut impl Calls) {
    let active = matches!(run.marker.status(), Status::Run | Status::Stop);
    if !active || run.outcome.is_some() || plan.machines()[run.machine].codel(state).is_none() {
        return;
    }
    run.tokens.retain(|token| token.mode != Mode::Asleep);
    match run.tokens.iter_mut().find(|token| token.state == state) {
        Some(token) => token.mode = Mode::Ready,
        // The capacity is sufficient: no two tokens are in one state here.
        None => {
            let token = Token { state, mode: Mode::Ready };
            run.tokens.push(token);
            if run.marker.show(token) {
                calls.moved(run, token);
            }
        }
    }
}

/// Runs the codel of each active token once and takes its transition (genom3.md 7.5).
fn step(run: &mut Run, plan: &Plan, by_period: bool, calls: &mut impl Calls, passed: &mut Passed) {
    let mut ran = false;
    for at in 0..run.tokens.len() {
        let Token { state, mode } = run.tokens[at];
        if mode != Mode::Ready {
            continue;
        }
        ran = true;
        let Some(codel) = plan.machines()[run.machine].codel(state) else {
            run.outcome = Some(RunOutcome::Bad { from: state, to: Bad::Ok });
            return;
        };
        let returned = calls.call(run, codel);
        let token = match returned {
            Returned::Event(event) => {
                let table = plan.transitions(codel);
                match table.get(usize::from(event.0)).copied().unwrap_or(Transition::Bad) {
                    Transition::Go(to) if by_period => Token { state: to.ix(), mode: Mode::Paused },
                    Transition::Go(to) => {
                        calls.goes_on(codel);
                        passed.again = true;
                        passed.moved = true;
                        Token { state: to.ix(), mode: Mode::Ready }
                    }
                    Transition::Pause(to) => Token { state: to.ix(), mode: Mode::Paused },
                    Transition::Sleep(to) => Token { state: to.ix(), mode: Mode::Asleep },
                    Transition::End => {
                        if let Some(to) = plan.state_of(event) {
                            calls.stepped(run, state, to);
                        }
                        Token { state, mode: Mode::Done }
                    }
                    Transition::Throw => {
                        run.outcome = Some(RunOutcome::Thrown(event));
                        return;
                    }
                    Transition::Bad => {
                        run.outcome = Some(RunOutcome::Bad { from: state, to: Bad::Event(event) });
                        return;
                    }
                }
            }
            Returned::Failed => {
                run.outcome = Some(RunOutcome::Failed);
                return;
            }
            Returned::Ok | Returned::Unknown => {
                let to = if returned == Returned::Ok { Bad::Ok } else { Bad::Unknown };
                run.outcome = Some(RunOutcome::Bad { from: state, to });
                return;
            }
        };
        run.tokens[at] = token;
        if token.state != state {
            calls.stepped(run, state, token.state);
        }
        if token.mode != Mode::Done {
            // Only changes are reported to watchers: a further pause in the same state is none.
            if run.marker.show(token) {
                calls.moved(run, token);
            }
        }
    }
    if ran {
        merge(&mut run.tokens);
        if run.tokens.is_empty() {
            run.outcome = Some(RunOutcome::Success);
        }
    }
}

/// Removes finished tokens and merges those in the same state.
fn merge(tokens: &mut Vec<Token>) {
    tokens.retain(|token| token.mode != Mode::Done);
    let mut at = 1;
    while at < tokens.len() {
        let token = tokens[at];
        match tokens[..at].iter_mut().find(|other| other.state == token.state) {
            Some(other) => {
                other.mode = other.mode.max(token.mode);
                tokens.remove(at);
            }
            None => at += 1,
        }
    }
}
