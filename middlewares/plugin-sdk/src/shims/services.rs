//! Services, served and called.

use std::sync::{Arc, Mutex};

use genom_middleware::Served;
use genom_plugin_abi::answers::Said;
use genom_plugin_abi::table::Opaque;
use genom_plugin_abi::{Address, Answer, Bytes, Code, ErrorText, Service};

use super::base::{Opened, at, give, guarded, logged, take};
use crate::requests::{Call, Calling, Handler, Run, sides};
use crate::types;

pub(super) unsafe extern "C" fn serve(
    backend: Opaque,
    place: Address,
    service: *const Service,
    to: Opaque,
    out: *mut Opaque,
    error: *mut ErrorText,
) -> Code {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    // SAFETY: as for a subscription.
    let to = unsafe { opened.host.take(to) };
    let work = || {
        // SAFETY: both are lent.
        let (address, service) = unsafe { (types::address(place), types::service(service)?) };
        let sides = sides(opened.middleware.name(), &address, &service);
        let handler = Handler { to, output: service.output.clone(), sides };
        let served = opened.middleware.serve(&address, &service, Arc::new(handler))?;
        // SAFETY: the host has room for a handle.
        unsafe { give::<Box<dyn Served>>(out, served) };
        Ok(())
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

pub(super) unsafe extern "C" fn close_served(served: Opaque) {
    // SAFETY: the host closes it once.
    let served = unsafe { take::<Box<dyn Served>>(served) };
    logged(None, move || drop(served));
}

pub(super) unsafe extern "C" fn reply(call: Opaque, answer: *const Answer) {
    // SAFETY: a request that is not closed, and an answer that is lent.
    let call = unsafe { at::<Call>(call) };
    logged(None, || {
        // SAFETY: as above.
        if let Some(said) = unsafe { Said::read(answer, &call.output, &call.sides) } {
            call.waiting.tell(said);
        }
    });
}

pub(super) unsafe extern "C" fn close_call(call: Opaque) {
    // SAFETY: the host closes it once.
    let call = unsafe { take::<Call>(call) };
    logged(None, move || drop(call));
}

pub(super) unsafe extern "C" fn client(
    backend: Opaque,
    place: Address,
    service: *const Service,
    out: *mut Opaque,
    error: *mut ErrorText,
) -> Code {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    let work = || {
        // SAFETY: both are lent.
        let (address, service) = unsafe { (types::address(place), types::service(service)?) };
        let client = Mutex::new(opened.middleware.client(&address, &service)?);
        // SAFETY: the host has room for a handle.
        unsafe { give(out, Calling { client, input: service.input, host: opened.host }) };
        Ok(())
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

pub(super) unsafe extern "C" fn request(
    client: Opaque,
    input: Bytes,
    to: Opaque,
    out: *mut Opaque,
    error: *mut ErrorText,
) -> Code {
    // SAFETY: an open client, and bytes that are lent.
    let (calling, input) = unsafe { (at::<Calling>(client), input.read()) };
    // SAFETY: as for a subscription.
    let to = unsafe { calling.host.take(to) };
    let work = || {
        let run = calling.request(input, to)?;
        // SAFETY: the host has room for a handle.
        unsafe { give(out, run) };
        Ok(())
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

pub(super) unsafe extern "C" fn cancel(run: Opaque) {
    // SAFETY: a request that is not closed.
    let run = unsafe { at::<Run>(run) };
    logged(None, || run.0.cancel());
}

pub(super) unsafe extern "C" fn close_run(run: Opaque) {
    // SAFETY: the host closes it once.
    let run = unsafe { take::<Run>(run) };
    logged(None, move || drop(run));
}

pub(super) unsafe extern "C" fn close_client(client: Opaque) {
    // SAFETY: the host closes it once.
    let client = unsafe { take::<Calling>(client) };
    logged(None, move || drop(client));
}
