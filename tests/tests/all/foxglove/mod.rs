//! The live source for Foxglove, as a client of the packages of Foxglove's own app sees it, and as
//! hostile programs do.

mod access;
mod hostile;
mod live;
mod raw;
mod robot;
mod scale;
mod visitor;
