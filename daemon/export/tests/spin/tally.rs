//! Verdicts that were compared.

use std::collections::BTreeMap;
use std::fmt;

/// Both find as many states: no verdict, and not counted with them.
pub(crate) const STATES: &str = "(as many states)";

/// Verdicts of both, by what they are about.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    kinds: BTreeMap<&'static str, Kind>,
    /// On what they differ.
    pub(crate) different: Vec<String>,
}

/// Verdicts of one kind.
#[derive(Clone, Copy, Debug, Default)]
struct Kind {
    /// Of both, that it holds.
    hold: usize,
    /// Of both, that it does not.
    fail: usize,
    different: usize,
    /// One of both did not come to an end.
    undecided: usize,
}

impl Tally {
    /// One verdict of each; `None` is that it is not decided.
    pub(crate) fn note(
        &mut self,
        kind: &'static str,
        what: impl fmt::Display,
        ours: Option<bool>,
        spin: Option<bool>,
    ) {
        let of = self.kinds.entry(kind).or_default();
        match (ours, spin) {
            (Some(true), Some(true)) => of.hold += 1,
            (Some(false), Some(false)) => of.fail += 1,
            (Some(ours), Some(_)) => {
                of.different += 1;
                let (one, other) =
                    if ours { ("holds", "not") } else { ("does not hold", "it does") };
                self.different.push(format!("{kind}: {what}: {one}; by Spin {other}"));
            }
            (None, _) | (_, None) => of.undecided += 1,
        }
    }

    /// Adds others; `of` says what those are about.
    pub(crate) fn add(&mut self, other: Self, of: impl fmt::Display) {
        for (kind, count) in other.kinds {
            let own = self.kinds.entry(kind).or_default();
            own.hold += count.hold;
            own.fail += count.fail;
            own.different += count.different;
            own.undecided += count.undecided;
        }
        self.different.extend(other.different.into_iter().map(|one| format!("{of}: {one}")));
    }

    /// How many verdicts are equal: that it holds, and that it does not.
    pub(crate) fn equal(&self) -> (usize, usize) {
        let kinds = self.kinds.iter().filter(|(name, _)| **name != STATES);
        kinds.fold((0, 0), |(hold, fail), (_, kind)| (hold + kind.hold, fail + kind.fail))
    }

    /// How many are not decided by one of both.
    #[allow(dead_code, reason = "the bench prints them")]
    pub(crate) fn undecided(&self) -> usize {
        self.kinds.values().map(|kind| kind.undecided).sum()
    }

    /// How many of one kind are equal.
    #[allow(dead_code, reason = "the bench has no use for it")]
    pub(crate) fn of(&self, kind: &str) -> (usize, usize) {
        self.kinds.get(kind).map_or((0, 0), |kind| (kind.hold, kind.fail))
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            to,
            "{:26} {:>6} {:>6} {:>10} {:>10}",
            "", "hold", "not", "different", "undecided"
        )?;
        let mut all = Kind::default();
        let line = |to: &mut fmt::Formatter<'_>, name: &str, kind: &Kind| {
            let Kind { hold, fail, different, undecided } = kind;
            writeln!(to, "{name:26} {hold:6} {fail:6} {different:10} {undecided:10}")
        };
        for (name, kind) in &self.kinds {
            line(to, name, kind)?;
            if *name == STATES {
                continue;
            }
            all.hold += kind.hold;
            all.fail += kind.fail;
            all.different += kind.different;
            all.undecided += kind.undecided;
        }
        line(to, "all verdicts", &all)
    }
}
