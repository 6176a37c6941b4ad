//! Requests between daemons through a backend in Rust, called as a host does: it takes one reply to
//! each, none after that, and is not announced to a host that takes no requests.

#![allow(
    clippy::expect_used,
    unsafe_code,
    reason = "test code, which calls a table as a host does"
)]

use std::io;
use std::mem::offset_of;
use std::ptr;
use std::sync::atomic::{AtomicPtr, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use genom_middleware::{
    AnnounceError, AskError, Backend, Capabilities, DiscoverError, Middleware, OnRequest, Relay,
};
use genom_plugin::abi::table::Opaque;
use genom_plugin::abi::{Bytes, Code, Host, MAJOR, Plugin, Str};
use genom_plugin_host::Library;

static TABLE: Plugin = genom_plugin::table::<Switchboard>("switchboard");

/// Whom requests are passed to.
static REQUESTS: Mutex<Option<Arc<OnRequest>>> = Mutex::new(None);

/// The tests share it.
static TURN: Mutex<()> = Mutex::new(());

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A backend with one daemon.
struct Switchboard;

impl Backend for Switchboard {
    const NAME: &'static str = "switchboard";
    const VERSION: &'static str = "switchboard 1";
    type Options = serde_json::Value;
    type Error = io::Error;

    fn open(_: serde_json::Value) -> io::Result<Arc<dyn Middleware>> {
        Ok(Arc::new(Self))
    }
}

impl Middleware for Switchboard {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities { services: false, native_services: false, ..Capabilities::NETWORK }
    }

    fn relay(&self) -> Option<&dyn Relay> {
        Some(self)
    }
}

genom_conformance::portless!(Switchboard);

/// Withdraws the daemon when it is dropped.
struct Announced;

impl Drop for Announced {
    fn drop(&mut self) {
        lock(&REQUESTS).take();
    }
}

fn silent(why: &str) -> AskError {
    let (name, backend) = ("robot".to_owned(), "switchboard".to_owned());
    AskError::Silent { name, backend, why: why.to_owned() }
}

impl Relay for Switchboard {
    fn announce(
        &self,
        name: &str,
        requests: Box<OnRequest>,
    ) -> Result<Box<dyn Send + Sync>, AnnounceError> {
        assert_ne!(name, "panic", "no daemon of that name");
        *lock(&REQUESTS) = Some(requests.into());
        Ok(Box::new(Announced))
    }

    fn daemons(&self) -> Result<Vec<String>, DiscoverError> {
        Ok(vec!["robot".to_owned()])
    }

    fn own(&self) -> String {
        "here".to_owned()
    }

    fn ask_all(
        &self,
        _: &str,
        request: &[u8],
        _: Duration,
    ) -> Result<Vec<(String, Vec<u8>)>, AskError> {
        let requests = lock(&REQUESTS).clone().ok_or_else(|| silent("nobody"))?;
        let replies = Arc::new(Mutex::new(Vec::new()));
        let to = Arc::clone(&replies);
        requests(
            request.to_vec(),
            Box::new(move |reply| lock(&to).push(("here".to_owned(), reply))),
        );
        Ok(lock(&replies).clone())
    }

    fn ask(
        &self,
        name: &str,
        at: &str,
        request: &[u8],
        patience: Duration,
    ) -> Result<Vec<u8>, AskError> {
        assert_eq!((name, at, patience), ("robot", "here", Duration::from_millis(1500)));
        let all = self.ask_all(name, request, patience)?;
        all.into_iter().next().map(|(_, reply)| reply).ok_or_else(|| silent("it went away"))
    }
}

#[test]
fn requests_and_replies_pass_through_the_table_in_both_directions() {
    let _turn = lock(&TURN);
    let library = Library::built_in(&TABLE).expect("a table");
    let middleware = library.middleware("{}").expect("it opens");
    let relay = middleware.relay().expect("requests between daemons");
    let announced = relay.announce(
        "robot",
        Box::new(|mut request, answer| {
            if !request.is_empty() {
                request.push(b'!');
                answer(request);
            }
        }),
    );
    let announced = announced.expect("it is announced");
    assert_eq!(relay.daemons(), Ok(vec!["robot".to_owned()]));
    let (own, patience) = (relay.own(), Duration::from_millis(1500));
    assert_eq!(relay.ask("robot", &own, b"ping", patience), Ok(b"ping!".to_vec()));
    let all = relay.ask_all("robot", b"ping", patience);
    assert_eq!(all, Ok(vec![("here".to_owned(), b"ping!".to_vec())]));
    assert_eq!(relay.ask("robot", &own, b"", patience), Err(silent("it went away")));
    drop(announced);
    assert_eq!(relay.ask("robot", &own, b"ping", patience), Err(silent("nobody")));
    let told = relay.announce("panic", Box::new(|_, _| ())).map(|_| ()).expect_err("a panic");
    assert!(told.to_string().contains("the plugin panicked: "), "{told}");
}

