//! What has to hold at the same time, as bits of parts.

use crate::program::Part;
use crate::step::says;
use crate::value::{Value, both_of};

/// Bits of parts, and those of them that are to be set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Literals {
    pub(crate) mask: u64,
    pub(crate) want: u64,
}

impl Literals {
    /// What has to be so that all these values are those wanted; `None` if they never are. Where all
    /// of two has to hold, so has each, and the bit of both is not asked for.
    pub(crate) fn of(
        parts: &[Part],
        values: &[Value],
        wanted: impl IntoIterator<Item = (Value, bool)>,
    ) -> Option<Self> {
        let mut left: Vec<(Value, bool)> = wanted.into_iter().collect();
        let mut all = Self::default();
        while let Some((value, wanted)) = left.pop() {
            match value {
                Value::Known(holds) if holds == wanted => {}
                Value::Known(_) => return None,
                Value::Same(at, negated) => {
                    let is_set = (wanted != negated) == says(&parts[at]);
                    match both_of(&parts[at], values) {
                        Some((a, b, _)) if is_set => left.extend([(a, true), (b, true)]),
                        _ => all = all.and(at, is_set)?,
                    }
                }
            }
        }
        Some(all)
    }

    /// And this bit is set, or not.
    pub(crate) fn and(self, at: usize, is_set: bool) -> Option<Self> {
        let (own, is_set) = (1 << at, u64::from(is_set) << at);
        let fits = self.mask & own == 0 || self.want & own == is_set;
        fits.then_some(Self { mask: self.mask | own, want: self.want | is_set })
    }
}
