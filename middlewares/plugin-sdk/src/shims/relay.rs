//! Requests between daemons.

use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use genom_middleware::Relay;
use genom_plugin_abi::table::Opaque;
use genom_plugin_abi::{Bytes, Code, ErrorText, Failure, Str};

use super::base::{Opened, at, give, guarded, logged, take};

/// Sends the reply to a request, once; dropped, it tells that there is none.
type Answer = Box<dyn FnOnce(Vec<u8>) + Send>;

/// A request that the host answers.
struct Relayed(Mutex<Option<Answer>>);

/// What [`Relay::announce`] made.
type Announced = Box<dyn Send + Sync>;

fn relay(opened: &Opened) -> Result<&dyn Relay, Failure> {
    let none = || Failure::new(Code::UNSUPPORTED, "it passes no requests on");
    opened.middleware.relay().ok_or_else(none)
}

pub(super) unsafe extern "C" fn announce(
    backend: Opaque,
    name: Str,
    to: Opaque,
    out: *mut Opaque,
    error: *mut ErrorText,
) -> Code {
    // SAFETY: an open backend, and a string that is lent.
    let (opened, name) = unsafe { (at::<Opened>(backend), name.read()) };
    // SAFETY: as for a subscription.
    let to = unsafe { opened.host.take(to) };
    let work = || {
        if !to.relays() {
            return Err(Failure::new(Code::UNSUPPORTED, "the host takes no requests"));
        }
        let requests = move |message: Vec<u8>, answer: Answer| {
            let relayed = Box::into_raw(Box::new(Relayed(Mutex::new(Some(answer)))));
            if !to.relayed(relayed.cast(), &message) {
                // SAFETY: it came from a box, and the host did not get it.
                drop(unsafe { Box::from_raw(relayed) });
            }
        };
        let announced = relay(opened)?.announce(&name, Box::new(requests))?;
        // SAFETY: the host has room for a handle.
        unsafe { give::<Announced>(out, announced) };
        Ok(())
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

pub(super) unsafe extern "C" fn close_announced(announced: Opaque) {
    // SAFETY: the host closes it once.
    let announced = unsafe { take::<Announced>(announced) };
    logged(None, move || drop(announced));
}

pub(super) unsafe extern "C" fn reply_relayed(relayed: Opaque, reply: Bytes) {
    // SAFETY: a request that is not closed, and bytes that are lent.
    let (relayed, reply) = unsafe { (at::<Relayed>(relayed), reply.read()) };
    logged(None, || {
        let answer = relayed.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(answer) = answer {
            answer(reply.to_vec());
        }
    });
}

pub(super) unsafe extern "C" fn close_relayed(relayed: Opaque) {
    // SAFETY: the host closes it once.
    let relayed = unsafe { take::<Relayed>(relayed) };
    logged(None, move || drop(relayed));
}

pub(super) unsafe extern "C" fn daemons(
    backend: Opaque,
    list: Opaque,
    error: *mut ErrorText,
) -> Code {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    let work = || {
        let names = relay(opened)?.daemons();
        let names = names.map_err(|error| Failure::new(Code::FAILED, error.why))?;
        let list = opened.host.list(list);
        names.iter().for_each(|name| list.text(name, ""));
        Ok(())
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

pub(super) unsafe extern "C" fn own(backend: Opaque, list: Opaque) {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    logged(Some(opened.host), || {
        if let Some(relay) = opened.middleware.relay() {
            opened.host.list(list).text(&relay.own(), "");
        }
    });
}

pub(super) unsafe extern "C" fn ask_all(
    backend: Opaque,
    name: Str,
    request: Bytes,
    patience: u64,
    list: Opaque,
    error: *mut ErrorText,
) -> Code {
    // SAFETY: an open backend, and a string and bytes that are lent.
    let (opened, name, request) = unsafe { (at::<Opened>(backend), name.read(), request.read()) };
    let work = || {
        let patience = Duration::from_nanos(patience);
        let replies = relay(opened)?.ask_all(&name, request, patience)?;
        let list = opened.host.list(list);
        replies.iter().for_each(|(from, reply)| list.reply(from, reply));
        Ok(())
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

pub(super) unsafe extern "C" fn ask(
    backend: Opaque,
    name: Str,
    end: Str,
    request: Bytes,
    patience: u64,
    list: Opaque,
    error: *mut ErrorText,
) -> Code {
    // SAFETY: an open backend, and strings that are lent.
    let (opened, name, end) = unsafe { (at::<Opened>(backend), name.read(), end.read()) };
    // SAFETY: the bytes are lent.
    let request = unsafe { request.read() };
    let work = || {
        let patience = Duration::from_nanos(patience);
        let reply = relay(opened)?.ask(&name, &end, request, patience)?;
        opened.host.list(list).reply(&end, &reply);
        Ok(())
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}
