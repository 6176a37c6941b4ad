//! Times on the clock of components: whole numbers of nanoseconds, written with a unit.

/// The text is not a time.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoDuration {
    /// There is a number only.
    #[error("a unit is missing: s, ms, us or ns")]
    NoUnit,
    /// The unit is unknown.
    #[error("unknown unit `{0}`: s, ms, us or ns")]
    Unit(String),
    /// There is no whole number before the unit.
    #[error("a whole number is wanted")]
    Number,
    /// It does not fit 64 bits.
    #[error("too long")]
    TooLong,
}

/// A whole number with a unit, such as `10ms`, in nanoseconds.
///
/// # Errors
/// The text is not of this form.
pub fn nanoseconds(text: &str) -> Result<u64, NoDuration> {
    let digits = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let scale = match unit {
        "ns" => 1,
        "us" => 1_000,
        "ms" => 1_000_000,
        "s" => 1_000_000_000,
        "" => return Err(NoDuration::NoUnit),
        other => return Err(NoDuration::Unit(other.to_owned())),
    };
    let number = number.parse::<u64>().map_err(|_| NoDuration::Number)?;
    number.checked_mul(scale).ok_or(NoDuration::TooLong)
}

/// A time in seconds, exact: `0.250000000 s`.
#[must_use]
pub fn seconds(nanoseconds: u64) -> String {
    format!("{} s", decimal(nanoseconds))
}

/// The same without the unit.
pub(crate) fn decimal(nanoseconds: u64) -> String {
    format!("{}.{:09}", nanoseconds / 1_000_000_000, nanoseconds % 1_000_000_000)
}

/// A time in the largest unit that is exact: `250ms`.
#[must_use]
pub fn short(nanoseconds: u64) -> String {
    let units = [(1_000_000_000, "s"), (1_000_000, "ms"), (1_000, "us")];
    let fits = units.into_iter().find(|(scale, _)| nanoseconds.is_multiple_of(*scale));
    let (scale, unit) = fits.unwrap_or((1, "ns"));
    format!("{}{unit}", nanoseconds / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_units() {
        assert_eq!(nanoseconds("10ms"), Ok(10_000_000));
        assert_eq!(nanoseconds("0s"), Ok(0));
        for wrong in ["10", "ms", "1.5s", "3h", "99999999999999999999s", "18446744073709551615s"] {
            assert!(nanoseconds(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn times_are_shown_exactly() {
        assert_eq!(seconds(1_250_000_001), "1.250000001 s");
        for text in ["0s", "3s", "1500ms", "7us", "123ns"] {
            assert_eq!(short(nanoseconds(text).unwrap()), text);
        }
    }
}
