//! What a running component is built of, and how that is exchanged.

use std::path::PathBuf;
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use genom_host::{CannotExchange, Component, Contents};
use genom_runtime::{NoRest, Rest};

use super::build::Build;
use super::hosted::Hosted;
use super::turn::Turn;

impl Hosted {
    /// What it runs.
    pub fn build(&self) -> Build {
        self.build.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Path of its library.
    pub fn library(&self) -> PathBuf {
        self.build().library
    }

    /// Whether its library is being exchanged.
    pub fn is_reloading(&self) -> Arc<Turn> {
        Arc::clone(&self.reloading)
    }

    /// What its library was loaded from, whatever the file holds by now.
    pub(crate) fn contents(&self) -> Option<Contents> {
        self.component.contents()
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
