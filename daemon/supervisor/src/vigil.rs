//! Looks at the rules of supervision that tasks themselves cannot see broken, and watches for codels
//! that do not return or do not pause: reports when one counts as stuck, when it returns and when
//! one spins, and frees components that were left behind once their threads end.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

use genom_description::model::TaskIx;
use genom_runtime::{RunningCodel, Unpaused, nanos, seconds};

use crate::components::{Components, Hosted, Spin};
use genom_bus::flag::Flag;
use genom_bus::{Bus, Change};

/// Interval between two checks. A check reads only a few words per component.
const LOOK: Duration = Duration::from_millis(250);
/// Minimum interval between log entries about the same stuck codel. Events are sent each time.
const SAME_AGAIN: Duration = Duration::from_secs(60);

/// Watches until `closed` is raised.
pub(crate) fn watch(
    components: Arc<Components>,
    bus: Arc<Bus>,
    closed: Flag,
) -> std::io::Result<Thread> {
    let thread = thread::Builder::new().name("genomd-vigil".to_owned()).spawn(move || {
        let mut vigil =
            Vigil { bus, told: HashMap::new(), spins: HashSet::new(), logged: HashMap::new() };
        let mut last = None;
        while !closed.is_up() {
            // Rules may need to be looked at more often.
            let next = components.all().iter().filter_map(|hosted| hosted.supervise()).min();
            if last.is_none_or(|last: Instant| last.elapsed() >= LOOK) {
                last = Some(Instant::now());
                vigil.look(&components);
            }
            thread::park_timeout(next.map_or(LOOK, |next| next.min(LOOK)));
        }
    })?;
    Ok(thread.thread().clone())
}

/// Name of a component, and index of one of its contexts.
type Place = (String, usize);

struct Vigil {
    bus: Arc<Bus>,
    /// Stuck codels that were reported.
    told: HashMap<Place, Stuck>,
    /// Reported cycles that spin: component, task, start date.
    spins: HashSet<(String, TaskIx, u64)>,
    /// When a codel of a component was logged last, and how many times it was not logged since.
    logged: HashMap<(String, String), (Instant, u32)>,
}

struct Stuck {
    call: (usize, u64),
    codel: RunningCodel,
    began: Instant,
    logged: bool,
}

impl Vigil {
    fn look(&mut self, components: &Components) {
        let running = components.all();
        for hosted in &running {
            self.look_at(&hosted.name, hosted.stuck());
        }
        self.look_for_spins(&running);
        // Components that are being stopped are reported by whoever stops them.
        let runs = |name: &str| running.iter().any(|hosted| hosted.name == name);
        self.told.retain(|(name, _), _| runs(name));
        self.logged.retain(|_, (last, _)| last.elapsed() < SAME_AGAIN);
        drop(running);
        let over = components.over();
        if !over.is_empty() {
            bury(over);
        }
    }

    fn look_at(&mut self, name: &str, stuck: Vec<RunningCodel>) {
        let calls: Vec<_> = stuck.iter().map(RunningCodel::call).collect();
        let returned: Vec<Place> = self
            .told
            .iter()
            .filter(|((of, _), told)| of == name && !calls.contains(&told.call))
            .map(|(place, _)| place.clone())
            .collect();
        for Stuck { codel, began, logged, .. } in
            returned.iter().filter_map(|p| self.told.remove(p))
        {
            let time = began.elapsed();
            let RunningCodel { codel, owner, .. } = codel;
            if logged {
                let time = seconds(nanos(time));
                tracing::info!(instance = name, "codel {codel} of {owner} returned after {time}");
            }
            let (component, seconds) = (name.to_owned(), time.as_secs_f64());
            self.bus.tell(&Change::CodelReturned { component, codel, owner, seconds });
        }
        for codel in stuck {
            let place = (name.to_owned(), codel.call().0);
            if self.told.contains_key(&place) {
                continue;
            }
            let time = Duration::from_nanos(codel.for_ns);
            let logged = self.log(name, &codel);
            let (component, seconds) = (name.to_owned(), time.as_secs_f64());
            let RunningCodel { codel: rank, owner, task, .. } = codel.clone();
            let told = Change::CodelStuck { component, codel: rank, owner, task, seconds };
            self.bus.tell(&told);
            let began = Instant::now().checked_sub(time).unwrap_or_else(Instant::now);
            self.told.insert(place, Stuck { call: codel.call(), codel, began, logged });
        }
    }

    fn look_for_spins(&mut self, running: &[Arc<Hosted>]) {
        let mut now = HashSet::new();
        for hosted in running {
            hosted.look_for_spins();
            for spin in hosted.spins() {
                let (task, began) = spin.unpaused.cycle;
                let key = (hosted.name.clone(), task, began);
                if !self.spins.contains(&key) {
                    self.tell_spin(&hosted.name, spin);
                }
                now.insert(key);
            }
        }
        self.spins = now;
    }

    fn tell_spin(&mut self, name: &str, spin: Spin) {
        if let Some(again) = self.not_lately(name, &spin.unpaused.codel) {
            let task = &spin.unpaused.task;
            tracing::warn!(instance = name, "task {task} does not pause: {spin}{again}");
        }
        let Unpaused { task, codel, owner, for_ns, .. } = spin.unpaused;
        let (component, seconds) = (name.to_owned(), Duration::from_nanos(for_ns).as_secs_f64());
        self.bus.tell(&Change::CodelSpins { component, codel, owner, task, seconds });
    }

    /// If the codel was not logged recently, returns a text on how often it was stuck without being
    /// logged.
    fn not_lately(&mut self, name: &str, codel: &str) -> Option<String> {
        let key = (name.to_owned(), codel.to_owned());
        let more = match self.logged.get_mut(&key) {
            Some((last, more)) if last.elapsed() < SAME_AGAIN => {
                *more += 1;
                return None;
            }
            Some((_, more)) => *more,
            None => 0,
        };
        self.logged.insert(key, (Instant::now(), 0));
        Some(if more > 0 { format!("; {more} times more since") } else { String::new() })
    }

    /// Logs a stuck codel, unless that was done recently. Returns whether it did.
    fn log(&mut self, name: &str, codel: &RunningCodel) -> bool {
        let Some(again) = self.not_lately(name, &codel.codel) else { return false };
        let whose =
            codel.task.as_ref().map_or("a request".to_owned(), |task| format!("task {task}"));
        tracing::warn!(
            instance = name,
            "{whose} is stuck: codel {} of {} has not returned for {}{again}",
            codel.codel,
            codel.owner,
            seconds(codel.for_ns)
        );
        genom_host::interpreter::tell_where(&codel.codel);
        true
    }
}

/// Frees components in a thread of its own, because closing a library runs code of its author.
fn bury(over: Vec<Arc<Hosted>>) {
    let burying = thread::Builder::new().name("genomd-bury".to_owned()).spawn(move || {
        for hosted in over {
            let name = hosted.name.clone();
            hosted.let_go();
            drop(hosted);
            tracing::info!("what was left behind of {name} has ended, and is gone");
        }
    });
    if let Err(error) = burying {
        tracing::error!("what was left behind of a component cannot be closed: {error}");
    }
}
