//! What a component is to run after a reload.

use genom_protocol::LoadRequest;

use crate::loading::Source;

/// What a component is to run from now on.
pub(super) struct Found {
    pub(super) request: LoadRequest,
    pub(super) source: Source,
}
