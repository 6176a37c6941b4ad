//! What the table costs a sample, beside the same calls without it: `cargo bench -p
//! genom-plugin-host`. The middleware does nothing, so that only the way to it is measured.

#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    missing_docs,
    reason = "a program that measures"
)]

use std::convert::Infallible;
use std::hint::black_box;
use std::ptr;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use genom_kit::mailbox::{Full, Mailbox};
use genom_middleware::{
    Address, Backend, Capabilities, Middleware, OpenError, Policy, PortSpec, Ports, PublishError,
    Publisher, ReadError, Reading, Subscription,
};
use genom_plugin::abi::{Bytes, Plugin, Port};
use genom_plugin_host::Library;
use genom_types::{DataType, Kind, Record, TypeTable};

/// Calls in a row of which the mean is taken; the least of the rounds is printed.
const CALLS: u32 = 1_000_000;
const ROUNDS: usize = 7;

static TABLE: Plugin = genom_plugin::table::<Nothing>("nothing");

/// What is told of a sample, by the last subscription.
static TOLD: Mutex<Option<Arc<dyn Fn() + Send + Sync>>> = Mutex::new(None);

struct Nothing;

#[derive(serde::Deserialize)]
struct Options {}

impl Backend for Nothing {
    const NAME: &'static str = "nothing";
    const VERSION: &'static str = "1";
    type Options = Options;
    type Error = Infallible;

    fn open(_: Options) -> Result<Arc<dyn Middleware>, Infallible> {
        Ok(Arc::new(Self))
    }
}

impl Middleware for Nothing {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            variable_size: true,
            zero_copy: false,
            cross_process: false,
            cross_host: false,
            services: false,
            native_services: false,
        }
    }
}

impl Ports for Nothing {
    fn publisher(&self, _: &PortSpec<'_>) -> Result<Box<dyn Publisher>, OpenError> {
        Ok(Box::new(Out))
    }

    fn subscription(
        &self,
        port: &PortSpec<'_>,
        _: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        let mut message = Vec::new();
        Record::new(port.ty).encode_message(&mut message).expect("a message");
        Ok(Box::new(In { message, left: 0 }))
    }
}

struct Out;

impl Publisher for Out {
    fn publish(&mut self, _: &Record) -> Result<(), PublishError> {
        Err(PublishError::Refused)
    }

    fn publish_message(&mut self, message: &[u8]) -> Option<Result<(), PublishError>> {
        black_box(message);
        Some(Ok(()))
    }

    fn dropped(&self) -> u64 {
        0
    }
}

/// Has a sample each time it is told of one.
struct In {
    message: Vec<u8>,
    left: u32,
}

impl Subscription for In {
    fn read(&mut self, _: &mut Record) -> Result<Reading, ReadError> {
        Err(ReadError::Broken)
    }

    fn read_message(&mut self, into: &mut Vec<u8>) -> Option<Result<Reading, ReadError>> {
        self.left = 1 - self.left;
        if self.left == 0 {
            return Some(Ok(Reading::Same));
        }
        into.clear();
        into.extend_from_slice(&self.message);
        Some(Ok(Reading::New))
    }

    fn on_arrival(&mut self, told: Box<dyn Fn() + Send + Sync>) -> bool {
        *TOLD.lock().expect("not poisoned") = Some(Arc::from(told));
        true
    }

    fn dropped(&self) -> u64 {
        0
    }
}

fn octets(length: u32) -> DataType {
    let mut types = TypeTable::default();
    let octet = types.add(Kind::Octet);
    let id = types.add(Kind::Array { element: octet, length });
    DataType::new(&Arc::new(types), id).expect("a type")
}

/// Nanoseconds of a call.
fn measured(mut call: impl FnMut()) -> f64 {
    let round = |_| {
        let start = Instant::now();
        (0..CALLS).for_each(|_| call());
        start.elapsed().as_nanos() as f64 / f64::from(CALLS)
    };
    (0..ROUNDS).map(round).fold(f64::INFINITY, f64::min)
}

