//! What components log, how they fare, and whether their time is that of a simulator.

use genom_plugin_abi::Entry;
use genom_plugin_abi::table::{Diagnosis, Opaque};

use super::base::{Opened, at, logged};
use crate::types;

pub(super) unsafe extern "C" fn log(backend: Opaque, entry: *const Entry) {
    // SAFETY: an open backend, and an entry that is lent.
    let (opened, entry) = unsafe { (at::<Opened>(backend), types::entry(entry)) };
    logged(Some(opened.host), || {
        if let Some(entry) = entry {
            opened.middleware.log(&entry);
        }
    });
}

pub(super) unsafe extern "C" fn diagnose(
    backend: Opaque,
    parts: *const *const Diagnosis,
    count: usize,
) {
    // SAFETY: an open backend, and diagnoses that are lent.
    let (opened, parts) = unsafe { (at::<Opened>(backend), types::parts(parts, count)) };
    logged(Some(opened.host), || opened.middleware.diagnose(&parts));
}

pub(super) unsafe extern "C" fn simulated_time(backend: Opaque) {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    logged(Some(opened.host), || opened.middleware.simulated_time());
}
