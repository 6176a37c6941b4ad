//! Arithmetic of time that knows no component: zones of the values that clocks may have, the ticks of
//! tasks with periods, and what tasks that share processors cost each other.

#![forbid(unsafe_code)]

mod duration;
mod load;
mod ticks;
mod zone;

pub use duration::duration;
pub use load::{Load, alone, together};
pub use ticks::{Period, common, cycles};
pub use zone::{Guards, Zone};
