//! The functions of the table. Each reads what the host lends, does its work within
//! [`guarded`], so that no panic crosses, and gives handles as boxes or counted pointers.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex};

use genom_middleware::{Backend, EndpointKind, Middleware, PortSpec, Served};
use genom_plugin_abi::answers::Said;
use genom_plugin_abi::table::{Opaque, can, endpoint, level};
use genom_plugin_abi::{
    Address, Answer, Bytes, Code, ErrorText, Failure, Host, MAJOR, MINOR, Plugin, Port, Service,
    Str,
};

use crate::ends::{Feed, Writer};
use crate::given::{Functions, List};
use crate::requests::{Call, Calling, Handler, Run, sides};
use crate::{logs, types};

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
        publisher: Some(publisher),
        publish: Some(publish),
        close_publisher: Some(close_publisher),
        subscription: Some(subscription),
        close_subscription: Some(close_subscription),
        capabilities_of: Some(capabilities_of),
        lost_by_publisher: Some(lost_by_publisher),
        lost_by_subscription: Some(lost_by_subscription),
        serve: Some(serve),
        close_served: Some(close_served),
        reply: Some(reply),
        close_call: Some(close_call),
        client: Some(client),
        request: Some(request),
        cancel: Some(cancel),
        close_run: Some(close_run),
        close_client: Some(close_client),
        discover: Some(discover),
        ends_at: Some(ends_at),
        spelled: Some(spelled),
        strangers: Some(strangers),
        obstacles: Some(obstacles),
        masquerade: Some(masquerade),
        unmask: Some(unmask),
        meeting_point: Some(meeting_point),
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

