//! What happens in an instance, as rules hear it, and who hears what.

use std::ops::Range;

use genom_description::model::{CodelIx, Component, Ix as _, PortIx, ServiceIx, TaskIx};

/// Something that happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Happening {
    /// A codel is called.
    Call(CodelIx),
    /// A codel has returned.
    Return(CodelIx),
    /// An activity is accepted.
    Accept(ServiceIx),
    /// A service starts: a function or an attribute whose inputs are valid is executed, an activity
    /// begins to run.
    Start(ServiceIx),
    /// An activity that runs is asked to stop.
    Stop(ServiceIx),
    /// A service that had started has ended.
    End(ServiceIx),
    /// A codel wrote a port. Heard when the codel returns.
    Write(PortIx),
    /// An external event was fired, by index of the component's events.
    Fire(usize),
    /// A cycle of a task begins.
    Cycle(TaskIx),
}

impl Happening {
    /// In words: `codel arm_move was called`.
    #[must_use]
    pub fn tell(self, model: &Component) -> String {
        let codel = |ix| &model.codels[ix].name;
        let service = |ix| &model.services[ix].name;
        match self {
            Self::Call(ix) => format!("codel {} was called", codel(ix)),
            Self::Return(ix) => format!("codel {} returned", codel(ix)),
            Self::Accept(ix) => format!("{} was accepted", service(ix)),
            Self::Start(ix) => format!("{} started", service(ix)),
            Self::Stop(ix) => format!("{} was asked to stop", service(ix)),
            Self::End(ix) => format!("{} ended", service(ix)),
            Self::Write(ix) => format!("port {} was written", model.ports[ix].name),
            Self::Fire(at) => {
                let sink = model.sinks.get(at);
                format!("event {} was fired", sink.map_or("", |sink| sink.name.as_str()))
            }
            Self::Cycle(ix) => format!("a cycle of task {} began", model.tasks[ix].name),
        }
    }
}

/// Numbers of all that can happen in a component.
#[derive(Clone, Copy, Debug)]
pub struct Numbers {
    codels: usize,
    services: usize,
    ports: usize,
    sinks: usize,
    tasks: usize,
}

impl Numbers {
    /// Of this component.
    #[must_use]
    pub fn new(model: &Component) -> Self {
        Self {
            codels: model.codels.len(),
            services: model.services.len(),
            ports: model.ports.len(),
            sinks: model.sinks.len(),
            tasks: model.tasks.len(),
        }
    }

    /// The number of a happening.
    #[inline]
    #[must_use]
    pub fn of(&self, what: Happening) -> usize {
        let (codels, services) = (self.codels, self.services);
        let after = 2 * codels + 4 * services;
        match what {
            Happening::Call(ix) => ix.index(),
            Happening::Return(ix) => codels + ix.index(),
            Happening::Accept(ix) => 2 * codels + ix.index(),
            Happening::Start(ix) => 2 * codels + services + ix.index(),
            Happening::Stop(ix) => 2 * codels + 2 * services + ix.index(),
            Happening::End(ix) => 2 * codels + 3 * services + ix.index(),
            Happening::Write(ix) => after + ix.index(),
            Happening::Fire(at) => after + self.ports + at,
            Happening::Cycle(ix) => after + self.ports + self.sinks + ix.index(),
        }
    }

    fn count(&self) -> usize {
        2 * self.codels + 4 * self.services + self.ports + self.sinks + self.tasks
    }
}

/// Who hears what: for each number a list, all in one array.
#[derive(Debug)]
pub struct Hearers<T> {
    lists: Box<[Range<u32>]>,
    all: Box<[T]>,
}

impl<T: Clone> Hearers<T> {
    /// Of a list of who hears what.
    #[must_use]
    pub fn new(numbers: &Numbers, given: &[(Happening, T)]) -> Self {
        // Without hearers there is no table either.
        let count = if given.is_empty() { 0 } else { numbers.count() };
        let mut all = Vec::with_capacity(given.len());
        let list = |number: usize| {
            let begin = all.len();
            let own = given.iter().filter(|(what, _)| numbers.of(*what) == number);
            all.extend(own.map(|(_, who)| who.clone()));
            let small = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
            small(begin)..small(all.len())
        };
        let lists = (0..count).map(list).collect();
        Self { lists, all: all.into_boxed_slice() }
    }

    /// Those who hear what has this number.
    #[inline]
    #[must_use]
    pub fn of(&self, number: usize) -> &[T] {
        let Some(range) = self.lists.get(number) else { return &[] };
        self.all.get(range.start as usize..range.end as usize).unwrap_or_default()
    }
}
