//! A component in numbers: what the rules of all languages read.

use std::fmt;

use genom_description::model::{CodelIx, Ix as _};
use genom_formal::{Answer, Period, Service, System, Times, Work};
use genom_runtime::plan::Builtin;

use crate::error::ExportError;

/// What a byte counts, less the numbers with a meaning of their own.
const MOST: usize = 250;

/// Numbers of what the tables are about.
pub(crate) struct Sizes {
    pub(crate) tasks: usize,
    pub(crate) services: usize,
    pub(crate) nodes: usize,
    pub(crate) states: usize,
    pub(crate) sinks: usize,
    pub(crate) machines: usize,
    /// Activities that a task has at the same time, and a place to move others over.
    pub(crate) runs: usize,
    /// Active states of an activity.
    pub(crate) places: usize,
    /// Accepted activities that are not sent.
    pub(crate) pending: usize,
}

/// A part of the tables.
pub(crate) enum Entry {
    /// What the numbers of the tables after it are.
    Note(&'static str, Vec<String>),
    /// A table of constants.
    Table(&'static str, Vec<usize>),
}

impl fmt::Display for Entry {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Note(what, names) => {
                let names: Vec<String> =
                    names.iter().enumerate().map(|(at, name)| format!("{at} {name}")).collect();
                write!(to, "{what}: {}", names.join(", "))
            }
            Self::Table(name, values) => write!(to, "{name} = {{ {} }}", listed(values)),
        }
    }
}

/// Values with commas between them.
pub(crate) fn listed(values: &[usize]) -> String {
    values.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}

/// An index in 16 bits; a plan has no more of anything.
pub(crate) fn small(index: usize) -> u16 {
    u16::try_from(index).unwrap_or(u16::MAX)
}

/// Activities that a task has at the same time, at most: its permanent one, and a place to move others
/// over.
pub(crate) fn runs_of_task(system: &System, task: usize) -> usize {
    let machines = system.machines().iter();
    let own = machines.filter(|m| usize::from(m.task) == task && m.service.is_some());
    own.count() * system.bounds().instances + 2
}

/// Accepted activities that are not sent, at most.
pub(crate) fn most_pending(system: &System) -> usize {
    let activities = system.services().iter().filter(|service| service.machine.is_some()).count();
    (activities * system.bounds().instances).max(1)
}

/// Whether a service asks an activity to stop (R13).
fn aborts(service: &Service) -> bool {
    service.work.first() == Some(&Work::Abort)
}

/// Whether clients ask activities to stop.
pub(crate) fn is_aborted(system: &System) -> bool {
    let may = system.bounds().abort && !system.periods().is_empty();
    may && system.services().iter().any(aborts)
}

/// Whether there is a task without period, which others wake.
pub(crate) fn wakes(system: &System) -> bool {
    system.periods().iter().any(Option::is_none)
}

impl Sizes {
    /// The numbers of a component.
    ///
    /// # Errors
    /// If it has more of something than the models count.
    pub(crate) fn new(system: &System, format: &'static str) -> Result<Self, ExportError> {
        let component = system.plan().component();
        let (tasks, services) = (system.periods().len(), system.services());
        // With events several states of an activity may be active.
        let several = system.bounds().fire && !component.sinks.is_empty();
        let machines = system.machines();
        let states = machines.iter().map(|machine| machine.codels.iter().flatten().count());
        let places = states.max().unwrap_or(0);
        let sizes = Self {
            tasks,
            services: services.len(),
            nodes: system.plan().nodes().len(),
            states: component.states.len().max(1),
            sinks: component.sinks.len(),
            machines: machines.len(),
            runs: (0..tasks).map(|task| runs_of_task(system, task)).max().unwrap_or(2),
            places: if several { places.max(1) + 1 } else { 1 },
            pending: most_pending(system),
        };
        let limits = [
            ("tasks and services", tasks + sizes.services, MOST),
            ("codels and services", sizes.nodes, MOST),
            ("states", sizes.states, MOST),
            ("activities at the same time", sizes.pending, MOST),
            ("external events", sizes.sinks, 31),
        ];
        match limits.into_iter().find(|(_, count, most)| count > most) {
            Some((what, count, most)) => Err(ExportError::TooMany { what, count, most, format }),
            None => Ok(sizes),
        }
    }

