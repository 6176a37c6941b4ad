//! What connections need of other processes of the daemon, and what these were told of it.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use genom_configuration::place::Place;
use genom_protocol::ConnectionEntry;

/// What a connection needs of another process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Want {
    /// Component that writes the out port.
    pub(crate) writer: String,
    /// The out port, or the element of a multiple one.
    port: String,
    /// The middleware.
    pub(crate) over: String,
}

impl Want {
    /// What a connection needs for which a middleware was asked.
    pub(crate) fn of(outport: &str, over: Option<&str>) -> Option<Self> {
        let Place { backend, address } = Place::parse(outport).ok()?;
        let over = over.map(str::to_owned).or(backend)?;
        // An absolute name, such as `/scan`, is not one of this daemon.
        let named = !address.instance.is_empty();
        named.then_some(Self { writer: address.instance, port: address.name, over })
    }
}

/// The middlewares on which out ports of a component are needed, by port.
pub(crate) type Ends = BTreeMap<String, BTreeSet<String>>;

/// What is known of a connection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Found {
    /// It is there, or to be made again, as this entry says.
    There(ConnectionEntry),
    /// Its component is not loaded: it may come back.
    Away,
    /// It is gone.
    Gone,
}

/// What connections of all processes need. Only what somebody asked of the daemon counts, as long as
/// the process of the reader has it: what a cell writes into its journal opens nothing elsewhere.
#[derive(Debug, Default)]
pub(crate) struct Wants {
    state: Mutex<State>,
    /// Locked while the processes are asked for the connections that there are.
    pub(crate) counting: tokio::sync::Mutex<()>,
}

#[derive(Debug, Default)]
struct State {
    /// Of connections that there are, by the address of the in port.
    made: BTreeMap<String, Made>,
    /// Of those that are being made, or might come back since what replaces them is being made.
    asked: BTreeMap<u64, Vec<(String, Want)>>,
    last: u64,
    /// What the process of a component was told; `None` if that is not certain.
    told: BTreeMap<String, Option<Ends>>,
    /// Why one could not be told, as it was logged.
    failed: BTreeMap<String, String>,
    turns: BTreeMap<String, Weak<tokio::sync::Mutex<()>>>,
}

#[derive(Debug)]
struct Made {
    want: Want,
    /// Whether its component is loaded.
    here: bool,
}

/// Connections that are being made: what they need counts until this is dropped.
#[derive(Debug)]
pub struct Asked {
    wants: Arc<Wants>,
    number: u64,
}

impl Drop for Asked {
    fn drop(&mut self) {
        self.wants.with(|state| state.asked.remove(&self.number));
    }
}

impl Wants {
    /// Counts what these connections need, by in port, from now on.
    pub(crate) fn ask(self: &Arc<Self>, wants: Vec<(String, Want)>) -> Asked {
        let number = self.with(|state| {
            state.last += 1;
            state.asked.insert(state.last, wants);
            state.last
        });
        Asked { wants: Arc::clone(self), number }
    }

    /// Whether nothing is needed, and no process has to be told so.
    pub(crate) fn is_empty(&self) -> bool {
        self.with(|state| state.made.is_empty() && state.asked.is_empty() && state.told.is_empty())
    }

    /// What the connection of an in port needs.
    pub(crate) fn made(&self, inport: &str) -> Option<Want> {
        self.with(|state| state.made.get(inport).map(|made| made.want.clone()))
    }

    /// The same of all, by in port.
    pub(crate) fn all_made(&self) -> Vec<(String, Want)> {
        let of = |(inport, made): (&String, &Made)| (inport.clone(), made.want.clone());
        self.with(|state| state.made.iter().map(of).collect())
    }

    /// The in ports whose connections are to be looked for.
    pub(crate) fn inports(&self) -> BTreeSet<String> {
        self.with(|state| {
            let asked = state.asked.values().flatten().map(|(inport, _)| inport);
            state.made.keys().chain(asked).cloned().collect()
        })
    }

