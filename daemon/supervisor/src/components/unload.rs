//! Stops components in parallel, each after those that use it.
//!
//! A `stop` codel may call services of other components and read their ports. A component is
//! therefore asked to stop only when all components connected to it have ended or are stuck;
//! independent ones are asked at once, the last loaded first. Each has its full timeout from that
//! moment. One thread waits for all of them, and a few others close ports and libraries of those
//! that ended.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::hosted::Hosted;
use super::running::{Components, UnloadError};

/// Number of threads that close ports and libraries.
const HELPERS: usize = 8;
/// How often to check whether a component that others wait for is stuck.
const LOOK: Duration = Duration::from_millis(50);

/// Called for each component when it is gone, or was left behind.
pub(crate) type OnGone<'a> = &'a (dyn Fn(&str, &Result<(), UnloadError>) + Sync);

/// Progress of one component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Waits,
    /// Asked to stop; it has time until then.
    Asked(Instant),
    /// Ended, or out of time; given to a helper thread.
    Ended,
}

/// A component that ended or ran out of time: its index and its deadline.
type Departed = (usize, Instant);

impl Components {
    /// Stops components, waits for their codels and frees their names. Blocks.
    pub fn remove(&self, names: &[String], timeout: Duration, told: OnGone<'_>) {
        let mut going = Vec::with_capacity(names.len());
        for name in names {
            match self.withdraw(name) {
                Some(hosted) => going.push(hosted),
                None => told(name, &Err(UnloadError::NotThere(name.clone()))),
            }
        }
        let (sender, departed) = channel();
        let departed = Mutex::new(departed);
        let hosted: Vec<Mutex<Option<Arc<Hosted>>>> =
            going.iter().map(|one| Mutex::new(Some(Arc::clone(one)))).collect();
        let help = || self.take_down(&hosted, &departed, told);
        thread::scope(|scope| {
            let mut helped = false;
            for _ in 0..going.len().min(HELPERS) {
                let helper = thread::Builder::new().name("genomd-stop".to_owned());
                helped |= helper.spawn_scoped(scope, help).is_ok();
            }
            Departures::new(going, timeout).run(sender);
            if !helped {
                help();
            }
        });
    }

    /// Closes finished components one after the other, until the channel is closed.
    fn take_down(
        &self,
        all: &[Mutex<Option<Arc<Hosted>>>],
        departed: &Mutex<Receiver<Departed>>,
        told: OnGone<'_>,
    ) {
        loop {
            let next = departed.lock().unwrap_or_else(PoisonError::into_inner).recv();
            let Ok((place, deadline)) = next else { return };
            let hosted = all[place].lock().unwrap_or_else(PoisonError::into_inner).take();
            let Some(hosted) = hosted else { continue };
            let name = hosted.name.clone();
            let stopped = hosted.finish_stop(deadline);
            match &stopped {
                // If this is the last reference, the library is closed here.
                Ok(()) => drop(hosted),
                Err(_) => self.leave_behind(hosted),
            }
            self.free(&name);
            let result = stopped.map_err(|why| UnloadError::Stuck { name: name.clone(), why });
            told(&name, &result);
        }
    }
}

/// The components being stopped, in the order they were loaded.
struct Departures {
    going: Vec<Option<Arc<Hosted>>>,
    state: Vec<State>,
    /// For each component, the indices of those that read its ports or call its services.
    users: Vec<Vec<usize>>,
    timeout: Duration,
    /// Stop one at a time: with a virtual clock all codels run in one thread.
    alone: bool,
}

impl Departures {
    fn new(going: Vec<Arc<Hosted>>, timeout: Duration) -> Self {
        let places: BTreeMap<&str, usize> =
            going.iter().enumerate().map(|(place, one)| (one.name.as_str(), place)).collect();
        let mut users = vec![Vec::new(); going.len()];
        for (user, hosted) in going.iter().enumerate() {
            let connections = hosted.ties.connections();
            let used = connections.iter().map(|made| made.outport().instance.as_str());
            for used in used.filter_map(|name| places.get(name).copied()) {
                if used != user && !users[used].contains(&user) {
                    users[used].push(user);
                }
            }
        }
        let alone = going.iter().any(|one| one.serves_at_once);
        let state = vec![State::Waits; going.len()];
        Self { going: going.into_iter().map(Some).collect(), state, users, timeout, alone }
    }

