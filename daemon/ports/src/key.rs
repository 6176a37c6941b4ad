//! Which port of a component is meant.

/// A port of a component, or an element of a multiple one.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PortKey {
    /// Its rank in the component's description.
    pub port: usize,
    /// The element, of a multiple port.
    pub element: Option<String>,
}

impl PortKey {
    /// A port, or one of its elements.
    #[must_use]
    pub fn new(port: usize, element: Option<&str>) -> Self {
        Self { port, element: element.map(str::to_owned) }
    }

    /// The element, of a multiple port.
    #[must_use]
    pub fn element(&self) -> Option<&str> {
        self.element.as_deref()
    }
}
