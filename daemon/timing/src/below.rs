//! Below which time something would have to stay.

/// Times are found to this many nanoseconds.
const STEP: u64 = 1_000;

/// The time from which on something does not hold, if it does not with the greatest one, and holds with
/// the least; in whole steps, so that it is a round number.
pub fn below(least: u64, most: u64, mut holds: impl FnMut(u64) -> bool) -> Option<u64> {
    let (mut fine, mut wrong) = (least, most);
    if fine >= wrong || !holds(fine) {
        return None;
    }
    while wrong - fine > STEP {
        let middle = fine + (wrong - fine) / 2;
        let middle = (middle / STEP * STEP).max(fine + 1);
        if holds(middle) { fine = middle } else { wrong = middle }
    }
    Some(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_round_number_from_which_on_it_does_not_hold() {
        assert_eq!(below(0, 10_000_000, |time| time < 6_000_500), Some(6_001_000));
        assert_eq!(below(0, 10_000_000, |_| false), None);
        assert_eq!(below(5, 5, |_| true), None);
    }
}
