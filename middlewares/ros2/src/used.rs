//! Types in use, and the hashes by which ROS nodes recognise them.

use std::sync::Arc;

use genom_rosidl::Interface;

/// A type in use.
#[derive(Debug)]
pub(crate) struct Used {
    pub(crate) whole: Interface,
    /// Definitions that are not in the library; messages within it are among them.
    pub(crate) made: Arc<Vec<Interface>>,
    pub(crate) hash: String,
}

/// The types of a service or an action; `None` if a type within is unknown, or ROS has none like
/// it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parts {
    /// Of the service, or of the one that takes goals.
    pub(crate) service: Option<Arc<Used>>,
    /// Of the service that gives results, and of the message with the feedback.
    pub(crate) get_result: Option<Arc<Used>>,
    pub(crate) feedback: Option<Arc<Used>>,
    /// The action itself.
    pub(crate) action: Option<Arc<Used>>,
}

impl Parts {
    pub(crate) fn all(&self) -> impl Iterator<Item = &Arc<Used>> {
        let Self { service, get_result, feedback, action } = self;
        [service, get_result, feedback, action].into_iter().flatten()
    }
}

/// The hash of a type.
pub(crate) fn hash(of: Option<&Arc<Used>>) -> Option<String> {
    of.map(|used| used.hash.clone())
}
