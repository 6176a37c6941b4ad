//! What each codel may return, as far as the rules distinguish it.

use genom_description::model::{CodelIx, CodelKind, Ix as _};
use genom_runtime::body::EventId;
use genom_runtime::plan::{Plan, Transition};

use crate::action::Answer;

/// A codel.
#[derive(Clone, Debug)]
pub(crate) struct Codel {
    /// What it may return by its description: its yields in order, then an exception if it may
    /// throw one.
    pub(crate) answers: Vec<Answer>,
}

/// An index in 16 bits; the plan has no more codels, states or services than these hold.
pub(crate) fn small(index: usize) -> u16 {
    u16::try_from(index).unwrap_or(u16::MAX)
}

/// The effect of a returned event by the plan's table.
pub(crate) fn answer(transition: Transition) -> Answer {
    match transition {
        Transition::Go(to) => Answer::Go(small(to.ix().index())),
        Transition::Pause(to) => Answer::Pause(small(to.ix().index())),
        Transition::Sleep(to) => Answer::Sleep(small(to.ix().index())),
        Transition::End => Answer::End,
        Transition::Throw | Transition::Bad => Answer::Fail,
    }
}

/// The effect of an event that this codel returned.
pub(crate) fn answered(plan: &Plan, codel: CodelIx, event: EventId) -> Answer {
    let table = plan.transitions(codel);
    table.get(usize::from(event.0)).copied().map_or(Answer::Fail, answer)
}

pub(crate) fn codels(plan: &Plan) -> Vec<Codel> {
    plan.component().codels.places().map(|ix| Codel { answers: answers(plan, ix) }).collect()
}

fn answers(plan: &Plan, ix: CodelIx) -> Vec<Answer> {
    let codel = &plan.component().codels[ix];
    if !matches!(codel.kind, CodelKind::Fsm { .. }) {
        // A validate or simple codel may report any exception.
        return vec![Answer::Ok, Answer::Fail];
    }
    let table = plan.transitions(ix).iter();
    let allowed = table.filter(|transition| **transition != Transition::Bad);
    let mut answers = Vec::new();
    for answer in allowed.map(|transition| answer(*transition)) {
        if !answers.contains(&answer) {
            answers.push(answer);
        }
    }
    answers
}
