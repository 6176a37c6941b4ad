//! IDL values as JSON (genom3.md appendix A, with `true` and `false`).
//!
//! | IDL | written | read |
//! |---|---|---|
//! | boolean | `true`, `false` | also 0 and 1 |
//! | integers, octet | number | number without fraction |
//! | float, double | number, NaN `null`, infinities `"inf"` `"-inf"` | same |
//! | char | string of one character, code 0 to 255 | also its code as a number, -128 to 127 |
//! | string | string, bytes that are no UTF-8 as U+FFFD | string without NUL, within its bound |
//! | enum | short name, `"<invalid>"` out of range | short or full name |
//! | struct, exception | object | any members in any order; others keep their value |
//! | union | `{"d": discriminant, "u": {"member": value}}` | either may be missing |
//! | array | array | array or `{"index": value}`; missing elements keep their value |
//! | sequence | array | array gives the length; `{"index": value}` keeps or raises it |
//! | optional | value or `null` | same |
//! | native | `null` | `null`: unchanged |

mod error;
pub(crate) mod exact;
mod missing;
mod read;
mod write;

pub use error::{JsonError, JsonProblem};
pub use exact::{Exact, Places};
pub(crate) use missing::missing;
pub(crate) use read::{merge, push_index, push_name, single, whole};
pub(crate) use write::write;
