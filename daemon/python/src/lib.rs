//! The daemon as a library that a Python interpreter loads (`python -m genom.runner`), so that a cell
//! runs codels in Python: the user's own interpreter, of any version, with what is installed there.
//!
//! Nothing here is linked with Python. The interpreter starts [`foreign`] with functions of its own: one
//! makes C functions of the codels in a script, one forgets them, and one tells where a codel is. From
//! then on the process is a cell as any other one, and calls codels in Python as it calls those in C.

#![deny(unsafe_code)]

pub mod foreign;
mod loaded;
mod script;
