//! Shared libraries of codels: opens private copies and finds symbols.
//!
//! It knows nothing about components: the caller decides which symbols to look up.

mod ask;
mod copy;
mod linker;
mod outlive;
mod threads;
mod timers;

pub use genom_elf::{Contents, Digest, EmbeddedDescription, OpenError, is_script};

use std::path::{Path, PathBuf};

use copy::PrivateCopy;
use genom_elf as elf;
use genom_interpreter::Given;
use linker::{Handle, LinkError, Mapping};

/// Libraries of the system, by prefix of their file names: they contain no codels.
const SYSTEM: &[&str] = &[
    "libc.",
    "libc-",
    "libm.",
    "libm-",
    "libpthread",
    "libdl",
    "librt",
    "libstdc++",
    "libgcc_s",
    "ld-",
];

/// Opens a file, or returns the dynamic linker's error.
type Linker = fn(&Path, &Path) -> Result<Handle, LinkError>;

/// Where a function of a library is defined.
pub(crate) enum FoundFunction {
    /// At this address.
    At(usize),
    /// In this library of the system, as another function with the same name.
    InSystem(String),
    Nowhere,
}

/// Where the code of a library is.
#[derive(Debug)]
enum Code {
    /// Mapped by the dynamic linker.
    Linked(Handle),
    /// Made by an interpreter in this process.
    Given(Given),
}

/// An open library; closed when dropped, when no thread may be running its code.
#[derive(Debug)]
pub struct Library {
    // Declared first: the library is unmapped before its copy is removed.
    code: Code,
    copy: Option<PrivateCopy>,
    path: PathBuf,
    bytes: Vec<u8>,
    /// Its own segments, without those of libraries that it needs.
    mappings: Vec<Mapping>,
    /// Functions to run when it is closed.
    finishers: Option<elf::Finishers>,
}

