//! Why a library could not be opened.

use std::path::PathBuf;

/// Why a library of codels could not be opened. Nothing of it stays loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// The file does not exist.
    #[error("{}: no such file: build the component, or give the path of its library", path.display())]
    NotFound {
        /// The requested file.
        path: PathBuf,
    },
    /// The file exists but cannot be read.
    #[error("{}: cannot be read: {why}", path.display())]
    Unreadable {
        /// The requested file.
        path: PathBuf,
        /// The error of the system.
        why: std::io::Error,
    },
    /// The file is not an ELF file.
    #[error("{}: no library: it {looks}, a shared object (ELF) is needed", path.display())]
    NotElf {
        /// The requested file.
        path: PathBuf,
        /// What kind of file it seems to be.
        looks: &'static str,
    },
    /// The file was built for another machine.
    #[error(
        "{}: built for {theirs}, this machine is {ours}: rebuild it here or cross-compile it \
         for {ours}",
        path.display()
    )]
    Architecture {
        /// The requested file.
        path: PathBuf,
        /// Machine the file was built for.
        theirs: String,
        /// Machine this daemon runs on.
        ours: String,
    },
    /// An ELF file of another kind than a shared object.
    #[error("{}: {kind}, not a shared object: link it with -shared", path.display())]
    NotShared {
        /// The requested file.
        path: PathBuf,
        /// Its kind.
        kind: &'static str,
    },
    /// The file is shorter than its headers say: loading it would crash.
    #[error(
        "{}: truncated: {bytes} bytes, {wanted} needed (a build or a copy is not finished?)",
        path.display()
    )]
    Truncated {
        /// The requested file.
        path: PathBuf,
        /// Size of the file in bytes.
        bytes: u64,
        /// Size according to its headers.
        wanted: u64,
    },
    /// The ELF headers are inconsistent.
    #[error("{}: damaged: {why}", path.display())]
    Damaged {
        /// The requested file.
        path: PathBuf,
        /// The error.
        why: String,
    },
    /// It uses a function that neither it nor its dependencies define.
    #[error(
        "{}: undefined symbol `{symbol}`: link the library that defines it (codels-require)",
        path.display()
    )]
    UndefinedSymbol {
        /// The requested file.
        path: PathBuf,
        /// The undefined symbol.
        symbol: String,
    },
    /// A library that it depends on is not found.
    #[error(
        "{}: needs `{dependency}`, which is not found: install it, or link with an rpath",
        path.display()
    )]
    MissingDependency {
        /// The requested file.
        path: PathBuf,
        /// Name of the missing library.
        dependency: String,
    },
    /// The dynamic linker refused it for another reason.
    #[error("{}: the dynamic linker refuses it: {why}", path.display())]
    Refused {
        /// The requested file.
        path: PathBuf,
        /// The linker's message.
        why: String,
    },
    /// The embedded description is not text.
    #[error("{}: symbol `genom_description` holds no UTF-8 text", path.display())]
    Description {
        /// The requested file.
        path: PathBuf,
    },
}
