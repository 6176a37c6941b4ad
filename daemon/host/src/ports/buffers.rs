//! The buffer or buffers of a port.

use std::sync::Arc;

use super::element::Element;
use super::multiple::Elements;

/// What the functions of a port work on.
#[derive(Clone)]
pub(super) enum Buffers {
    Simple(Arc<Element>),
    Multiple(Arc<Elements>),
}
