//! Which port of a component is meant.

use genom_runtime::PortIx;

/// A port of a component, or an element of a multiple one.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PortKey {
    /// The port, by its place in the component's description.
    pub port: PortIx,
    /// The element, of a multiple port.
    pub element: Option<String>,
}

impl PortKey {
    /// A port, or one of its elements.
    #[must_use]
    pub fn new(port: PortIx, element: Option<&str>) -> Self {
        Self { port, element: element.map(str::to_owned) }
    }

    /// The element, of a multiple port.
    #[must_use]
    pub fn element(&self) -> Option<&str> {
        self.element.as_deref()
    }
}
