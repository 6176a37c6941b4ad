//! The running components: their names, their state as supervisors see it, and how they stop.

mod activities;
mod ask;
mod asked;
mod build;
mod exchange;
mod guard;
mod hosted;
mod input;
pub mod layout;
mod record;
mod remnants;
pub mod request;
mod running;
mod spins;
mod standing;
mod stop;
mod supervised;
mod unload;
mod watch;

pub use activities::Activity;
pub use build::Build;
pub use guard::Guard;
pub use hosted::{Answer, Heard, Hosted, ServedOn, ServedServices, Starting};
pub use input::{Asked, InputError, Rest};
pub use remnants::Remnant;
pub use running::{Components, Reservation, UnloadError};
pub use spins::Spin;
