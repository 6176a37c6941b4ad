//! What clients see of running components: their values as streams, every sample of ports in the
//! columns of a plot, images, histograms of durations, the changes of the last minutes, and what is
//! wrong: why a port is silent, and what the doctor finds.
//!
//! Each handler takes what it shows from the supervisor, in threads of the control plane. Nothing is
//! taken of a port that nobody asks for; of one that is plotted, codels put samples on a tape, as
//! for a recording.

#![forbid(unsafe_code)]

mod clock;
mod columns;
mod doctor;
mod histograms;
mod images;
pub mod layout;
mod named;
mod picture;
mod plots;
mod refused;
mod timeline;
mod together;
mod values;
mod why;

pub use clock::stepped;
#[doc(hidden)]
pub use doctor::__path_doctor;
pub use doctor::doctor;
#[doc(hidden)]
pub use histograms::__path_histograms;
pub use histograms::histograms;
#[doc(hidden)]
pub use images::__path_image;
pub use images::image;
pub use named::{activities_of, find, find_activity, find_port, find_until_closed, key};
#[doc(hidden)]
pub use plots::__path_plots;
pub use plots::plots;
pub use refused::{held_up, not_connected, not_published};
#[doc(hidden)]
pub use timeline::__path_timeline;
pub use timeline::timeline;
#[doc(hidden)]
pub use values::__path_stream;
pub use values::stream;
#[doc(hidden)]
pub use why::__path_why;
pub use why::why;
