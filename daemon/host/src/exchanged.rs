//! A value that codels use and that is exchanged while none of them runs. One of the few unsafe
//! modules.
#![allow(unsafe_code)]

use std::marker::PhantomData;
use std::sync::atomic::{AtomicPtr, Ordering};

/// Holds a value, which codels read without a lock.
#[derive(Debug)]
pub(crate) struct Exchanged<T>(AtomicPtr<T>, PhantomData<T>);

impl<T> Exchanged<T> {
    pub(crate) fn new(value: T) -> Self {
        Self(AtomicPtr::new(Box::into_raw(Box::new(value))), PhantomData)
    }

    /// The present value. What it refers to lives as long as its holder: this one, or after a
    /// [`swap`](Self::swap) the other one.
    #[inline]
    pub(crate) fn get(&self) -> &T {
        // SAFETY: the pointer comes from a box, which is dropped with its holder only; who swaps
        // makes sure that nobody uses the value when that happens.
        unsafe { &*self.0.load(Ordering::Acquire) }
    }

    pub(crate) fn get_mut(&mut self) -> &mut T {
        // SAFETY: as above, and nobody else has access to the holder.
        unsafe { &mut **self.0.get_mut() }
    }

    /// Swaps the values of two holders.
    ///
    /// # Safety
    /// Nobody swaps one of them at the same time. What `get` of the one returned before is not
    /// used any more when the other one is dropped, and the other way round.
    pub(crate) unsafe fn swap(&self, other: &Self) {
        let own = self.0.swap(other.0.load(Ordering::Acquire), Ordering::AcqRel);
        other.0.store(own, Ordering::Release);
    }
}

impl<T> Drop for Exchanged<T> {
    fn drop(&mut self) {
        // SAFETY: the pointer comes from a box, and each holder has one of its own.
        drop(unsafe { Box::from_raw(*self.0.get_mut()) });
    }
}
