//! What the last deployment did, in all processes of a daemon.

use std::sync::Arc;

use genom_supervisor::deploy::Done;

use crate::cell::Cell;
use crate::wants::Want;

/// What a deployment did in all processes.
#[derive(Default)]
pub(crate) struct Round {
    /// What was done in this process.
    pub(crate) own: Option<Done>,
    /// Components that were loaded into cells, in this order.
    pub(crate) loaded: Vec<String>,
    /// Cells that applied their part, in this order.
    pub(crate) applied: Vec<Arc<Cell>>,
    /// What connections of before needed of other processes, by in port.
    pub(crate) needed: Vec<(String, Want)>,
}
