//! The mistakes of a file, as they are found.

use std::cell::RefCell;
use std::ops::Range;

use crate::source::Mistake;

/// Mistakes found so far.
#[derive(Debug, Default)]
pub(crate) struct Found(RefCell<Vec<Mistake>>);

impl Found {
    pub(crate) fn add(&self, span: Range<usize>, message: impl Into<String>, help: Option<String>) {
        self.0.borrow_mut().push(Mistake { span, message: message.into(), help });
    }

    /// In the order of the file.
    pub(crate) fn take(self) -> Vec<Mistake> {
        let mut all = self.0.into_inner();
        all.sort_by_key(|mistake| mistake.span.start);
        all
    }
}
