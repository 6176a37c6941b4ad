//! What a running component is built of, and how that is exchanged.

use std::path::PathBuf;
use std::sync::{MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

use genom_host::{CannotExchange, Component};
use genom_runtime::{NoRest, Rest};

use super::build::Build;
use super::hosted::Hosted;

impl Hosted {
    /// What it runs.
    pub fn build(&self) -> Build {
        self.build.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Path of its library.
    pub fn library(&self) -> PathBuf {
        self.build().library
    }

    /// Locks out other exchanges of its library; `None` while there is one.
    pub fn reloading(&self) -> Option<MutexGuard<'_, ()>> {
        match self.reloading.try_lock() {
            Ok(turn) => Some(turn),
            Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    /// Runs the code of `other` from now on, with the memory that it has. Waits, at most for
    /// `limit`, until it rests.
    ///
    /// # Errors
    /// It did not rest in time. Nothing was done.
    pub fn exchange(
        &self,
        other: &Component,
        build: Build,
        date: String,
        limit: Duration,
    ) -> Result<Result<(), CannotExchange>, NoRest> {
        let exchange = |rest: Rest<'_>| self.component.exchange(other, rest);
        let exchanged = self.instance.at_rest(limit, exchange)?;
        if exchanged.is_ok() {
            *self.build.lock().unwrap_or_else(PoisonError::into_inner) = build;
            self.instance.set_date(date);
        }
        Ok(exchanged)
    }
}
