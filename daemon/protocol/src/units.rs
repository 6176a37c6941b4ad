//! Numbers with units, for messages.

/// A size in bytes; append `/s` for a bandwidth.
#[must_use]
pub fn bytes(value: f64) -> String {
    let units = [("GB", 1e9), ("MB", 1e6), ("kB", 1e3)];
    match units.iter().find(|(_, scale)| value >= *scale) {
        Some((unit, scale)) => format!("{:.2} {unit}", value / scale),
        None if value.fract() == 0.0 => format!("{value} B"),
        None => format!("{value:.1} B"),
    }
}