    /// Tasks, and workers of services.
    pub(crate) fn contexts(&self) -> usize {
        self.tasks + self.services.max(1)
    }

    /// The phase in which the component begins.
    pub(crate) fn first_phase(&self) -> &'static str {
        if self.tasks == 0 { "RUNNING" } else { "STARTING" }
    }

    /// Constants by their names. Nothing is empty in them, so that arrays can have these lengths.
    pub(crate) fn constants(&self, system: &System) -> Vec<(&'static str, usize)> {
        let bounds = system.bounds();
        let services = self.services.max(1);
        let builtin = |wanted: Builtin| {
            system.services().iter().position(|one| one.builtin == Some(wanted)).unwrap_or(0)
        };
        let (start, stop) = system.machines().first().map_or((0, 0), |m| (m.start, m.stop));
        vec![
            ("TASK_COUNT", self.tasks),
            ("TASKS", self.tasks.max(1)),
            ("SERVICES", services),
            ("CONTEXTS", self.contexts()),
            ("NODES", self.nodes.max(1)),
            ("STATES", self.states),
            ("SINKS", self.sinks),
            ("RUNS", self.runs),
            ("PLACES", self.places),
            ("PENDING", self.pending),
            ("APERIODIC", system.periods().iter().filter(|period| period.is_none()).count()),
            ("INSTANCES", bounds.instances),
            ("REQUESTS", bounds.requests.min(services)),
            ("SLOTS", bounds.slots.min(MOST)),
            ("KILL", usize::from(bounds.kill)),
            ("BY_PERIOD", usize::from(system.plan().steps_by_period())),
            ("START_STATE", usize::from(start)),
            ("STOP_STATE", usize::from(stop)),
            ("ABORTS", builtin(Builtin::AbortActivity)),
        ]
    }
}

/// The tables of a component.
pub(crate) fn tables(system: &System) -> Vec<Entry> {
    let mut all = machines(system);
    all.extend(services(system));
    all.extend(codels(system));
    all
}

/// An index plus one; 0 for none.
fn plus_one(index: Option<u16>) -> usize {
    index.map_or(0, |index| usize::from(index) + 1)
}

fn machines(system: &System) -> Vec<Entry> {
    let (all, component) = (system.machines(), system.plan().component());
    let of_states = all.iter().flat_map(|m| m.codels.iter().copied());
    vec![
        Entry::Table("M_SERVICE", all.iter().map(|m| m.service.map_or(255, usize::from)).collect()),
        Entry::Table("M_TASK", all.iter().map(|m| usize::from(m.task)).collect()),
        Entry::Table("M_FETCH", all.iter().map(|m| plus_one(m.fetch)).collect()),
        Entry::Note("states", component.states.iter().cloned().collect()),
        Entry::Table("M_CODEL", of_states.map(plus_one).collect()),
        Entry::Table("SINK", component.sinks.iter().map(|sink| sink.state.index()).collect()),
    ]
}

fn services(system: &System) -> Vec<Entry> {
    let all = system.services();
    let count = all.len();
    let matrix = |list: fn(&Service) -> &Vec<u16>| -> Vec<usize> {
        let row = |service| {
            let list = list(service);
            (0..count).map(move |other| usize::from(list.contains(&small(other))))
        };
        all.iter().flat_map(row).collect()
    };
    let nodes = |work: &[Work]| -> Vec<usize> {
        let nodes = work.iter().filter_map(|work| match work {
            Work::Codel(node) | Work::Transfer(node) => Some(usize::from(*node) + 1),
            Work::Abort => None,
        });
        nodes.collect()
    };
    let work: Vec<Vec<usize>> = all.iter().map(|s| nodes(&s.work)).collect();
    let first = |at: usize| work[..at].iter().map(Vec::len).sum::<usize>();
    let interrupts = all.iter().flat_map(|s| s.interrupts.iter().map(|is| usize::from(*is)));
    vec![
        Entry::Note("services", (0..small(count)).map(|at| system.service_name(at)).collect()),
        Entry::Table("S_MACHINE", all.iter().map(|s| plus_one(s.machine)).collect()),
        Entry::Table("S_ORDERED", all.iter().map(|s| usize::from(s.ordered)).collect()),
        Entry::Table("S_ABORTS", all.iter().map(|s| usize::from(aborts(s))).collect()),
        Entry::Table("BEFORE", matrix(|service| &service.before)),
        Entry::Table("AFTER", matrix(|service| &service.after)),
        Entry::Table("INTERRUPTS", interrupts.collect()),
        Entry::Table("S_FIRST", (0..count).map(first).collect()),
        Entry::Table("S_COUNT", work.iter().map(Vec::len).collect()),
        Entry::Table("WORK", work.iter().flatten().copied().collect()),
    ]
}

