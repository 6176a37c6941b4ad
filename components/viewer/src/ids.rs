//! The internal data structure.

use genom::{Data, Native};

use crate::album::Album;
use crate::types::Summary;

/// The internal data structure.
#[derive(Data)]
#[genom(name = "::viewer::ids")]
#[repr(C)]
pub(crate) struct Ids {
    pub(crate) album: Native<Album>,
    pub(crate) seen: Summary,
}