/// The last request that the host of these tests was passed.
static PASSED: AtomicPtr<std::ffi::c_void> = AtomicPtr::new(ptr::null_mut());

static RELEASED: AtomicU32 = AtomicU32::new(0);

unsafe extern "C" fn relayed(_: Opaque, relayed: Opaque, _: Bytes) {
    PASSED.store(relayed, Ordering::Relaxed);
}

unsafe extern "C" fn release(_: Opaque) {
    RELEASED.fetch_add(1, Ordering::Relaxed);
}

fn host(size: usize) -> Host {
    Host {
        size,
        major: MAJOR,
        minor: 2,
        flags: 0,
        host: ptr::null_mut(),
        log: None,
        release: Some(release),
        sample: None,
        request: None,
        cancel: None,
        answer: None,
        endpoint: None,
        text: None,
        refusal: None,
        relayed: Some(relayed),
        replied: None,
    }
}

/// Opens the backend for a host, announces a daemon, and closes the backend after the work.
fn with_daemon(host: &Host, work: impl FnOnce(Code, Opaque)) {
    let (mut backend, mut announced) = (ptr::null_mut(), ptr::null_mut());
    let (open, close) = (TABLE.open.expect("it"), TABLE.close.expect("it"));
    let announce = TABLE.announce.expect("it");
    // SAFETY: a table as a host has it, options, and room for a handle.
    let code = unsafe { open(host, Str::of("{}"), &raw mut backend, ptr::null_mut()) };
    assert_eq!(code, Code::OK);
    let (name, none) = (Str::of("robot"), ptr::null_mut());
    // SAFETY: an open backend, what the host gives, and room for a handle; there may be no error.
    let code = unsafe { announce(backend, name, none, &raw mut announced, ptr::null_mut()) };
    work(code, announced);
    // SAFETY: an open backend, which is closed once.
    unsafe { close(backend) };
}

#[test]
fn a_second_reply_and_one_after_the_daemon_was_withdrawn_change_nothing() {
    let _turn = lock(&TURN);
    let released = RELEASED.load(Ordering::Relaxed);
    with_daemon(&host(size_of::<Host>()), |code, announced| {
        assert_eq!(code, Code::OK);
        let requests = lock(&REQUESTS).clone().expect("announced");
        let replies = Arc::new(Mutex::new(Vec::new()));
        let to = Arc::clone(&replies);
        requests(b"ping".to_vec(), Box::new(move |reply| lock(&to).push(reply)));
        let passed = PASSED.load(Ordering::Relaxed);
        let reply = TABLE.reply_relayed.expect("it");
        for text in [b"first", b"other"] {
            // SAFETY: a request that is not closed, and bytes that are lent.
            unsafe { reply(passed, Bytes::of(text)) };
        }
        // SAFETY: it was announced, and is closed once.
        unsafe { TABLE.close_announced.expect("it")(announced) };
        // SAFETY: as above.
        unsafe { reply(passed, Bytes::of(b"after")) };
        // SAFETY: a request that is closed once.
        unsafe { TABLE.close_relayed.expect("it")(passed) };
        assert_eq!(*lock(&replies), [b"first"]);
        assert_eq!(Arc::strong_count(&replies), 1, "what a reply needs is dropped with it");
        assert_eq!(RELEASED.load(Ordering::Relaxed), released, "requests may still come");
        drop(requests);
    });
    assert_eq!(RELEASED.load(Ordering::Relaxed), released + 1);
}

#[test]
fn a_host_of_version_1_1_has_no_daemon_announced() {
    let _turn = lock(&TURN);
    let released = RELEASED.load(Ordering::Relaxed);
    with_daemon(&host(offset_of!(Host, relayed)), |code, announced| {
        assert_eq!(code, Code::UNSUPPORTED);
        assert!(announced.is_null() && lock(&REQUESTS).is_none());
    });
    assert_eq!(RELEASED.load(Ordering::Relaxed), released + 1);
}
