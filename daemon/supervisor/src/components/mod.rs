//! The running components: their names, their state as supervisors see it, and how they stop.

mod activities;
mod ask;
mod asked;
mod build;
mod exchange;
mod frozen;
mod guard;
mod hosted;
mod input;
pub mod layout;
mod prepared;
mod record;
mod remnants;
pub mod request;
mod running;
mod spins;
mod standing;
mod stop;
mod supervised;
mod tracked;
mod turn;
mod unload;
mod watch;

pub use activities::Activity;
pub use build::Build;
pub use frozen::FreezeError;
pub use guard::Guard;
pub use hosted::{Answer, Heard, Hosted, ServedOn, ServedServices, Starting};
pub use input::{Asked, InputError, Rest};
pub use prepared::Unfit;
pub(crate) use prepared::prepare;
pub use remnants::Remnant;
pub use running::{Components, Reservation, UnloadError};
pub use spins::Spin;
