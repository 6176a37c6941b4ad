//! Which samples of a recording may be published to which in ports.

use genom_protocol::{Address, Port, PortDirection, Ports};

/// In nanoseconds: samples further apart cannot be of one recording.
pub const MOST_APART: u64 = 366 * 24 * 3600 * 1_000_000_000;

/// The in port of this address, if it is one; of an element of a multiple port that is not there
/// yet, the port itself.
#[must_use]
pub fn inport<'a>(known: &'a Ports, port: &Address) -> Option<&'a Port> {
    let wanted = port.to_string();
    let own = |one: &&Port| one.address == wanted;
    let element = |one: &&Port| one.multiple && wanted.starts_with(&format!("{}/", one.address));
    let inports = || known.ports.iter().filter(|one| one.direction == PortDirection::In);
    inports().find(own).or_else(|| inports().find(element))
}

/// Whether two definitions of a message are the same: comments and blanks do not count. Samples of
/// another type would be misread.
#[must_use]
pub fn same_type(one: &[u8], other: &[u8]) -> bool {
    lines(one) == lines(other)
}

/// The lines of a definition without comments and blanks.
fn lines(definition: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(definition);
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default());
    let words = lines.map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "));
    words.filter(|line| !line.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_blanks_make_no_other_type() {
        let one = b"float64 position  # m\n\n# all of it\nfloat64 speed\n";
        assert!(same_type(one, b"float64 position\nfloat64   speed"));
        assert!(!same_type(one, b"float64 position\nfloat32 speed"));
    }
}