fn codels(system: &System) -> Vec<Entry> {
    let nodes = small(system.plan().nodes().len());
    let conflicts = (0..nodes)
        .flat_map(|a| (0..nodes).map(move |b| usize::from(system.conflicts().between(a, b))));
    let answers: Vec<&[Answer]> = (0..nodes).map(|node| system.answers(node)).collect();
    let first = |at: usize| answers[..at].iter().map(|answers| answers.len()).sum::<usize>();
    let of = |answer: &Answer| match *answer {
        Answer::Go(to) => (0, to),
        Answer::Pause(to) => (1, to),
        Answer::Sleep(to) => (2, to),
        Answer::End => (3, 0),
        Answer::Ok => (4, 0),
        Answer::Fail => (5, 0),
    };
    let all: Vec<(usize, u16)> = answers.iter().flat_map(|list| list.iter().map(of)).collect();
    let tasks = 0..small(system.periods().len());
    vec![
        Entry::Note("nodes", (0..nodes).map(|node| system.node_name(node)).collect()),
        Entry::Table("CONFLICT", conflicts.collect()),
        Entry::Table("A_FIRST", (0..answers.len()).map(first).collect()),
        Entry::Table("A_COUNT", answers.iter().map(|answers| answers.len()).collect()),
        Entry::Table("A_KIND", all.iter().map(|(kind, _)| *kind).collect()),
        Entry::Table("A_TO", all.iter().map(|(_, to)| usize::from(*to)).collect()),
        Entry::Note("tasks", tasks.map(|task| system.task_name(task)).collect()),
    ]
}

/// The greatest number of answers that a node has.
pub(crate) fn most_answers(system: &System) -> usize {
    let nodes = small(system.plan().nodes().len());
    (0..nodes).map(|node| system.answers(node).len()).max().unwrap_or(0)
}

/// Which tasks have ticks, where their times do not matter.
pub(crate) fn periodic(system: &System) -> Entry {
    let all = system.periods().iter().map(|period| usize::from(period.is_some()));
    Entry::Table("PERIOD", all.collect())
}

/// Times in the greatest unit that all are multiples of.
pub(crate) fn durations(system: &System, times: &Times) -> Vec<Entry> {
    let unit = times.unit(system);
    let units = |ns: u64| usize::try_from(ns / unit).unwrap_or(usize::MAX);
    let of_ticks = |time: fn(Period) -> u64| {
        system.periods().iter().map(|period| units(period.map_or(0, time))).collect()
    };
    let nodes = 0..small(system.plan().nodes().len());
    let nodes = || nodes.clone().map(|node| times.of(node));
    vec![
        Entry::Table("PERIOD", of_ticks(|period| period.period)),
        Entry::Table("SINCE_TICK", of_ticks(Period::before_start)),
        Entry::Table("LEAST", nodes().map(|d| units(d.least)).collect()),
        Entry::Table("MOST", nodes().map(|d| units(d.most.unwrap_or(0))).collect()),
    ]
}

/// Conditions of which one holds while a codel is executed; none if the runtime implements it.
pub(crate) fn executed(system: &System, codel: CodelIx) -> Vec<String> {
    let held = |context| format!("held[{context}] == {}", codel.index() + 1);
    executors(system, codel).into_iter().map(held).collect()
}

/// The contexts that may execute a codel.
fn executors(system: &System, codel: CodelIx) -> Vec<usize> {
    let codel = small(codel.index());
    let machines = system.machines().iter().filter(|m| m.codels.contains(&Some(codel)));
    let mut all: Vec<usize> = machines.map(|machine| usize::from(machine.task)).collect();
    let services = system.services().iter().enumerate();
    let work = services.filter(|(_, service)| service.work.contains(&Work::Codel(codel)));
    all.extend(work.map(|(at, _)| system.periods().len() + at));
    all.sort_unstable();
    all.dedup();
    all
}
