//! The earliest dates that bounds between them allow.

/// That one date is at least another one plus a time, which may be negative.
#[derive(Clone, Copy, Debug)]
pub struct AtLeast {
    /// Number of a date.
    pub later: usize,
    /// And of the other one.
    pub earlier: usize,
    /// The time between them.
    pub by: i64,
}

/// The earliest dates, none of them below zero, if there are any.
#[must_use]
pub fn earliest(count: usize, rules: &[AtLeast]) -> Vec<i64> {
    let mut dates = vec![0i64; count];
    // If there are any, no circle of rules moves dates on for ever.
    for _ in 0..count {
        let mut moved = false;
        for rule in rules {
            let least = dates[rule.earlier] + rule.by;
            if dates[rule.later] < least {
                (dates[rule.later], moved) = (least, true);
            }
        }
        if !moved {
            break;
        }
    }
    dates
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_as_early_as_each_rule_allows() {
        let rule = |later, earlier, by| AtLeast { later, earlier, by };
        // The second is 5 after the first, and the first not before 3 before the third, at 10.
        let rules = [rule(1, 0, 5), rule(2, 1, 0), rule(2, 0, 10), rule(1, 2, -3)];
        assert_eq!(earliest(3, &rules), [0, 7, 10]);
    }
}
