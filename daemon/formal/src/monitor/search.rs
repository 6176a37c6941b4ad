//! Looks for a shortest run that breaks an order or a formula.

use std::time::Instant;

use genom_runtime::{Happening, Judge, Order, Program};
use indexmap::IndexSet;

use super::fires::{Fires, Trace, concluded, undecided};
use crate::action::Action;
use crate::pack::{packed, unpacked};
use crate::state::State;
use crate::system::System;
use crate::words::Line;
use genom_timing::memory::{ENTRY, listed};
use genom_timing::{Limit, Limits};

/// Bytes that the tables take for each node.
const TABLES: usize = ENTRY + listed::<(u32, u16)>();
/// Of a place, beside its key.
const PLACE: usize = ENTRY + listed::<Place>() + 1024;
/// Limit on ports that one codel may write and that a rule hears of: each is written or not.
pub(super) const MOST_PORTS: u32 = 8;

/// What is heard in a step, of which each that is open happens or does not: one list for each choice;
/// `None` if there are too many.
pub(super) fn choices<T>(
    heard: &[T],
    is_open: impl Fn(&T) -> bool + Copy,
) -> Option<impl Iterator<Item = impl Iterator<Item = &T>>> {
    let open = u32::try_from(heard.iter().filter(|one| is_open(one)).count()).ok()?;
    let choice = move |choice: u32| {
        let mut left = choice;
        heard.iter().filter(move |one| {
            let is_open = is_open(one);
            let happens = !is_open || left & 1 == 1;
            left >>= u32::from(is_open);
            happens
        })
    };
    (open <= MOST_PORTS).then(|| (0..1 << open).map(choice))
}

/// What goes along with the system.
pub(super) enum Watched<'a> {
    Order(&'a Order),
    Formula(&'a Program),
}

/// Where that is.
#[derive(Clone)]
enum Place {
    Order(u8),
    Formula(Judge),
}

impl Watched<'_> {
    fn first(&self) -> Place {
        match self {
            Self::Order(_) => Place::Order(0),
            Self::Formula(program) => Place::Formula(Judge::new(program)),
        }
    }

    /// The number of what it hears.
    fn letter(&self, heard: &[(Happening, usize)], what: Happening) -> Option<usize> {
        heard.iter().find(|(own, _)| *own == what).map(|(_, letter)| *letter)
    }

    fn hears(&self) -> Vec<(Happening, usize)> {
        match self {
            Self::Order(order) => order.hears(),
            Self::Formula(program) => {
                program.hears().into_iter().enumerate().map(|(at, what)| (what, at)).collect()
            }
        }
    }
}

/// A node: a state, and a place by number.
struct Nodes {
    all: IndexSet<Box<[u8]>>,
    /// The node before each, and the number of the step between them.
    before: Vec<(u32, u16)>,
    places: Vec<Place>,
    /// Their keys, in the same order.
    known: IndexSet<Vec<u8>>,
}

impl Nodes {
    /// The number of a place, and the bytes that it takes if it is new.
    fn number(&mut self, place: Place) -> (u32, usize) {
        let key = key(&place);
        let bytes = 4 * key.len() + PLACE;
        let (at, is_new) = self.known.insert_full(key);
        if is_new {
            self.places.push(place);
        }
        (u32::try_from(at).unwrap_or(u32::MAX), if is_new { bytes } else { 0 })
    }

    /// Adds a node; returns the bytes that it takes.
    fn add(&mut self, state: &[u8], place: Place, before: (u32, u16)) -> usize {
        let (number, bytes) = self.number(place);
        let node: Box<[u8]> = number.to_le_bytes().iter().chain(state).copied().collect();
        let length = node.len();
        if !self.all.insert(node) {
            return bytes;
        }
        self.before.push(before);
        bytes + length + TABLES
    }

    fn get(&self, at: usize) -> Option<(State, Place)> {
        let (number, state) = self.all.get_index(at)?.split_at_checked(4)?;
        let number = u32::from_le_bytes(number.try_into().ok()?);
        Some((unpacked(state), self.places.get(number as usize)?.clone()))
    }
}

fn key(place: &Place) -> Vec<u8> {
    match place {
        Place::Order(state) => vec![*state],
        Place::Formula(judge) => {
            // It has no dates.
            let (before, _, running) = judge.place();
            let mut key = before.to_le_bytes().to_vec();
            running.iter().for_each(|running| key.extend(running.to_le_bytes()));
            key
        }
    }
}

