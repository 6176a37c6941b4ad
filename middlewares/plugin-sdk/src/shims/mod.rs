//! The functions of the table. Each reads what the host lends, does its work within
//! [`guarded`], so that no panic crosses, and gives handles as boxes or counted pointers.

mod base;
mod lists;
mod ports;
mod relay;
mod reports;
mod services;

use genom_middleware::Backend;
use genom_plugin_abi::table::{Opaque, can};
use genom_plugin_abi::{Code, ErrorText, Failure, Host, MAJOR, MINOR, Plugin, Str};

use self::base::{Opened, at, give, guarded, logged, take};
use crate::given::Functions;
use crate::logs;

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
        capabilities: can::SERVICES
            | can::DISCOVERY
            | can::RELAY
            | can::REPORTS
            | if B::GATEWAY { 0 } else { can::NO_GATEWAY },
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
        refused: Some(lists::refused),
        trouble: Some(lists::trouble),
        announce: Some(relay::announce),
        close_announced: Some(relay::close_announced),
        reply_relayed: Some(relay::reply_relayed),
        close_relayed: Some(relay::close_relayed),
        daemons: Some(relay::daemons),
        own: Some(relay::own),
        ask_all: Some(relay::ask_all),
        ask: Some(relay::ask),
        log: Some(reports::log),
        diagnose: Some(reports::diagnose),
        simulated_time: Some(reports::simulated_time),
    }
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
            (opened.middleware.relay().is_some(), can::RELAY),
            (opened.middleware.takes_reports(), can::REPORTS),
        ]
        .into_iter()
        .filter_map(|(has, flag)| has.then_some(flag))
        .fold(0, |all, flag| all | flag)
    })
}
