//! Exchanges the code of a component that runs, while its memory stays.

use genom_runtime::Rest;

use super::{CannotExchange, Component};

impl Component {
    /// Exchanges the code of this component, which rests, with that of `other`, loaded from the
    /// same description and not running. From now on the other one holds the library that ran until
    /// now: when it is dropped, that is closed by the rule of all libraries. The memory stays: IDS,
    /// ports and runs keep their addresses.
    ///
    /// # Errors
    /// It does not rest, or the descriptions differ.
    pub fn exchange(&self, other: &Self, rest: Rest<'_>) -> Result<(), CannotExchange> {
        if !rest.is_of(self) {
            return Err(CannotExchange::NotAtRest);
        }
        if !self.inner.is_like(&other.inner) {
            return Err(CannotExchange::Unlike);
        }
        self.inner.exchange(&other.inner, rest);
        Ok(())
    }

    /// Whether a thread may be in the code of its library. Stale addresses on stacks, which
    /// disappear when the threads run on, count as well.
    #[must_use]
    pub fn is_in_code(&self) -> bool {
        self.inner.code.get().library.is_run()
    }
}
