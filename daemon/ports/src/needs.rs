//! Middlewares on which connections need out ports, beyond those that the ports are on by
//! themselves: who needs which end, so that it is closed again with the last one who does.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

use genom_middleware::Address;

/// An out port on a middleware.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Need {
    /// The out port.
    pub outport: Address,
    /// Name of the middleware.
    pub over: String,
}

/// The ends that connections need, of this process and of others.
#[derive(Debug, Default)]
pub struct Needs {
    state: Mutex<State>,
    /// Locked while an end is opened for a connection, or closed after one.
    turn: Mutex<()>,
}

#[derive(Debug, Default)]
struct State {
    /// By in port, which has one connection at most.
    readers: BTreeMap<Address, Need>,
    /// How many of these need an end.
    counts: BTreeMap<Address, BTreeMap<String, usize>>,
    /// What readers in other processes need, as these say.
    far: BTreeMap<Address, BTreeSet<String>>,
}

impl Needs {
    /// Waits for whoever opens or closes an end, and locks out others.
    pub fn turn(&self) -> MutexGuard<'_, ()> {
        self.turn.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The same, unless somebody else does so now.
    pub fn try_turn(&self) -> Option<MutexGuard<'_, ()>> {
        match self.turn.try_lock() {
            Ok(turn) => Some(turn),
            Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    /// From now on the connection of this in port needs that, or nothing. Returns what it needed.
    pub fn put(&self, reader: &Address, need: Option<Need>) -> Option<Need> {
        self.with(|state| {
            let had = match need {
                Some(need) => {
                    let ends = state.counts.entry(need.outport.clone()).or_default();
                    *ends.entry(need.over.clone()).or_default() += 1;
                    state.readers.insert(reader.clone(), need)
                }
                None => state.readers.remove(reader),
            };
            had.inspect(|had| state.release(had))
        })
    }

    /// Whether the connection of this in port needs an end.
    #[must_use]
    pub fn has(&self, reader: &Address) -> bool {
        self.with(|state| state.readers.contains_key(reader))
    }

    /// All in ports whose connections need an end.
    #[must_use]
    pub fn readers(&self) -> Vec<(Address, Need)> {
        self.with(|state| state.readers.clone().into_iter().collect())
    }

    /// What readers in other processes need of a component, in place of what they needed before,
    /// which is returned.
    pub fn put_far(
        &self,
        component: &str,
        needs: BTreeMap<Address, BTreeSet<String>>,
    ) -> BTreeMap<Address, BTreeSet<String>> {
        self.with(|state| {
            let all = std::mem::take(&mut state.far).into_iter();
            let (before, others) = all.partition(|(outport, _)| outport.instance == component);
            state.far = others;
            state.far.extend(needs);
            before
        })
    }

    /// A reader in another process does not get this one: it cannot be opened.
    pub fn refuse_far(&self, need: &Need) {
        self.with(|state| {
            let Some(over) = state.far.get_mut(&need.outport) else { return };
            over.remove(&need.over);
            if over.is_empty() {
                state.far.remove(&need.outport);
            }
        });
    }

    /// All ends that somebody needs.
    #[must_use]
    pub fn all(&self) -> Vec<Need> {
        self.with(|state| {
            let near = state.counts.iter().map(|(outport, ends)| (outport, ends.keys().collect()));
            let far = state.far.iter().map(|(outport, over)| (outport, over.iter().collect()));
            let each = near.chain(far).flat_map(|(outport, over): (_, Vec<&String>)| {
                over.into_iter().map(|over| Need { outport: outport.clone(), over: over.clone() })
            });
            each.collect()
        })
    }

    /// The middlewares on which somebody needs this out port.
    #[must_use]
    pub fn of(&self, outport: &Address) -> Vec<String> {
        self.with(|state| {
            let near = state.counts.get(outport).into_iter().flat_map(BTreeMap::keys);
            let far = state.far.get(outport).into_iter().flatten();
            let all: BTreeSet<&String> = near.chain(far).collect();
            all.into_iter().cloned().collect()
        })
    }

    fn with<T>(&self, work: impl FnOnce(&mut State) -> T) -> T {
        work(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl State {
    fn release(&mut self, need: &Need) {
        let Some(ends) = self.counts.get_mut(&need.outport) else { return };
        if let Some(count) = ends.get_mut(&need.over) {
            *count -= 1;
            if *count == 0 {
                ends.remove(&need.over);
            }
        }
        if ends.is_empty() {
            self.counts.remove(&need.outport);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn need(over: &str) -> Option<Need> {
        Some(Need { outport: Address::new("writer", "out"), over: over.to_owned() })
    }

    #[test]
    fn an_end_is_needed_until_the_last_connection_over_it_is_gone() {
        let (needs, out) = (Needs::default(), Address::new("writer", "out"));
        let readers: Vec<Address> =
            (0..50).map(|one| Address::new(format!("reader{one}"), "in")).collect();
        for reader in &readers {
            assert_eq!(needs.put(reader, need("zenoh")), None);
            // Again the same: counted once.
            assert_eq!(needs.put(reader, need("zenoh")), need("zenoh"));
        }
        for reader in &readers {
            assert_eq!(needs.of(&out), ["zenoh"]);
            assert_eq!(needs.put(reader, None), need("zenoh"));
        }
        assert!(needs.of(&out).is_empty() && needs.readers().is_empty());
        assert!(needs.with(|state| state.counts.is_empty()), "nothing is left");
    }

    #[test]
    fn a_connection_that_changes_its_middleware_releases_the_one_before() {
        let (needs, out) = (Needs::default(), Address::new("writer", "out"));
        let reader = Address::new("reader", "in");
        needs.put(&reader, need("zenoh"));
        assert_eq!(needs.put(&reader, need("ros2")), need("zenoh"));
        assert_eq!(needs.of(&out), ["ros2"]);
    }

    #[test]
    fn what_other_processes_need_is_replaced_by_component() {
        let (needs, out) = (Needs::default(), Address::new("writer", "out"));
        let one = |over: &str| BTreeMap::from([(out.clone(), [over.to_owned()].into())]);
        needs.put(&Address::new("reader", "in"), need("shm"));
        needs.put_far("writer", one("zenoh"));
        needs.put_far("another", BTreeMap::new());
        assert_eq!(needs.of(&out), ["shm", "zenoh"]);
        assert_eq!(needs.put_far("writer", one("ros2")), one("zenoh"));
        assert_eq!(needs.of(&out), ["ros2", "shm"]);
        let refused = Need { outport: out.clone(), over: "ros2".to_owned() };
        assert!(needs.all().contains(&refused));
        needs.refuse_far(&refused);
        assert_eq!(needs.of(&out), ["shm"]);
        assert!(needs.with(|state| state.far.is_empty()), "nothing is left");
        needs.put_far("writer", one("zenoh"));
        needs.put_far("writer", BTreeMap::new());
        assert_eq!(needs.of(&out), ["shm"]);
    }

    #[test]
    fn whoever_only_looks_does_not_wait_for_an_end_that_is_being_opened() {
        let needs = Needs::default();
        let turn = needs.turn();
        assert!(needs.try_turn().is_none());
        drop(turn);
        assert!(needs.try_turn().is_some());
    }
}