    /// Asks each component when its turn comes, and gives those that ended to the helpers.
    ///
    /// They are handed over in batches, when no other component ends at the moment: closing a
    /// library inspects all threads of the process, and their number is decreasing.
    fn run(mut self, departed: Sender<Departed>) {
        let (tell, ended) = channel();
        let mut ready: Vec<Departed> = Vec::new();
        loop {
            self.ask(&tell);
            let asked = || {
                self.state.iter().enumerate().filter_map(|(place, state)| match state {
                    State::Asked(deadline) => Some((place, *deadline)),
                    _ => None,
                })
            };
            let first = asked().map(|(_, deadline)| deadline).min();
            let Some(first) = first else {
                return hand_on(&mut ready, &departed);
            };
            let left = first.saturating_duration_since(Instant::now());
            let look = !ready.is_empty() || self.state.contains(&State::Waits);
            let place = ended.recv_timeout(if look { left.min(LOOK) } else { left }).ok();
            let now = Instant::now();
            let over: Vec<Departed> =
                asked().filter(|(one, by)| Some(*one) == place || *by <= now).collect();
            for &(place, _) in &over {
                self.state[place] = State::Ended;
                self.going[place] = None;
            }
            ready.extend(over);
            if place.is_none() {
                hand_on(&mut ready, &departed);
            }
        }
    }

    /// Asks all components that no running one needs any more; if all wait for one another, the
    /// last loaded.
    fn ask(&mut self, tell: &Sender<usize>) {
        loop {
            let waiting = (0..self.state.len()).rev().filter(|&at| self.state[at] == State::Waits);
            let waiting: Vec<usize> = waiting.collect();
            let busy = self.state.iter().any(|state| matches!(state, State::Asked(_)));
            if waiting.is_empty() || (self.alone && busy) {
                return;
            }
            let free =
                |&&at: &&usize| self.users[at].iter().all(|&user| self.is_out_of_the_way(user));
            let mut now: Vec<usize> = waiting.iter().filter(free).copied().collect();
            if now.is_empty() && !busy {
                now.extend(waiting.first());
            }
            if self.alone {
                now.truncate(1);
            }
            if now.is_empty() {
                return;
            }
            for place in now {
                self.state[place] = State::Asked(Instant::now() + self.timeout);
                self.ask_one(place, tell.clone());
            }
        }
    }

    fn ask_one(&self, place: usize, tell: Sender<usize>) {
        let Some(hosted) = self.going[place].clone() else { return };
        let timeout = self.timeout;
        let ended = Box::new(move || {
            let _ = tell.send(place);
        });
        if !self.alone {
            return hosted.begin_stop(ended, timeout);
        }
        // With a virtual clock the stop codels run in the thread that asks, which therefore must
        // not be the one that waits.
        let asking = thread::Builder::new().name("genomd-asks".to_owned());
        if let Err(error) = asking.spawn(move || hosted.begin_stop(ended, timeout)) {
            tracing::error!("a component cannot be stopped: {error}");
        }
    }

    fn is_out_of_the_way(&self, place: usize) -> bool {
        match self.state[place] {
            State::Waits => false,
            State::Asked(_) => {
                self.going[place].as_ref().is_none_or(|hosted| !hosted.stuck().is_empty())
            }
            State::Ended => true,
        }
    }
}

fn hand_on(ready: &mut Vec<Departed>, helpers: &Sender<Departed>) {
    for one in ready.drain(..) {
        // Fails only if all helpers have ended, which they do after the sender is dropped.
        let _ = helpers.send(one);
    }
}
