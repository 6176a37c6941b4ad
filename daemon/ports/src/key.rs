//! Identifies a port of a component.

use genom_runtime::PortIx;

/// A port of a component, or an element of a multiple one.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PortKey {
    /// Index of the port in the component's description.
    pub port: PortIx,
    /// Name of the element, if the port is multiple.
    pub element: Option<String>,
}

impl PortKey {
    /// The key of a port, or of one of its elements.
    #[must_use]
    pub fn new(port: PortIx, element: Option<&str>) -> Self {
        Self { port, element: element.map(str::to_owned) }
    }

    /// Name of the element, if the port is multiple.
    #[must_use]
    pub fn element(&self) -> Option<&str> {
        self.element.as_deref()
    }
}
