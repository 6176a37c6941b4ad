//! Formats quantities with a few digits and a unit.

pub use genom_protocol::units::bytes;

/// A duration in nanoseconds.
#[allow(clippy::cast_precision_loss, reason = "a few digits are shown")]
#[must_use]
pub fn duration(ns: u64) -> String {
    let value = ns as f64;
    match ns {
        0..1_000 => format!("{ns} ns"),
        1_000..1_000_000 => format!("{:.3} us", value / 1e3),
        1_000_000..1_000_000_000 => format!("{:.3} ms", value / 1e6),
        _ => format!("{:.3} s", value / 1e9),
    }
}

/// A duration in seconds, such as a jitter.
#[must_use]
pub fn seconds(value: f64) -> String {
    if value == 0.0 {
        "0 s".to_owned()
    } else if value < 1e-3 {
        format!("{:.1} us", value * 1e6)
    } else if value < 1.0 {
        format!("{:.3} ms", value * 1e3)
    } else {
        format!("{value:.3} s")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_have_units() {
        assert_eq!(duration(999), "999 ns");
        assert_eq!(duration(5_000_000), "5.000 ms");
        assert_eq!(seconds(0.000_012_34), "12.3 us");
        assert_eq!(seconds(0.0), "0 s");
        assert_eq!(bytes(16.0), "16 B");
        assert_eq!(bytes(3200.0), "3.20 kB");
    }
}
