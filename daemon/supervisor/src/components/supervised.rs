//! What a running component is supervised by.

use std::time::Duration;

use genom_protocol::Rule;

use super::hosted::Hosted;

impl Hosted {
    /// What it is supervised by, and how often each rule was broken.
    pub fn rules(&self) -> Vec<Rule> {
        self.guard.told(self.instance.violations())
    }

    /// Looks for codels that do not return in time and for missed ticks. Returns when to look
    /// again, if any rule needs that.
    pub(crate) fn supervise(&self) -> Option<Duration> {
        if self.guard.is_empty() { None } else { self.instance.supervise() }
    }
}