unsafe extern "C" fn publisher(
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

unsafe extern "C" fn publish(publisher: Opaque, sample: Bytes) -> Code {
    // SAFETY: an open publisher, and bytes that are lent.
    let (writer, sample) = unsafe { (at::<Writer>(publisher), sample.read()) };
    catch_unwind(AssertUnwindSafe(|| writer.write(sample))).unwrap_or(Code::FAILED)
}

unsafe extern "C" fn lost_by_publisher(publisher: Opaque) -> u64 {
    // SAFETY: an open publisher.
    let writer = unsafe { at::<Writer>(publisher) };
    logged(None, || writer.lost())
}

unsafe extern "C" fn close_publisher(publisher: Opaque) {
    // SAFETY: the host closes it once.
    let writer = unsafe { take::<Writer>(publisher) };
    logged(None, move || drop(writer));
}

unsafe extern "C" fn subscription(
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

unsafe extern "C" fn lost_by_subscription(subscription: Opaque) -> u64 {
    // SAFETY: an open subscription.
    let feed = unsafe { at::<Arc<Feed>>(subscription) };
    logged(None, || feed.lost())
}

unsafe extern "C" fn close_subscription(subscription: Opaque) {
    // SAFETY: the host closes it once.
    let feed = unsafe { take::<Arc<Feed>>(subscription) };
    logged(None, move || feed.close());
}

unsafe extern "C" fn serve(
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

unsafe extern "C" fn close_served(served: Opaque) {
    // SAFETY: the host closes it once.
    let served = unsafe { take::<Box<dyn Served>>(served) };
    logged(None, move || drop(served));
}

unsafe extern "C" fn reply(call: Opaque, answer: *const Answer) {
    // SAFETY: a request that is not closed, and an answer that is lent.
    let call = unsafe { at::<Call>(call) };
    logged(None, || {
        // SAFETY: as above.
        if let Some(said) = unsafe { Said::read(answer, &call.output, &call.sides) } {
            call.waiting.tell(said);
        }
    });
}

unsafe extern "C" fn close_call(call: Opaque) {
    // SAFETY: the host closes it once.
    let call = unsafe { take::<Call>(call) };
    logged(None, move || drop(call));
}

unsafe extern "C" fn client(
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

unsafe extern "C" fn request(
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

unsafe extern "C" fn cancel(run: Opaque) {
    // SAFETY: a request that is not closed.
    let run = unsafe { at::<Run>(run) };
    logged(None, || run.0.cancel());
}

unsafe extern "C" fn close_run(run: Opaque) {
    // SAFETY: the host closes it once.
    let run = unsafe { take::<Run>(run) };
    logged(None, move || drop(run));
}

unsafe extern "C" fn close_client(client: Opaque) {
    // SAFETY: the host closes it once.
    let client = unsafe { take::<Calling>(client) };
    logged(None, move || drop(client));
}

fn tell(ends: Vec<genom_middleware::Endpoint>, list: &List) {
    for end in ends {
        let kind = match end.kind {
            EndpointKind::Publisher => endpoint::OUT_PORT,
            EndpointKind::Subscription => endpoint::IN_PORT,
            EndpointKind::Service => endpoint::SERVICE,
        };
        list.endpoint(kind, &end.address, &end.ty);
    }
}

unsafe extern "C" fn discover(backend: Opaque, list: Opaque, error: *mut ErrorText) -> Code {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    let work = || {
        let ends = opened.middleware.discover();
        let ends = ends.map_err(|error| Failure::new(Code::FAILED, error.why))?;
        tell(ends, &opened.host.list(list));
        Ok(())
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

unsafe extern "C" fn ends_at(
    backend: Opaque,
    place: Address,
    list: Opaque,
    error: *mut ErrorText,
) -> Code {
    // SAFETY: an open backend, and an address that is lent.
    let (opened, address) = unsafe { (at::<Opened>(backend), types::address(place)) };
    let work = || {
        let ends = opened.middleware.ends_at(&address);
        let ends = ends.map_err(|error| Failure::new(Code::FAILED, error.why))?;
        tell(ends, &opened.host.list(list));
        Ok(())
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

unsafe extern "C" fn spelled(backend: Opaque, place: Address, list: Opaque) {
    // SAFETY: an open backend, and an address that is lent.
    let (opened, address) = unsafe { (at::<Opened>(backend), types::address(place)) };
    logged(Some(opened.host), || {
        opened.host.list(list).text(&opened.middleware.spelled(&address), "");
    });
}

unsafe extern "C" fn strangers(backend: Opaque, list: Opaque) {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    logged(Some(opened.host), || {
        let list = opened.host.list(list);
        for stranger in opened.middleware.strangers() {
            match stranger {
                genom_middleware::Stranger::Reader { address } => list.text(&address, ""),
                genom_middleware::Stranger::Session { name, role } => list.text(&name, &role),
            }
        }
    });
}

unsafe extern "C" fn obstacles(backend: Opaque, place: Address, list: Opaque) {
    // SAFETY: an open backend, and an address that is lent.
    let (opened, address) = unsafe { (at::<Opened>(backend), types::address(place)) };
    logged(Some(opened.host), || {
        let list = opened.host.list(list);
        for obstacle in opened.middleware.obstacles(&address) {
            list.text(&obstacle.what, &obstacle.fix);
        }
    });
}

unsafe extern "C" fn masquerade(
    backend: Opaque,
    ours: Str,
    foreign: Str,
    error: *mut ErrorText,
) -> Code {
    // SAFETY: an open backend, and strings that are lent.
    let (opened, ours, foreign) = unsafe { (at::<Opened>(backend), ours.read(), foreign.read()) };
    let work = || {
        let shown = opened.middleware.masquerade(&ours, &foreign);
        shown.map_err(|error| Failure::new(Code::UNSUPPORTED, error.form))
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

unsafe extern "C" fn unmask(backend: Opaque, ours: Str) {
    // SAFETY: an open backend, and a string that is lent.
    let (opened, ours) = unsafe { (at::<Opened>(backend), ours.read()) };
    logged(Some(opened.host), || opened.middleware.unmask(&ours));
}

unsafe extern "C" fn meeting_point(backend: Opaque, list: Opaque) {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    logged(Some(opened.host), || {
        let list = opened.host.list(list);
        opened.middleware.meeting_point().iter().for_each(|(name, value)| list.text(name, value));
    });
}
