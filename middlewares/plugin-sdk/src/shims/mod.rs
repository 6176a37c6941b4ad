//! The functions of the table. Each reads what the host lends, does its work within
//! [`guarded`], so that no panic crosses, and gives handles as boxes or counted pointers.

mod lists;
mod ports;
mod services;

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use genom_middleware::{Backend, Middleware};
use genom_plugin_abi::table::{Opaque, can, level};
use genom_plugin_abi::{Code, ErrorText, Failure, Host, MAJOR, MINOR, Plugin, Str};

use crate::given::Functions;
use crate::logs;

/// An open backend.
struct Opened {
    middleware: Arc<dyn Middleware>,
    host: Functions,
}

/// The table of a backend, under this name.
#[must_use]
pub const fn table<B: Backend + 'static>(name: &'static str) -> Plugin {
    Plugin {
        size: size_of::<Plugin>(),
        major: MAJOR,
        minor: MINOR,
        reserved: 0,
        name: Str::of(name),
        version: Str::of(B::VERSION),
        // What it can do is known when it is open.
        capabilities: can::SERVICES | can::DISCOVERY | if B::GATEWAY { 0 } else { can::NO_GATEWAY },
        open: Some(open::<B>),
        close: Some(close),
        publisher: Some(ports::publisher),
        publish: Some(ports::publish),
        close_publisher: Some(ports::close_publisher),
        subscription: Some(ports::subscription),
        close_subscription: Some(ports::close_subscription),
        capabilities_of: Some(capabilities_of),
        lost_by_publisher: Some(ports::lost_by_publisher),
        lost_by_subscription: Some(ports::lost_by_subscription),
        serve: Some(services::serve),
        close_served: Some(services::close_served),
        reply: Some(services::reply),
        close_call: Some(services::close_call),
        client: Some(services::client),
        request: Some(services::request),
        cancel: Some(services::cancel),
        close_run: Some(services::close_run),
        close_client: Some(services::close_client),
        discover: Some(lists::discover),
        ends_at: Some(lists::ends_at),
        spelled: Some(lists::spelled),
        strangers: Some(lists::strangers),
        obstacles: Some(lists::obstacles),
        masquerade: Some(lists::masquerade),
        unmask: Some(lists::unmask),
        meeting_point: Some(lists::meeting_point),
    }
}

fn said(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

/// Runs the work of a function that can fail; a panic is a failure.
///
/// # Safety
/// `error` is null, or an error that the host lent.
unsafe fn guarded(error: *mut ErrorText, work: impl FnOnce() -> Result<(), Failure>) -> Code {
    let done = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let why = format!("the plugin panicked: {}", said(&*panic));
        Err(Failure::new(Code::FAILED, why))
    });
    match done {
        Ok(()) => Code::OK,
        Err(failure) => {
            // SAFETY: as for this function.
            unsafe { ErrorText::write(error, &failure) };
            failure.code
        }
    }
}

/// Runs the work of a function that has no way to tell of a failure but the log.
fn logged<T: Default>(host: Option<Functions>, work: impl FnOnce() -> T) -> T {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        if let Some(host) = host {
            host.log(level::ERROR, &format!("the plugin panicked: {}", said(&*panic)));
        }
        T::default()
    })
}

/// Gives a value to the host as a handle.
///
/// # Safety
/// `out` is writable.
unsafe fn give<T>(out: *mut Opaque, value: T) {
    // SAFETY: as for this function.
    unsafe { out.write(Box::into_raw(Box::new(value)).cast()) };
}

/// What a handle stands for.
///
/// # Safety
/// [`give`] gave it as a `T`, and it is not closed while the result is used.
unsafe fn at<'a, T>(handle: Opaque) -> &'a T {
    // SAFETY: as for this function.
    unsafe { &*handle.cast::<T>() }
}

/// Takes back a handle.
///
/// # Safety
/// [`give`] gave it as a `T`, and nobody uses it any more.
unsafe fn take<T>(handle: Opaque) -> Box<T> {
    // SAFETY: as for this function.
    unsafe { Box::from_raw(handle.cast::<T>()) }
}

unsafe extern "C" fn open<B: Backend + 'static>(
    host: *const Host,
    options: Str,
    out: *mut Opaque,
    error: *mut ErrorText,
) -> Code {
    let work = || {
        let incomplete = || Failure::new(Code::FAILED, "the host gave no functions");
        // SAFETY: the host gave its table.
        let host = unsafe { Functions::of(host) }.ok_or_else(incomplete)?;
        // SAFETY: the options are lent.
        let options = unsafe { options.read() };
        let options = serde_json::from_str::<B::Options>(&options)
            .map_err(|error| Failure::new(Code::FAILED, error.to_string()))?;
        logs::to(host);
        let refused = |error: B::Error| Failure::new(Code::FAILED, error.to_string());
        B::check(&options).map_err(refused)?;
        let middleware = B::open(options).map_err(refused)?;
        // SAFETY: the host has room for a handle.
        unsafe { give(out, Opened { middleware, host }) };
        Ok(())
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

unsafe extern "C" fn close(backend: Opaque) {
    // SAFETY: the host closes it once, after all its ends.
    let opened = unsafe { take::<Opened>(backend) };
    logged(Some(opened.host), move || drop(opened));
}

unsafe extern "C" fn capabilities_of(backend: Opaque) -> u64 {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    logged(Some(opened.host), || {
        let has = opened.middleware.capabilities();
        let services = has.services && opened.middleware.services().is_some();
        let discovery = opened.middleware.discovery().is_some();
        [
            (has.variable_size, can::VARIABLE),
            (has.cross_process, can::CROSS_PROCESS),
            (has.cross_host, can::CROSS_HOST),
            (services, can::SERVICES),
            (services && has.native_services, can::NATIVE_SERVICES),
            (discovery, can::DISCOVERY),
        ]
        .into_iter()
        .filter_map(|(has, flag)| has.then_some(flag))
        .fold(0, |all, flag| all | flag)
    })
}
