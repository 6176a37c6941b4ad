//! The web console: who may come in, what its pages show, and what they do.

mod access;
mod accessible;
mod crowd;
mod foreign;
mod graph;
mod pages;
mod pictures;
mod plots;
mod sessions;
mod sights;
mod stream;
mod timeline;
mod visitor;
