//! Why a library could not be opened.

use std::path::PathBuf;

/// Opening a library of codels failed. Nothing of it stays loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// There is no such file.
    #[error("{}: no such file: build the component, or give the path of its library", path.display())]
    NotFound {
        /// The file asked for.
        path: PathBuf,
    },
    /// The file is there but cannot be read.
    #[error("{}: cannot be read: {why}", path.display())]
    Unreadable {
        /// The file asked for.
        path: PathBuf,
        /// The system's words.
        why: std::io::Error,
    },
    /// The file is no ELF file at all.
    #[error("{}: no library: it {looks}, a shared object (ELF) is needed", path.display())]
    NotElf {
        /// The file asked for.
        path: PathBuf,
        /// What it looks like instead.
        looks: &'static str,
    },
    /// The file was built for another machine.
    #[error(
        "{}: built for {theirs}, this machine is {ours}: rebuild it here or cross-compile it \
         for {ours}",
        path.display()
    )]
    Architecture {
        /// The file asked for.
        path: PathBuf,
        /// Machine the file was built for.
        theirs: String,
        /// Machine this daemon runs on.
        ours: String,
    },
    /// An ELF file of another kind.
    #[error("{}: {kind}, not a shared object: link it with -shared", path.display())]
    NotShared {
        /// The file asked for.
        path: PathBuf,
        /// What it is.
        kind: &'static str,
    },
    /// The file ends before its contents do: loading it would crash.
    #[error(
        "{}: truncated: {bytes} bytes, {wanted} needed (a build or a copy is not finished?)",
        path.display()
    )]
    Truncated {
        /// The file asked for.
        path: PathBuf,
        /// Bytes that the file has.
        bytes: u64,
        /// The size its headers announce.
        wanted: u64,
    },
    /// The ELF headers make no sense.
    #[error("{}: damaged: {why}", path.display())]
    Damaged {
        /// The file asked for.
        path: PathBuf,
        /// What is wrong.
        why: String,
    },
    /// It calls a function that neither it nor its dependencies define.
    #[error(
        "{}: undefined symbol `{symbol}`: link the library that defines it (codels-require)",
        path.display()
    )]
    UndefinedSymbol {
        /// The file asked for.
        path: PathBuf,
        /// Symbol that nothing defines.
        symbol: String,
    },
    /// A library it needs is not found.
    #[error(
        "{}: needs `{dependency}`, which is not found: install it, or link with an rpath",
        path.display()
    )]
    MissingDependency {
        /// The file asked for.
        path: PathBuf,
        /// Name of the missing library.
        dependency: String,
    },
    /// The dynamic linker refused for another reason.
    #[error("{}: the dynamic linker refuses it: {why}", path.display())]
    Refused {
        /// The file asked for.
        path: PathBuf,
        /// The linker's words.
        why: String,
    },
    /// The embedded description is no text.
    #[error("{}: symbol `genom_description` holds no UTF-8 text", path.display())]
    Description {
        /// The file asked for.
        path: PathBuf,
    },
}

/// The dynamic linker did not open a file.
#[derive(Debug, thiserror::Error)]
#[error("{said}")]
pub(super) struct LinkError {
    /// Its message, without the name of the file.
    pub(super) said: String,
}

impl OpenError {
    /// Reads what the dynamic linker says of the copy of `path`.
    pub(super) fn from_linker(path: PathBuf, error: &LinkError) -> Self {
        let said = error.said.as_str();
        if let Some((_, symbol)) = said.split_once("undefined symbol: ") {
            let symbol = symbol.split([',', ' ']).next().unwrap_or(symbol).to_owned();
            return Self::UndefinedSymbol { path, symbol };
        }
        if let Some((dependency, _)) = said.split_once(": cannot open shared object file") {
            return Self::MissingDependency { path, dependency: dependency.to_owned() };
        }
        Self::Refused { path, why: said.to_owned() }
    }
}
