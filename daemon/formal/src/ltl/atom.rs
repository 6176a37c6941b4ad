//! What formulas are about.

use crate::codels::small;
use crate::state::{Life, State};
use crate::system::System;

/// The place of a name in a list.
fn place<'n>(
    mut names: impl Iterator<Item = &'n str>,
    what: &'static str,
    name: &str,
) -> Result<u16, AtomError> {
    let at = names.position(|known| known == name).map(small);
    at.ok_or_else(|| AtomError::Unknown { what, name: name.to_owned() })
}

/// Why words are no fact.
#[derive(Debug, thiserror::Error)]
pub(super) enum AtomError {
    /// The component has nothing of that name.
    #[error("there is no {what} `{name}`")]
    Unknown { what: &'static str, name: String },
    /// The service of that name has no states.
    #[error("service {0} is no activity")]
    NoActivity(String),
    /// There is no fact of that name.
    #[error("`{0}` is none of codel, run, pending and late")]
    NoFact(String),
}

/// A fact about a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Atom {
    /// This codel is executed.
    Codel(u16),
    /// An activity of this service has begun and not ended.
    Run(u16),
    /// An activity of this service was accepted and has not begun.
    Pending(u16),
    /// A tick of this task comes while it is at work.
    Late(u16),
}

impl Atom {
    /// A fact by its name, about the thing with that name.
    pub(super) fn named(system: &System, fact: &str, name: &str) -> Result<Self, AtomError> {
        let model = system.plan.component();
        let activity = || {
            let names = model.services.iter().map(|service| service.name.as_str());
            let service = place(names, "service", name)?;
            let is = system.services[usize::from(service)].machine.is_some();
            is.then_some(service).ok_or_else(|| AtomError::NoActivity(name.to_owned()))
        };
        match fact {
            "codel" => {
                let names = model.codels.iter().map(|codel| codel.name.as_str());
                place(names, "codel", name).map(Self::Codel)
            }
            "run" => activity().map(Self::Run),
            "pending" => activity().map(Self::Pending),
            "late" => {
                let names = model.tasks.iter().map(|task| task.name.as_str());
                place(names, "task", name).map(Self::Late)
            }
            _ => Err(AtomError::NoFact(fact.to_owned())),
        }
    }

    /// Whether it is so in a state.
    pub(super) fn holds(self, system: &System, state: &State) -> bool {
        let tasks = || state.tasks.iter();
        match self {
            Self::Codel(codel) => state.lock.holders().any(|(_, node)| node == codel),
            Self::Run(service) => tasks().flat_map(|task| &task.runs).any(|run| {
                system.service_of(run) == Some(service)
                    && matches!(run.life, Life::Run | Life::Stop)
                    && run.end.is_none()
            }),
            Self::Pending(service) => {
                let sent = tasks().flat_map(|task| task.runs.iter().chain(&task.inbox));
                let mut sent = sent.filter(|run| run.life == Life::Init);
                state.pending.iter().any(|pending| pending.service == service)
                    || sent.any(|run| system.service_of(run) == Some(service))
            }
            Self::Late(task) => state.tasks[usize::from(task)].late,
        }
    }
}
