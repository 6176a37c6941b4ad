//! Views: arguments in memory, as codels get them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use mlua::{Error, Result};

use crate::foreign::At;
use crate::layout::Types;

/// A call of a codel, with which its arguments end.
#[derive(Clone, Debug)]
pub(crate) struct Life(Arc<(AtomicBool, u64)>);

impl Life {
    pub(crate) fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Self(Arc::new((AtomicBool::new(true), NEXT.fetch_add(1, Ordering::Relaxed))))
    }

    /// Which call it is.
    pub(crate) fn number(&self) -> u64 {
        self.0.1
    }

    pub(crate) fn end(&self) {
        self.0.0.store(false, Ordering::Relaxed);
    }

    /// # Errors
    /// The call has ended: the memory may be another's.
    pub(crate) fn check(&self) -> Result<()> {
        if self.0.0.load(Ordering::Relaxed) {
            return Ok(());
        }
        let text = "the codel that it was an argument of has returned: keep values, not views \
                    (genom.copy)";
        Err(Error::runtime(text))
    }
}

/// How memory may be used.
#[derive(Clone, Debug)]
pub(crate) struct Access {
    /// It cannot be changed.
    pub(crate) constant: bool,
    pub(crate) life: Life,
}

/// A value with parts, or a place for one without.
#[derive(Debug)]
pub(crate) struct View {
    pub(crate) types: Arc<Types>,
    pub(crate) ty: usize,
    pub(crate) at: At,
    pub(crate) access: Access,
}
