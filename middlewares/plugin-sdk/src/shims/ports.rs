//! The two ends of a port.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use genom_middleware::PortSpec;
use genom_plugin_abi::table::Opaque;
use genom_plugin_abi::{Bytes, Code, ErrorText, Failure, Port};

use super::base::{Opened, at, give, guarded, logged, take};
use crate::ends::{Feed, Writer};
use crate::types;

pub(super) unsafe extern "C" fn publisher(
    backend: Opaque,
    port: *const Port,
    out: *mut Opaque,
    error: *mut ErrorText,
) -> Code {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    let work = || {
        // SAFETY: the port is lent.
        let port = unsafe { types::port(port) }?;
        let spec = PortSpec::new(&port.at, &port.ty).of(port.quality);
        let writer = Writer::new(opened.middleware.publisher(&spec)?, &port.ty);
        // SAFETY: the host has room for a handle.
        unsafe { give(out, writer) };
        Ok(())
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

pub(super) unsafe extern "C" fn publish(publisher: Opaque, sample: Bytes) -> Code {
    // SAFETY: an open publisher, and bytes that are lent.
    let (writer, sample) = unsafe { (at::<Writer>(publisher), sample.read()) };
    catch_unwind(AssertUnwindSafe(|| writer.write(sample))).unwrap_or(Code::FAILED)
}

pub(super) unsafe extern "C" fn lost_by_publisher(publisher: Opaque) -> u64 {
    // SAFETY: an open publisher.
    let writer = unsafe { at::<Writer>(publisher) };
    logged(None, || writer.lost())
}

pub(super) unsafe extern "C" fn close_publisher(publisher: Opaque) {
    // SAFETY: the host closes it once.
    let writer = unsafe { take::<Writer>(publisher) };
    logged(None, move || drop(writer));
}

pub(super) unsafe extern "C" fn subscription(
    backend: Opaque,
    port: *const Port,
    to: Opaque,
    out: *mut Opaque,
    error: *mut ErrorText,
) -> Code {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    // SAFETY: the host gave it for this end; it is released when it is dropped, also if this fails.
    let to = unsafe { opened.host.take(to) };
    let work = || {
        // SAFETY: the port is lent.
        let port = unsafe { types::port(port) }?;
        let spec = PortSpec::new(&port.at, &port.ty).of(port.quality);
        let subscription = opened.middleware.subscription(&spec, port.policy)?;
        let silent = || Failure::new(Code::FAILED, "it does not tell of samples that arrive");
        let feed = Feed::start(subscription, to, &port.ty).ok_or_else(silent)?;
        // SAFETY: the host has room for a handle.
        unsafe { give(out, feed) };
        Ok(())
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

pub(super) unsafe extern "C" fn lost_by_subscription(subscription: Opaque) -> u64 {
    // SAFETY: an open subscription.
    let feed = unsafe { at::<Arc<Feed>>(subscription) };
    logged(None, || feed.lost())
}

pub(super) unsafe extern "C" fn close_subscription(subscription: Opaque) {
    // SAFETY: the host closes it once.
    let feed = unsafe { take::<Arc<Feed>>(subscription) };
    logged(None, move || feed.close());
}