impl System {
    /// A shortest run that breaks it. Nothing is told of dates.
    pub(super) fn search(&self, watched: &Watched<'_>, limits: &Limits) -> Fires {
        let heard = watched.hears();
        if let Some((what, _)) = heard.iter().find(|(what, _)| !self.is_heard(*what)) {
            let what = what.tell(self.plan.component());
            return Fires::Undecided(format!("it is not explored when \"{what}\""));
        }
        let begin = Instant::now();
        let mut nodes = Nodes {
            all: IndexSet::new(),
            before: Vec::new(),
            places: Vec::new(),
            known: IndexSet::new(),
        };
        let mut bytes = nodes.add(&packed(&self.initial(false)), watched.first(), (0, 0));
        // The first violation, and whether anything that it hears did not break it.
        let (mut broken, mut kept) = (None, false);
        let (mut at, mut told) = (0, Vec::new());
        let mut limit: Option<Limit> = None;
        while let Some((state, place)) = nodes.get(at) {
            let number = u32::try_from(at).unwrap_or(u32::MAX);
            at += 1;
            for (action, step) in self.enabled(&state).iter().zip(0u16..) {
                told.clear();
                let next = self.after(&state, *action, &mut told);
                let happens = self.heard(&state, *action, &next, &told);
                let all = match self.walks(watched, &heard, &place, &happens) {
                    Some(all) => all,
                    None => return undecided("a codel writes too many ports that it hears of"),
                };
                let bits = packed(&next);
                for walked in all {
                    kept |= walked.kept;
                    if let Some(what) = walked.broken {
                        broken.get_or_insert((number, *action, what));
                    }
                    bytes += nodes.add(&bits, walked.place, (number, step));
                }
            }
            if broken.is_some() && kept {
                break;
            }
            limit = limits.passed(nodes.all.len(), bytes, at, begin);
            if limit.is_some() {
                break;
            }
        }
        let broken = broken
            .map(|(node, action, what)| (what, Trace::Steps(self.lines_to(&nodes, node, action))));
        concluded(broken, kept, limit)
    }

    /// Where it goes by what happens in a step: a way for each choice of ports that are written.
    fn walks(
        &self,
        watched: &Watched<'_>,
        heard: &[(Happening, usize)],
        place: &Place,
        happens: &[(Happening, bool)],
    ) -> Option<Vec<Walked>> {
        let letter = |what: &Happening| watched.letter(heard, *what);
        let matter: Vec<(Happening, bool, usize)> =
            happens.iter().filter_map(|(what, open)| Some((*what, *open, letter(what)?))).collect();
        let mut all = Vec::new();
        for happens in choices(&matter, |(_, open, _)| *open)? {
            let (mut place, mut kept, mut broken) = (place.clone(), false, None);
            for (what, _, letter) in happens {
                let wrong = match (watched, &mut place) {
                    (Watched::Order(order), Place::Order(state)) => {
                        let next = order.next(*state, *letter);
                        next.inspect(|next| *state = *next).is_none()
                    }
                    (Watched::Formula(_), Place::Formula(judge)) => {
                        judge.hear(*letter, 0).is_some()
                    }
                    _ => false,
                };
                kept |= !wrong;
                if wrong {
                    broken.get_or_insert_with(|| what.tell(self.plan.component()));
                }
            }
            all.push(Walked { place, kept, broken });
        }
        Some(all)
    }

    /// The run to a node, and one step more.
    fn lines_to(&self, nodes: &Nodes, node: u32, last: Action) -> Vec<Line> {
        let mut taken = Vec::new();
        if let Some((state, _)) = nodes.get(node as usize) {
            taken.push((state, last));
        }
        let mut at = node;
        while at > 0 {
            let Some(&(before, step)) = nodes.before.get(at as usize) else { break };
            let Some((state, _)) = nodes.get(before as usize) else { break };
            let Some(action) = self.enabled(&state).get(usize::from(step)).copied() else { break };
            taken.push((state, action));
            at = before;
        }
        taken.iter().rev().filter_map(|(state, action)| self.words(state, *action)).collect()
    }
}

/// Where a step led.
struct Walked {
    place: Place,
    /// Something was heard that did not break it.
    kept: bool,
    /// What broke it.
    broken: Option<String>,
}
