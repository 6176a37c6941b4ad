//! The properties that every middleware must have, as tests that run against each.
//!
//! A backend has this crate as a development dependency, and says in `tests/conformance.rs` how its
//! participants are created; it gets one test per property:
//!
//! ```
//! use std::sync::Arc;
//! use genom_middleware::Middleware;
//! # use genom_conformance::World;
//!
//! /// The isolated place where one test runs. Its participants reach each other.
//! struct Here;
//!
//! impl World for Here {
//!     fn join(&self) -> Arc<dyn Middleware> {
//!         unimplemented!("opens one more, as one more daemon would")
//!     }
//! }
//!
//! genom_conformance::conformance! { mine: Here }
//! ```
//!
//! The expression after the name creates a new [`World`] for each test. Services or discovery that
//! a backend does not have must be refused; their properties then check that they are.

#![forbid(unsafe_code)]
#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "this is test code: a property that does not hold panics"
)]

mod again;
mod harness;
pub mod life;
#[doc(hidden)]
pub mod portless;
pub mod ports;
pub mod process;
pub mod relay;
pub mod samples;
pub mod services;
pub mod types;

pub use again::again;
pub use harness::{World, eventually, run};

/// Defines one test per property of this suite, in a module of the given name.
///
/// `conformance! { NAME: EXPRESSION }`, where the expression creates a new [`World`].
#[macro_export]
macro_rules! conformance {
    ($($name:ident: $world:expr),+ $(,)?) => {$(
        #[cfg(test)]
        mod $name {
            use super::*;
            $crate::__properties! { __conformance_tests { $world; } }
        }
    )+};
}

/// Passes all properties on to another macro of this crate, after what is given.
#[doc(hidden)]
#[macro_export]
macro_rules! __properties {
    ($then:ident { $($before:tt)* }) => {
        $crate::$then! { $($before)*
            ports::a_reader_sees_what_was_written,
            ports::a_late_reader_sees_the_last_value,
            ports::a_reader_may_come_before_its_writer,
            ports::nothing_is_read_before_the_first_write,
            ports::latest_skips_to_the_newest,
            ports::a_queue_keeps_the_oldest_and_counts_the_rest,
            ports::a_ring_keeps_the_newest_and_counts_the_rest,
            ports::every_sample_is_read_or_counted,
            ports::a_burst_is_read_or_counted,
            ports::readers_go_at_their_own_pace,
            ports::samples_arrive_in_order,
            ports::many_ports_do_not_mix,
            ports::elements_of_a_multiple_port_are_apart,
            types::another_type_is_refused_with_both_named,
            types::a_writer_of_another_type_is_refused_with_both_named,
            types::types_of_one_name_and_other_members_are_refused,
            types::types_of_other_names_and_equal_members_connect,
            types::strings_and_nested_sequences_travel,
            types::growing_values_travel,
            types::samples_of_4_mib_travel,
            types::messages_travel_as_the_records_that_they_are,
            types::basic_types_travel,
            life::what_a_backend_says_it_can_do_it_does,
            life::a_second_writer_of_an_address_is_refused,
            life::a_writer_may_go_and_come_back,
            life::a_late_reader_sees_nothing_of_a_writer_that_left,
            life::a_closed_address_takes_another_type,
            life::discovery_shows_what_is_open_only,
            life::a_backend_may_be_closed_and_opened_again,
            life::closing_leaves_nothing_behind,
            life::ports_outlive_the_handle_they_were_opened_from,
            services::a_function_replies,
            services::an_exception_comes_back_with_its_detail,
            services::an_activity_tells_its_states_and_its_end,
            services::an_activity_is_cancelled_by_its_caller,
            services::requests_overlap_and_are_answered_apart,
            services::a_call_to_nobody_says_so,
            services::a_service_may_come_after_its_caller,
            services::a_service_that_leaves_tells_its_caller,
            services::a_second_server_of_an_address_is_refused,
            services::a_service_of_other_types_is_refused,
            services::services_show_while_they_are_served,
            services::what_a_handler_holds_is_closed_with_its_service,
            relay::a_daemon_is_asked_by_its_name_and_replies_with_its_identity,
            relay::a_daemon_that_is_not_there_is_unknown,
            relay::a_daemon_that_does_not_reply_tells_so,
            relay::requests_to_daemons_overlap_and_are_answered_apart,
            relay::a_second_daemon_of_a_name_is_refused,
        }
    };
}

/// A property that every middleware has to have.
#[derive(Clone, Copy)]
pub struct Property {
    /// Its name: a true sentence.
    pub name: &'static str,
    /// Panics if it does not hold.
    pub holds: fn(&dyn World),
}

/// Expands to the list of all properties.
#[doc(hidden)]
#[macro_export]
macro_rules! __list {
    ($($file:ident::$property:ident,)+) => {
        /// All properties, for programs that run them.
        pub const PROPERTIES: &[Property] = &[$(
            Property { name: stringify!($property), holds: $crate::$file::$property },
        )+];
    };
}

__properties! { __list { } }

/// Expands to one `#[test]` per property.
#[doc(hidden)]
#[macro_export]
macro_rules! __conformance_tests {
    ($world:expr; $($file:ident::$property:ident,)+) => {$(
        #[test]
        fn $property() {
            let world = $world;
            $crate::run(
                stringify!($property),
                ::std::sync::Arc::new(world),
                $crate::$file::$property,
            );
        }
    )+};
}
