//! The web console: who may come in, what its pages show, and what they do.

mod access;
mod accessible;
mod crowd;
mod deployment;
mod doctor;
mod fleet;
mod foreign;
mod graph;
mod pages;
mod pictures;
mod plots;
mod recordings;
mod sessions;
mod sights;
mod stream;
mod timeline;
mod visitor;