    /// What was found of these connections. One that nobody asked for counts for nothing.
    pub(crate) fn counted(&self, found: BTreeMap<String, Found>) {
        self.with(|state| {
            for (inport, found) in found {
                match found {
                    Found::There(entry) => state.there(&inport, &entry),
                    Found::Away => {
                        if let Some(made) = state.made.get_mut(&inport) {
                            made.here = false;
                        }
                    }
                    Found::Gone => drop(state.made.remove(&inport)),
                }
            }
        });
    }

    /// What is needed of a component.
    pub(crate) fn of(&self, writer: &str) -> Ends {
        self.with(|state| state.of(|one| one == writer).remove(writer).unwrap_or_default())
    }

    /// The components whose processes were not told what is needed of them now.
    pub(crate) fn untold(&self) -> Vec<String> {
        self.with(|state| {
            let needed = state.of(|_| true);
            let all: BTreeSet<&String> = needed.keys().chain(state.told.keys()).collect();
            let none = Ends::new();
            let knows = |writer: &String| state.knows(writer, needed.get(writer).unwrap_or(&none));
            all.into_iter().filter(|writer| !knows(writer)).cloned().collect()
        })
    }

    /// Whether the process of a component was told that this is needed of it.
    pub(crate) fn knows(&self, writer: &str, needed: &Ends) -> bool {
        self.with(|state| state.knows(writer, needed))
    }

    /// The process of a component was told this.
    pub(crate) fn told(&self, writer: &str, ends: Ends) {
        self.with(|state| {
            state.failed.remove(writer);
            if ends.is_empty() {
                state.told.remove(writer);
            } else {
                state.told.insert(writer.to_owned(), Some(ends));
            }
        });
    }

    /// What the process of a component was told is not certain: it is told again.
    pub(crate) fn forget(&self, writer: &str) {
        self.with(|state| drop(state.told.insert(writer.to_owned(), None)));
    }

    /// The process of a component is another one now: it is told again if something is needed of it.
    pub(crate) fn begins(&self, writer: &str) {
        self.with(|state| {
            if state.told.contains_key(writer) {
                state.told.insert(writer.to_owned(), None);
            }
        });
    }

    /// The same of all.
    pub(crate) fn all_begin(&self) {
        self.with(|state| state.told.values_mut().for_each(|told| *told = None));
    }

    /// Why the process of a component could not be told; whether that is new.
    pub(crate) fn failed(&self, writer: &str, why: String) -> bool {
        self.with(|state| {
            let before = state.failed.insert(writer.to_owned(), why.clone());
            before.is_none_or(|before| before != why)
        })
    }

    /// Locked while the process of a component is told, so that it hears last what counts.
    pub(crate) fn turn(&self, writer: &str) -> Arc<tokio::sync::Mutex<()>> {
        self.with(|state| {
            if let Some(turn) = state.turns.get(writer).and_then(Weak::upgrade) {
                return turn;
            }
            state.turns.retain(|_, turn| turn.strong_count() > 0);
            let turn = Arc::default();
            state.turns.insert(writer.to_owned(), Arc::downgrade(&turn));
            turn
        })
    }

