//! Which port of a component is meant.

/// A port by its index, or an element of a multiple one.
pub type Key = (usize, Option<String>);

/// The key of a port, or of an element of a multiple one.
pub fn key(port: usize, element: Option<&str>) -> Key {
    (port, element.map(str::to_owned))
}
