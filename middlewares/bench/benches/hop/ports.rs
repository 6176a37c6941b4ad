//! An out port of each kind of type, and the in port that reads it.

use genom_bench::octets;
use genom_bench::pair::{Receive, Send};
use genom_middleware::{Address, Middleware, Policy};
use genom_types::Record;

use crate::ends::{reader, writer};

fn values(bytes: usize) -> [(Address, Record); 2] {
    let at = |kind| Address::new("bench", format!("{kind}{bytes}"));
    [(at("array"), octets::array(bytes)), (at("sequence"), octets::sequence(bytes))]
}

pub(crate) fn writers(of: &dyn Middleware, bytes: usize) -> [Box<dyn Send>; 2] {
    values(bytes).map(|(at, value)| writer(of, &at, value))
}

pub(crate) fn readers(of: &dyn Middleware, bytes: usize) -> [Box<dyn Receive>; 2] {
    values(bytes).map(|(at, value)| reader(of, &at, value, Policy::Latest))
}
