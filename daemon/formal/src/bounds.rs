//! Limits on what clients ask, which keep the number of states finite.

/// Limits on what clients ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Activities of one service at the same time; further requests for it are not made.
    pub instances: usize,
    /// Requests at the same time.
    pub requests: usize,
    /// Slots of a task for activities of services, as the instance has.
    pub slots: usize,
    /// Whether clients abort activities.
    pub abort: bool,
    /// Whether external events are fired.
    pub fire: bool,
    /// Whether the component is shut down.
    pub kill: bool,
}

impl Default for Bounds {
    fn default() -> Self {
        let slots = genom_runtime::ACTIVITY_LIMIT;
        Self { instances: 2, requests: 1, slots, abort: true, fire: true, kill: true }
    }
}
