//! What a plugin in Rust does wrong stays in it: a panic is an error of the function that was
//! called, and a backend that tells of no samples is refused.

#![allow(clippy::expect_used, clippy::panic, reason = "test code")]

use std::io;
use std::sync::Arc;

use genom_middleware::{
    Address, Backend, Capabilities, Middleware, OpenError, Policy, PortSpec, Ports, PublishError,
    Publisher, ReadError, Reading, Subscription,
};
use genom_plugin::abi::Plugin;
use genom_plugin_host::{Library, LibraryError};
use genom_types::{DataType, Kind, Record, TypeTable};

static TABLE: Plugin = genom_plugin::table::<Clumsy>("clumsy");

/// It panics where its options say.
struct Clumsy(Options);

#[derive(Clone, Default, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Options {
    opens: bool,
    writers: bool,
    writes: bool,
}

impl Backend for Clumsy {
    const NAME: &'static str = "clumsy";
    const VERSION: &'static str = "clumsy 1";
    type Options = Options;
    type Error = io::Error;

    fn open(options: Options) -> io::Result<Arc<dyn Middleware>> {
        assert!(!options.opens, "no way in");
        Ok(Arc::new(Self(options)))
    }
}

impl Middleware for Clumsy {
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

impl Ports for Clumsy {
    fn publisher(&self, _: &PortSpec<'_>) -> Result<Box<dyn Publisher>, OpenError> {
        assert!(!self.0.writers, "no pen");
        Ok(Box::new(Out(self.0.writes)))
    }

    fn subscription(
        &self,
        _: &PortSpec<'_>,
        _: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        Ok(Box::new(Silent))
    }
}

struct Out(bool);

impl Publisher for Out {
    fn publish(&mut self, _: &Record) -> Result<(), PublishError> {
        assert!(!self.0, "no ink");
        Ok(())
    }

    fn dropped(&self) -> u64 {
        0
    }
}

/// Tells of no samples.
struct Silent;

impl Subscription for Silent {
    fn read(&mut self, _: &mut Record) -> Result<Reading, ReadError> {
        Ok(Reading::Never)
    }

    fn dropped(&self) -> u64 {
        0
    }
}

fn open(options: &str) -> Result<Arc<dyn Middleware>, LibraryError> {
    Library::built_in(&TABLE).expect("a table").middleware(options)
}

fn double() -> DataType {
    let mut types = TypeTable::default();
    let double = types.add(Kind::Double);
    DataType::new(&Arc::new(types), double).expect("a type")
}

#[test]
fn a_panic_in_open_is_why_it_does_not_open() {
    let told = open("{\"opens\": true}").map(|_| ()).expect_err("it panics").to_string();
    assert_eq!(told, "the plugin panicked: no way in");
    let told = open("{\"opns\": true}").map(|_| ()).expect_err("a wrong key").to_string();
    assert!(told.contains("unknown field `opns`"), "{told}");
}

#[test]
fn a_panic_in_an_end_is_an_error_of_that_end() {
    let (at, ty) = (Address::new("demo", "position"), double());
    let clumsy = open("{\"writers\": true}").expect("it opens");
    let told = clumsy.publisher(&PortSpec::new(&at, &ty)).map(|_| ()).expect_err("it panics");
    let why = "the plugin panicked: no pen".to_owned();
    assert_eq!(told, OpenError::Failed { backend: "clumsy".to_owned(), address: at.clone(), why });
    let clumsy = open("{\"writes\": true}").expect("it opens");
    let mut writer = clumsy.publisher(&PortSpec::new(&at, &ty)).expect("a publisher");
    writer.publish(&Record::new(&ty)).expect("it is queued");
    genom_conformance::eventually("the sample counts as lost", || writer.dropped() == 1);
}

#[test]
fn a_backend_that_does_not_tell_of_samples_has_no_readers() {
    let (at, ty) = (Address::new("demo", "position"), double());
    let clumsy = open("{}").expect("it opens");
    let told = clumsy.subscription(&PortSpec::new(&at, &ty), Policy::Latest).map(|_| ());
    let told = told.expect_err("no reader").to_string();
    assert!(told.ends_with("it does not tell of samples that arrive"), "{told}");
}
