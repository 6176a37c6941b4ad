//! What the thread that talks with the name server is asked to do.

use std::sync::Arc;

use crate::io::Answer;
use crate::port::Port;
use crate::wire::Carrier;

/// A job of the steward.
pub(crate) enum Job {
    /// Connect an out port to a reader, of which the name is known.
    Connect { port: Arc<Port>, to: String, carrier: Carrier, answer: Answer },
    /// Look for out ports now.
    Look,
    /// End.
    End,
}
