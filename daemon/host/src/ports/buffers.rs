//! The buffer or buffers of a port.

use std::sync::Arc;

use super::element::Element;
use super::multiple::Elements;

/// The buffers that the methods of a port use.
#[derive(Clone)]
pub(super) enum Buffers {
    Simple(Arc<Element>),
    Multiple(Arc<Elements>),
}
