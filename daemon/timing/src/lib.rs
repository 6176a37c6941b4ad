//! Arithmetic of time that knows no component: zones of the values that clocks may have, the ticks of
//! tasks with periods, and what tasks that share processors, or wait for each other, cost each other.
//! Who waits for whom. And what searches take: limits, memory, circles of a graph, numbers that look random.

#![forbid(unsafe_code)]

mod below;
mod chains;
mod chosen;
mod circles;
mod dates;
mod duration;
mod limits;
mod load;
mod lock;
pub mod memory;
mod random;
mod table;
mod ticks;
mod trail;
mod zone;

pub use below::below;
pub use chains::{Ahead, Chains};
pub use chosen::dearest;
pub use circles::circles;
pub use dates::{AtLeast, earliest};
pub use duration::duration;
pub use limits::{Limit, Limits};
pub use load::{Load, alone, together};
pub use lock::{Conflicts, Lock};
pub use random::{Random, lengths};
pub use table::Table;
pub use ticks::{Period, common, cycles, gcd};
pub use trail::{Age, Trail, along};
pub use zone::{Guards, Zone};
