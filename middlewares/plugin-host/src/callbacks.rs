//! The functions that a library may call.
//!
//! What it was given is a counted pointer to a [`Given`], which `release` takes back. No panic goes
//! into the library: it is logged here.

#![allow(unsafe_code, reason = "a library calls these with pointers that it was given")]

use std::borrow::Cow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use genom_middleware::{ActivityId, CallError, Endpoint, EndpointKind, Outcome, Refused, Replies};
use genom_plugin_abi::answers::Said;
use genom_plugin_abi::table::{Opaque, endpoint, level};
use genom_plugin_abi::{Answer, Bytes, Host, MAJOR, MINOR, Str};
use genom_types::Record;

use crate::calls::{Call, Relayed};
use crate::given::{Given, Serving};
use crate::library::Library;
use crate::listing::{self, Listed};

/// The functions, for a library that is not known yet.
pub(crate) fn table() -> Host {
    Host {
        size: size_of::<Host>(),
        major: MAJOR,
        minor: MINOR,
        flags: 0,
        host: std::ptr::null_mut(),
        log: Some(log),
        release: Some(release),
        sample: Some(sample),
        request: Some(request),
        cancel: Some(cancel),
        answer: Some(answer),
        endpoint: Some(add_endpoint),
        text: Some(add_text),
        refusal: Some(add_refusal),
        relayed: Some(relayed),
        replied: Some(add_reply),
    }
}

/// A pointer to be given to a library, which releases it.
pub(crate) fn give(given: Given) -> Opaque {
    Arc::into_raw(Arc::new(given)).cast_mut().cast()
}

fn held(work: impl FnOnce()) {
    if catch_unwind(AssertUnwindSafe(work)).is_err() {
        tracing::error!("a call from a middleware's library panicked");
    }
}

/// # Safety
/// `to` was given and is not released.
unsafe fn given<'a>(to: Opaque) -> Option<&'a Given> {
    // SAFETY: `give` made it; the library keeps it until it releases it.
    unsafe { to.cast::<Given>().as_ref() }
}

unsafe extern "C" fn log(host: Opaque, severity: u32, text: Str) {
    // SAFETY: the host's pointer is the library, which lives as long as the program.
    let Some(library) = (unsafe { host.cast::<Library>().as_ref() }) else { return };
    // SAFETY: the text is lent.
    let text = unsafe { text.read() };
    held(|| {
        let name = library.name();
        match severity {
            level::ERROR => tracing::error!("{name}: {text}"),
            level::WARN => tracing::warn!("{name}: {text}"),
            level::INFO => tracing::info!("{name}: {text}"),
            _ => tracing::debug!("{name}: {text}"),
        }
    });
}

unsafe extern "C" fn release(to: Opaque) {
    if !to.is_null() {
        // SAFETY: `give` made it of a counted pointer, and this is its only release.
        let given = unsafe { Arc::from_raw(to.cast::<Given>().cast_const()) };
        held(move || drop(given));
    }
}

unsafe extern "C" fn sample(to: Opaque, data: Bytes) {
    // SAFETY: given and not released; the bytes are lent.
    let (given, data) = unsafe { (given(to), data.read()) };
    if let Some(Given::Inbox(inbox)) = given {
        held(|| inbox.arrive(data));
    }
}

unsafe extern "C" fn request(to: Opaque, call: Opaque, input: Bytes) {
    // SAFETY: given and not released; the bytes are lent.
    let (given, input) = unsafe { (given(to), input.read()) };
    if let Some(Given::Served(serving)) = given {
        held(|| serve(serving, Call::new(serving.library, call), input));
    }
}

fn serve(serving: &Serving, call: Call, input: &[u8]) {
    let back = Back(call);
    let mut record = Record::new(&serving.service.input);
    match record.decode_message(input) {
        Ok(()) => serving.handler.request(record, Box::new(back)),
        Err(error) => {
            let error = CallError::Serialization(error.to_string());
            Box::new(back).finish(Outcome::Lost(error));
        }
    }
}

/// Answers to a request that a library passed on. The request is closed when it is dropped.
struct Back(Call);

impl Replies for Back {
    fn accepted(&mut self, id: ActivityId) {
        self.0.reply(Said::Accepted(id));
    }

    fn feedback(&mut self, state: &str) {
        self.0.reply(Said::State(state.to_owned()));
    }

    fn finish(self: Box<Self>, outcome: Outcome) {
        self.0.reply(Said::End(outcome));
    }
}

unsafe extern "C" fn cancel(to: Opaque, run: u64) {
    // SAFETY: given and not released.
    if let Some(Given::Served(serving)) = unsafe { given(to) } {
        held(|| serving.handler.cancel(ActivityId(run)));
    }
}

unsafe extern "C" fn answer(to: Opaque, answer: *const Answer) {
    // SAFETY: given and not released.
    let Some(Given::Call(call)) = (unsafe { given(to) }) else { return };
    held(|| {
        // SAFETY: the answer is lent.
        if let Some(said) = unsafe { Said::read(answer, &call.output, &call.sides) } {
            call.waiting.tell(said);
        }
    });
}

unsafe extern "C" fn relayed(to: Opaque, relayed: Opaque, request: Bytes) {
    // SAFETY: given and not released; the bytes are lent.
    let (given, request) = unsafe { (given(to), request.read()) };
    if let Some(Given::Daemon(daemon)) = given {
        held(|| daemon.arrive(Relayed::new(daemon.library, relayed), request));
    }
}

unsafe extern "C" fn add_endpoint(list: Opaque, kind: u32, address: Str, ty: Str) {
    // SAFETY: the strings are lent.
    let (address, ty) = unsafe { (address.read(), ty.read()) };
    let kind = match kind {
        endpoint::OUT_PORT => EndpointKind::Publisher,
        endpoint::IN_PORT => EndpointKind::Subscription,
        endpoint::SERVICE => EndpointKind::Service,
        _ => return,
    };
    added(list, address.len() + ty.len(), |listed| {
        let (address, ty) = (address.into_owned(), ty.into_owned());
        listed.endpoints.push(Endpoint { kind, address, ty });
    });
}

unsafe extern "C" fn add_text(list: Opaque, key: Str, value: Str) {
    // SAFETY: the strings are lent.
    let (key, value) = unsafe { (key.read(), value.read()) };
    added(list, key.len() + value.len(), |listed| {
        listed.texts.push((key.into_owned(), value.into_owned()));
    });
}

unsafe extern "C" fn add_refusal(list: Opaque, why: Str, count: u64, peer: Str) {
    // SAFETY: the strings are lent.
    let (why, peer) = unsafe { (why.read(), peer.read()) };
    added(list, why.len(), |listed| {
        let why = Cow::Owned(why.into_owned());
        listed.refused.push(Refused { why, count, peer: peer.parse().ok() });
    });
}

unsafe extern "C" fn add_reply(list: Opaque, from: Str, reply: Bytes) {
    // SAFETY: both are lent.
    let (from, reply) = unsafe { (from.read(), reply.read()) };
    held(|| {
        if let Some(list) = listing::find(list) {
            list.reply(&from, reply);
        }
    });
}

/// Adds an entry of so many bytes to a list.
fn added(list: Opaque, bytes: usize, with: impl FnOnce(&mut Listed)) {
    held(|| {
        if let Some(list) = listing::find(list) {
            list.add(bytes, with);
        }
    });
}
