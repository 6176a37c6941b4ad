//! The book (docs/book): its sessions are run, its examples built and used, its reference is what
//! the programs say of themselves.

mod blocks;
mod console;
mod generated;
mod links;
mod peers;
mod place;
mod sessions;

use std::path::PathBuf;

use genom_tests::{files, repository};

/// Where the chapters are.
fn source() -> PathBuf {
    repository().join("docs/book/src")
}

/// All chapters.
fn chapters() -> Vec<PathBuf> {
    files("md").into_iter().filter(|file| file.starts_with(source())).collect()
}
