//! A middleware of genomd in a library of its own: wraps any [`Backend`] as the table of
//! `genom3/middleware.h`.
//!
//! ```toml
//! [lib]
//! crate-type = ["cdylib"]
//! ```
//!
//! ```ignore
//! genom_plugin::export!(mine::Mine);
//! ```
//!
//! `genomd --backend ./libgenomd_mine.so` opens it. Samples cross as messages in CDR, which
//! [`publish_message`](genom_middleware::Publisher::publish_message) and
//! [`read_message`](genom_middleware::Subscription::read_message) pass on as they are, where a
//! backend has them. Its subscriptions must tell of samples
//! ([`on_arrival`](genom_middleware::Subscription::on_arrival)). What the backend logs through
//! `tracing` is in the log of genomd; a panic in a function becomes an error of that function.

mod ends;
mod given;
mod logs;
mod requests;
mod shims;
mod types;

pub use genom_middleware::Backend;
pub use genom_plugin_abi as abi;
pub use shims::table;

/// Exports a [`Backend`] as the table of this library, under its own name or another one:
/// `export!(Mine)`, `export!(Mine, "other")`.
#[macro_export]
macro_rules! export {
    ($backend:ty) => {
        $crate::export!($backend, <$backend as $crate::Backend>::NAME);
    };
    ($backend:ty, $name:expr) => {
        /// What genomd looks for in this library.
        #[unsafe(no_mangle)]
        #[allow(non_upper_case_globals, reason = "the name in the header")]
        pub static genom_middleware_plugin: $crate::abi::Plugin = $crate::table::<$backend>($name);
    };
}