    fn with<T>(&self, work: impl FnOnce(&mut State) -> T) -> T {
        work(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl State {
    fn there(&mut self, inport: &str, entry: &ConnectionEntry) {
        let needs = Want::of(&entry.outport, entry.over.as_deref());
        let asked = self.asked.values().flatten();
        let asked = asked.filter(|(of, _)| of == inport).map(|(_, want)| want);
        let known = self.made.get(inport).map(|made| &made.want);
        let mut wanted = known.into_iter().chain(asked);
        let found = wanted.find(|want| needs.as_ref() == Some(*want)).cloned();
        match found {
            Some(want) => drop(self.made.insert(inport.to_owned(), Made { want, here: true })),
            None => drop(self.made.remove(inport)),
        }
    }

    /// What is needed of these components, by name.
    fn of(&self, wanted: impl Fn(&str) -> bool) -> BTreeMap<String, Ends> {
        let made = self.made.values().filter(|made| made.here).map(|made| &made.want);
        let asked = self.asked.values().flatten().map(|(_, want)| want);
        let mut all: BTreeMap<String, Ends> = BTreeMap::new();
        for Want { writer, port, over } in made.chain(asked).filter(|want| wanted(&want.writer)) {
            let ends = all.entry(writer.clone()).or_default();
            ends.entry(port.clone()).or_default().insert(over.clone());
        }
        all
    }

    fn knows(&self, writer: &str, needed: &Ends) -> bool {
        match self.told.get(writer) {
            Some(told) => told.as_ref() == Some(needed),
            None => needed.is_empty(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(reader: &str, over: Option<&str>) -> ConnectionEntry {
        let (inport, outport) = (reader.to_owned(), "writer/out".to_owned());
        ConnectionEntry { inport, outport, policy: None, over: over.map(str::to_owned) }
    }

    fn want(over: &str) -> Want {
        Want::of("writer/out", Some(over)).unwrap()
    }

    fn found(wants: &Wants, reader: &str, found: Found) {
        wants.counted([(reader.to_owned(), found)].into());
    }

    fn ends(over: &[&str]) -> Ends {
        let over: BTreeSet<String> = over.iter().map(|&name| name.to_owned()).collect();
        if over.is_empty() { Ends::new() } else { [("out".to_owned(), over)].into() }
    }

    /// Wants of a connection over zenoh that was made.
    fn made() -> Arc<Wants> {
        let wants = Arc::<Wants>::default();
        let asked = wants.ask(vec![("a/in".to_owned(), want("zenoh"))]);
        assert_eq!(wants.of("writer"), ends(&["zenoh"]));
        found(&wants, "a/in", Found::There(entry("a/in", Some("zenoh"))));
        drop(asked);
        assert_eq!(wants.of("writer"), ends(&["zenoh"]));
        wants
    }

    #[test]
    fn what_was_asked_and_not_made_needs_nothing_any_more() {
        let wants = Arc::<Wants>::default();
        let asked = wants.ask(vec![("a/in".to_owned(), want("zenoh"))]);
        found(&wants, "a/in", Found::Gone);
        assert_eq!(wants.of("writer"), ends(&["zenoh"]), "it is being made");
        drop(asked);
        assert!(wants.of("writer").is_empty() && wants.is_empty());
    }

    #[test]
    fn while_a_connection_changes_its_middleware_both_are_needed() {
        let wants = made();
        let asked = wants.ask(vec![("a/in".to_owned(), want("ros2"))]);
        assert_eq!(wants.of("writer"), ends(&["ros2", "zenoh"]));
        found(&wants, "a/in", Found::There(entry("a/in", Some("ros2"))));
        drop(asked);
        assert_eq!(wants.of("writer"), ends(&["ros2"]));
    }

    #[test]
    fn a_connection_that_nobody_asked_for_opens_nothing() {
        let wants = made();
        found(&wants, "b/in", Found::There(entry("b/in", Some("ros2"))));
        assert_eq!(wants.of("writer"), ends(&["zenoh"]));
        // Nor does one that a process says to be another one than was asked for.
        found(&wants, "a/in", Found::There(entry("a/in", Some("ros2"))));
        assert!(wants.of("writer").is_empty());
    }

    #[test]
    fn a_connection_whose_reader_is_not_loaded_needs_nothing_until_it_is_back() {
        let wants = made();
        found(&wants, "a/in", Found::Away);
        assert!(wants.of("writer").is_empty());
        found(&wants, "a/in", Found::There(entry("a/in", Some("zenoh"))));
        assert_eq!(wants.of("writer"), ends(&["zenoh"]));
        found(&wants, "a/in", Found::Gone);
        assert!(wants.is_empty());
    }

    #[test]
    fn a_process_is_told_when_something_changed_or_another_one_took_its_place() {
        let wants = made();
        assert_eq!(wants.untold(), ["writer"]);
        wants.told("writer", ends(&["zenoh"]));
        assert!(wants.untold().is_empty());
        wants.begins("writer");
        assert_eq!(wants.untold(), ["writer"]);
        wants.told("writer", ends(&["zenoh"]));
        found(&wants, "a/in", Found::Gone);
        assert_eq!(wants.untold(), ["writer"], "that it is needed no more");
        wants.told("writer", Ends::new());
        assert!(wants.untold().is_empty() && wants.is_empty());
        // Of one that a daemon before this one told nobody knows what.
        wants.begins("writer");
        assert!(wants.untold().is_empty());
        wants.forget("writer");
        assert_eq!(wants.untold(), ["writer"]);
    }
}
