//! An out port whose samples a sending thread sends, as the runtime sees it.

use std::sync::Arc;

use genom_middleware::{PublishError, Publisher};
use genom_types::Record;

use crate::outlet::Outlet;
use crate::sender::{Duty, Orders};

/// Fills the outlet of a line, and marks the line.
pub struct OutPort<D: Duty> {
    outlet: Arc<Outlet>,
    orders: Orders<D>,
    line: usize,
    /// Counts samples that were lost behind the outlet.
    lost: Box<dyn Fn() -> u64 + Send>,
    end: Option<Box<dyn FnOnce(usize) + Send>>,
}

impl<D: Duty> OutPort<D> {
    /// The port of the line with this number. `end` removes the line when the port is dropped.
    #[must_use]
    pub fn new(
        outlet: Arc<Outlet>,
        orders: &Orders<D>,
        line: usize,
        end: impl FnOnce(usize) + Send + 'static,
    ) -> Self {
        let (orders, lost) = (orders.clone(), Box::new(|| 0));
        Self { outlet, orders, line, lost, end: Some(Box::new(end)) }
    }

    /// Makes it count samples as dropped, too, that were lost behind the outlet.
    #[must_use]
    pub fn and_lost(mut self, lost: impl Fn() -> u64 + Send + 'static) -> Self {
        self.lost = Box::new(lost);
        self
    }
}

impl<D: Duty> Publisher for OutPort<D> {
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        self.outlet.put(value)?;
        self.orders.mark(self.line);
        Ok(())
    }

    fn publish_message(&mut self, message: &[u8]) -> Option<Result<(), PublishError>> {
        let put = self.outlet.put_message(message);
        self.orders.mark(self.line);
        Some(put)
    }

    fn dropped(&self) -> u64 {
        self.outlet.dropped() + (self.lost)()
    }
}

impl<D: Duty> Drop for OutPort<D> {
    fn drop(&mut self) {
        if let Some(end) = self.end.take() {
            end(self.line);
        }
    }
}
