//! In whose thread something happens.

use genom_description::model::{
    CodelIx, CodelKind, Component, Direction, Owner, PortIx, ServiceIx, Source, TaskIx,
};

use crate::happening::Happening;

/// Tells in whose thread something happens in an instance.
#[derive(Clone, Copy, Debug)]
pub struct Places<'m> {
    /// Its component.
    pub model: &'m Component,
    /// The instance goes on from another one: whoever resumes it tells what services did there.
    pub resumes: bool,
}

impl Places<'_> {
    /// The task in whose thread this happens always; `None` if it may happen elsewhere.
    #[must_use]
    pub fn of(self, what: Happening) -> Option<TaskIx> {
        match what {
            Happening::Call(codel) | Happening::Return(codel) => self.calls(codel),
            Happening::Start(service) | Happening::End(service) => {
                self.model.services.get(service)?.task.filter(|_| !self.resumes)
            }
            Happening::Write(port) => self.writes(port),
            Happening::Cycle(task) => Some(task),
            Happening::Accept(_) | Happening::Stop(_) | Happening::Fire(_) => None,
        }
    }

    /// The only task in whose thread all of this happens.
    pub fn of_all(self, all: impl IntoIterator<Item = Happening>) -> Option<TaskIx> {
        let mut all = all.into_iter().map(|what| self.of(what));
        let first = all.next()??;
        all.all(|other| other == Some(first)).then_some(first)
    }

    /// The task that calls a codel; validations and functions are called by who serves requests.
    fn calls(self, codel: CodelIx) -> Option<TaskIx> {
        let codel = self.model.codels.get(codel)?;
        let of = |service: ServiceIx| self.model.services.get(service)?.task;
        match (&codel.kind, codel.owner) {
            (CodelKind::Fsm { .. }, Owner::Task(task)) => Some(task),
            (CodelKind::Fsm { .. }, Owner::Service(service)) => of(service),
            (CodelKind::Validate | CodelKind::Simple, _) => None,
        }
    }

    /// The task that calls all codels that may write a port.
    fn writes(self, port: PortIx) -> Option<TaskIx> {
        let may = self.model.codels.pairs().filter(|(_, codel)| {
            let mut parameters = codel.parameters.iter();
            parameters.any(|one| one.source == Source::Port(port) && one.direction != Direction::In)
        });
        let mut tasks = may.map(|(codel, _)| self.calls(codel));
        let first = tasks.next()??;
        tasks.all(|other| other == Some(first)).then_some(first)
    }
}
