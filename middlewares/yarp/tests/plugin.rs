//! Opened as a library is, through the table of `genom3/middleware.h`, YARP holds against the same
//! attacks, and the host hears how often what was refused. Ends of many components leave nothing
//! behind.

#![allow(clippy::expect_used, reason = "test code outside of test functions")]

mod attack;
mod world;

use std::sync::Arc;

use attack::Pair;
use genom_middleware::Middleware;
use genom_plugin::abi::Plugin;
use genom_plugin_host::Library;
use genom_yarp::Yarp;
use world::Place;

static TABLE: Plugin = genom_plugin::table::<Yarp>("yarp");

fn open(place: &Place) -> Arc<dyn Middleware> {
    let options = serde_json::json!({"server": place.options().server}).to_string();
    let library = Library::built_in(&TABLE).expect("a table");
    library.middleware(&options).expect("it opens")
}

#[test]
fn through_the_table_what_is_no_yarp_is_refused_and_the_host_hears_how_often() {
    attack::without_yarp(&mut Pair::new(open));
}

#[test]
fn through_the_table_bottles_that_lie_about_their_size_are_counted_at_the_host() {
    attack::with_false_sizes(&mut Pair::new(open));
}

#[test]
fn through_the_table_half_a_message_and_silence_is_counted_at_the_host() {
    attack::by_silence(&mut Pair::new(open));
}