impl Library {
    /// Loads a private copy of the library at `path`, with all its symbols bound and invisible to
    /// others.
    ///
    /// Constructors of the library run. A library that finds others relative to its own directory
    /// (`$ORIGIN`) is copied beside the original; if that directory is read-only, the original is
    /// loaded.
    ///
    /// # Errors
    /// The file is missing, not a shared object for this machine, truncated, or cannot be linked.
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        Self::of(Contents::read(path)?)
    }

    /// Loads a private copy of these contents: see [`open`](Self::open).
    ///
    /// # Errors
    /// The library cannot be linked.
    pub fn of(contents: Contents) -> Result<Self, OpenError> {
        Self::open_by(contents, Handle::open)
    }

    /// Loads a private copy of these contents with this linker.
    fn open_by(contents: Contents, link: Linker) -> Result<Self, OpenError> {
        if elf::uses_origin(&contents.bytes) {
            return Self::open_beside(contents, link);
        }
        let copy = match PrivateCopy::new(&contents.path, &contents.bytes) {
            Ok(copy) => copy,
            Err(why) => {
                let path = contents.path.display();
                tracing::warn!("{path}: no copy in the temporary directory: {why}");
                return Self::open_beside(contents, link);
            }
        };
        match link(copy.path(), &contents.path) {
            Ok(handle) => Ok(Self::new(contents, handle, Some(copy))),
            // The temporary directory is mounted `noexec`.
            Err(error) if error.said.contains("failed to map segment") => {
                Self::open_beside(contents, link)
            }
            Err(error) => Err(error.of(contents.path)),
        }
    }

    /// Loads a copy made beside the original, or else the original itself.
    fn open_beside(contents: Contents, link: Linker) -> Result<Self, OpenError> {
        let Contents { path, bytes } = &contents;
        let load = |file: &Path| link(file, path);
        let loaded = copy::beside(path, bytes, load).unwrap_or_else(|why| {
            tracing::warn!(
                "{}: loaded in place, no copy beside it: {why}; once rebuilt it needs a restart \
                 of the daemon",
                path.display()
            );
            load(&path.canonicalize().unwrap_or_else(|_| path.clone()))
        });
        match loaded {
            Ok(handle) => Ok(Self::new(contents, handle, None)),
            Err(error) => Err(error.of(contents.path)),
        }
    }

    fn new(contents: Contents, handle: Handle, copy: Option<PrivateCopy>) -> Self {
        let Contents { path, bytes } = contents;
        let mappings = handle.place(&elf::segments(&bytes));
        let finishers = elf::finishers(&bytes);
        Self { code: Code::Linked(handle), copy, path, bytes, mappings, finishers }
    }

    /// A script that an interpreter has loaded. Its text is kept as what was loaded.
    #[must_use]
    pub fn of_script(contents: Contents, given: Given) -> Self {
        let Contents { path, bytes } = contents;
        let (mappings, finishers) = (Vec::new(), None);
        Self { code: Code::Given(given), copy: None, path, bytes, mappings, finishers }
    }

    /// Whether it is a script.
    pub(crate) fn is_script(&self) -> bool {
        matches!(self.code, Code::Given(_))
    }

    /// What was loaded, whatever the file holds by now; `None` if the copy is gone.
    pub(crate) fn contents(&self) -> Option<Contents> {
        let bytes = match (&self.code, &self.copy) {
            (Code::Given(_), _) => self.bytes.clone(),
            (Code::Linked(_), copy) => std::fs::read(copy.as_ref()?.path()).ok()?,
        };
        Some(Contents { path: self.path.clone(), bytes })
    }

    /// The requested path, not that of the copy.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The embedded description.
    ///
    /// # Errors
    /// The symbol exists but is not text.
    pub fn description(&self) -> Result<Option<EmbeddedDescription>, OpenError> {
        elf::description_of(&self.path, &self.bytes)
    }

    /// Frees the memory with the content of the file, which is not needed any more; the text of a
    /// script has no other copy.
    pub(crate) fn forget_contents(&mut self) {
        if !self.is_script() {
            self.bytes = Vec::new();
        }
    }

    /// Contents of the file, as loaded.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Address of exported symbol `name` of this library or of what it is linked with.
    pub(crate) fn symbol(&self, name: &str) -> Option<usize> {
        let Code::Linked(handle) = &self.code else { return None };
        handle.symbol(name)
    }

    /// Address of symbol `name` if this library itself exports it.
    pub(crate) fn own_symbol(&self, name: &str) -> Option<usize> {
        self.symbol(name).filter(|at| self.mappings.iter().any(|own| own.range.contains(at)))
    }

    /// Finds C function `name` in this library, or in one that it is linked with, except the system's.
    pub(crate) fn function(&self, name: &str) -> FoundFunction {
        if let Code::Given(given) = &self.code {
            return given.function(name).map_or(FoundFunction::Nowhere, FoundFunction::At);
        }
        let Some(at) = self.symbol(name) else { return FoundFunction::Nowhere };
        if self.own_symbol(name).is_some() {
            return FoundFunction::At(at);
        }
        let file = linker::file_of(at);
        let base = file.rsplit('/').next().unwrap_or_default();
        match SYSTEM.iter().any(|system| base.starts_with(system)) {
            true => FoundFunction::InSystem(base.to_owned()),
            false => FoundFunction::At(at),
        }
    }

    /// Whether it is linked with a library whose name begins with `name`.
    pub(crate) fn needs(&self, name: &str) -> bool {
        elf::needs(&self.bytes, name)
    }

    /// Mangled symbols of the C++ functions with that name that it exports.
    pub(crate) fn mangled(&self, function: &str) -> Vec<String> {
        elf::mangled(&self.bytes, function)
    }

    /// Whether the byte at `address` lies in this library's memory.
    pub(crate) fn contains(&self, address: usize) -> bool {
        self.mappings.iter().any(|own| own.range.contains(&address))
    }

    /// Whether the byte at `address` lies in this library's memory and is read-only.
    pub(crate) fn is_constant(&self, address: usize) -> bool {
        self.mappings.iter().any(|own| !own.writable && own.range.contains(&address))
            || matches!(&self.code, Code::Given(given) if given.has_event(address))
    }
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    fn no_segment() -> LinkError {
        LinkError { said: "failed to map segment from shared object".to_owned() }
    }

    /// Simulates a temporary directory mounted `noexec`, with the message of glibc's linker.
    fn nothing_runs_in_temporary(file: &Path, library: &Path) -> Result<Handle, LinkError> {
        if file
            .parent()
            .unwrap()
            .file_name()
            .unwrap()
            .to_string_lossy()
            .starts_with("genomd-library-")
        {
            return Err(no_segment());
        }
        Handle::open(file, library)
    }

    fn nothing_runs_anywhere(_: &Path, _: &Path) -> Result<Handle, LinkError> {
        Err(no_segment())
    }

    #[test]
    fn where_the_temporary_directory_runs_nothing_thecopy_is_made_beside_the_library() {
        let scratch = tempfile::tempdir().unwrap();
        let (source, path) = (scratch.path().join("f.c"), scratch.path().join("demo.so"));
        std::fs::write(&source, "int f(void) { return 1; }").unwrap();
        let mut compiler = Command::new("cc");
        compiler.args(["-shared", "-fPIC", "-o"]).arg(&path).arg(&source);
        assert!(compiler.status().unwrap().success());
        let open = |link| Library::open_by(Contents::read(&path).unwrap(), link);
        let library = open(nothing_runs_in_temporary).unwrap();
        let own = linker::file_of(library.own_symbol("f").unwrap());
        assert!(own.contains("/.demo.so.genomd-"), "{own:?}");
        // A second load uses a file of its own as well.
        let other = open(nothing_runs_in_temporary).unwrap();
        assert_ne!(library.own_symbol("f"), other.own_symbol("f"));
        let refused = open(nothing_runs_anywhere).unwrap_err().to_string();
        assert!(refused.contains("failed to map segment"), "{refused}");
    }

    /// Lines of `/proc/self/maps` for a file: addresses, whether writable, whether code.
    fn mapped(file: &str) -> Vec<(std::ops::Range<usize>, bool, bool)> {
        let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
        let of = maps.lines().filter(|line| line.ends_with(file));
        let parts = of.map(|line| {
            let (place, rest) = line.split_once(' ').unwrap();
            let (from, to) = place.split_once('-').unwrap();
            let address = |text| usize::from_str_radix(text, 16).unwrap();
            let (written, code) = (rest.starts_with("rw"), rest.starts_with("r-x"));
            (address(from)..address(to), written, code)
        });
        parts.collect()
    }

    #[test]
    fn the_parts_of_a_library_are_where_the_kernel_says() {
        const C: &str = "int written = 1; const int constant = 2; int f(void) { return 1; }";
        let scratch = tempfile::tempdir().unwrap();
        let (source, path) = (scratch.path().join("f.c"), scratch.path().join("parts.so"));
        std::fs::write(&source, C).unwrap();
        let mut compiler = Command::new("cc");
        compiler.args(["-shared", "-fPIC", "-o"]).arg(&path).arg(&source);
        assert!(compiler.status().unwrap().success());
        let library = Library::open(&path).unwrap();
        let mapped = mapped(&linker::file_of(library.own_symbol("f").unwrap()));
        assert!(!mapped.is_empty());
        for part in &library.mappings {
            let line = mapped.iter().find(|(place, ..)| place.contains(&part.range.start));
            let (_, written, code) = line.unwrap_or_else(|| panic!("{part:?} in {mapped:?}"));
            assert_eq!(part.executable, *code, "{part:?}");
            // Some writable data becomes read-only after relocation.
            assert!(part.writable || !written, "{part:?}");
        }
        assert!(library.is_constant(library.own_symbol("constant").unwrap()));
        assert!(!library.is_constant(library.own_symbol("written").unwrap()));
    }
}