fn print(what: &str, size: u32, direct: f64, table: f64) {
    let (more, ratio) = (table - direct, table / direct);
    println!("{what:<10} {size:>6} {direct:>9.1} {table:>9.1} {more:>+9.1} {ratio:>7.2}");
}

fn main() {
    println!("ns a sample    B    direct     table     more   ratio");
    let at = Address::new("demo", "position");
    for size in [64, 4096] {
        let ty = octets(size);
        let mut message = Vec::new();
        Record::new(&ty).encode_message(&mut message).expect("a message");
        out(&at, &ty, size, &message);
        arrival(&at, &ty, size);
    }
}

/// A thread of the host gives a sample to the middleware.
fn out(at: &Address, ty: &DataType, size: u32, message: &[u8]) {
    let spec = PortSpec::new(at, ty);
    let mut writer = black_box(Nothing.publisher(&spec).expect("a publisher"));
    let direct = measured(|| {
        let _ = black_box(writer.publish_message(black_box(message)));
    });
    let table = black_box(&TABLE);
    let (mut backend, mut handle) = (ptr::null_mut(), ptr::null_mut());
    let definition = serde_json::to_string(&genom_types::Definition::of(ty)).expect("JSON");
    let text = genom_plugin::abi::Str::of;
    let described = genom_plugin::abi::Type {
        size: size_of::<genom_plugin::abi::Type>(),
        name: text(ty.name()),
        digest: text(ty.digest()),
        definition: text(&definition),
        bytes: ty.size() as u64,
        align: 1,
        flags: 1,
    };
    let address = genom_plugin::abi::Address { instance: text("demo"), name: text("position") };
    let port = Port {
        size: size_of::<Port>(),
        at: address,
        ty: &described,
        reliable: -1,
        transient_local: -1,
        depth: -1,
        policy: 0,
        keep: 1,
    };
    let host = genom_plugin::abi::Host {
        size: 16,
        major: 1,
        minor: 0,
        flags: 0,
        host: ptr::null_mut(),
        log: None,
        release: None,
        sample: None,
        request: None,
        cancel: None,
        answer: None,
        endpoint: None,
        text: None,
        refusal: None,
        relayed: None,
        replied: None,
    };
    let (open, publisher) = (table.open.expect("it"), table.publisher.expect("it"));
    // SAFETY: the table is that of the SDK; what is lent lives until the calls return.
    unsafe { open(&host, text("{}"), &raw mut backend, ptr::null_mut()) };
    // SAFETY: as above.
    unsafe { publisher(backend, &port, &raw mut handle, ptr::null_mut()) };
    let publish = black_box(table.publish.expect("it"));
    let through = measured(|| {
        // SAFETY: the publisher is open, and the bytes are lent.
        black_box(unsafe { publish(handle, Bytes::of(black_box(message))) });
    });
    print("publish", size, direct, through);
}

/// A thread of the middleware gives a sample to the host, which puts it into a mailbox.
fn arrival(at: &Address, ty: &DataType, size: u32) {
    let spec = PortSpec::new(at, ty);
    let mailbox = Mailbox::new(1, size as usize + 64, Full::Oldest).dated();
    let mut reader = black_box(Nothing.subscription(&spec, Policy::Latest).expect("a reader"));
    let mut message = Vec::new();
    let direct = measured(|| {
        while let Some(Ok(Reading::New)) = reader.read_message(&mut message) {
            let _ = mailbox.put(|buffer| {
                buffer.extend_from_slice(&message);
                Ok::<_, Infallible>(())
            });
        }
    });
    let library = Library::built_in(&TABLE).expect("a table");
    let open = library.middleware("{}").expect("it opens");
    let _reader = open.subscription(&spec, Policy::Latest).expect("a reader");
    let told = TOLD.lock().expect("not poisoned").clone().expect("a subscription");
    let through = measured(|| told());
    print("arrival", size, direct, through);
}
