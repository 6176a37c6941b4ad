//! The entry points: from files to model and diagnostics.

use std::fmt::Write as _;
use std::hash::{DefaultHasher, Hasher as _};
use std::path::{Path, PathBuf};

use crate::absent::leave_out;
use crate::check::check;
use crate::diagnostic::Diagnostics;
use crate::model::{Dialect, Span, Specification};
use crate::parse::parse;
use crate::preprocess::{self, tokenize, tokenize_text};
use crate::source::{Disk, Files, Memory, SourceMap};
use crate::syntax::{Statement, Tree};
use crate::token::Token;

/// The interface `genom`, which every component provides (genom3.md 4.8).
const STANDARD: &str = include_str!("genom.gen");

/// How to read a description.
#[derive(Clone, Debug)]
pub struct Options {
    /// Include directories and definitions.
    pub preprocess: preprocess::Options,
    /// Whether components provide interface `genom`. Without it, model and digests are those of
    /// GenoM3's own tool.
    pub standard_interface: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { preprocess: preprocess::Options::default(), standard_interface: true }
    }
}

/// The result of reading a description.
#[derive(Debug)]
pub struct Analysis {
    /// The model; complete and consistent if there are no errors, else as far as it was understood.
    pub specification: Specification,
    /// Errors and warnings: those of the preprocessor, then the others by position.
    pub diagnostics: Diagnostics,
    /// The files read, to convert spans to lines and columns.
    pub sources: SourceMap,
}

impl Analysis {
    /// Whether the description has errors, and so cannot be run.
    #[must_use]
    pub fn has_errors(&self) -> bool {
        self.diagnostics.errors() > 0
    }

    /// Name of each component, with the generation of the language that it is written in.
    pub fn dialects(&self) -> impl Iterator<Item = (&str, Dialect)> {
        self.specification.components.iter().map(|c| (c.name.as_str(), c.dialect))
    }
}

/// Reads input files from the disk, in order, as one specification.
#[must_use]
pub fn read<P: AsRef<Path>>(inputs: &[P], options: &Options) -> Analysis {
    let inputs: Vec<PathBuf> = inputs.iter().map(|path| path.as_ref().to_owned()).collect();
    read_files(&inputs, options, &Disk)
}

/// Reads one text held in memory; files that it includes are read from the disk.
#[must_use]
pub fn read_text(name: &str, text: &str, options: &Options) -> Analysis {
    let mut files = Memory::over_disk();
    files.insert(name, text);
    read_files(&[PathBuf::from(name)], options, &files)
}

/// Reads input files from `files`, in order, as one specification.
#[must_use]
pub fn read_files(inputs: &[PathBuf], options: &Options, files: &dyn Files) -> Analysis {
    let (tokens, parsed) = parse_files(inputs, options, files);
    drop(tokens);
    parsed.check()
}

/// The result of parsing; no name is resolved yet.
#[derive(Debug)]
pub struct Parsed {
    /// The statements of the input files.
    pub tree: Tree,
    /// Tree of interface `genom`, unless the files declare it themselves.
    pub standard: Option<Tree>,
    sources: SourceMap,
    fingerprint: u64,
    preprocess: Diagnostics,
    syntax: Diagnostics,
}

/// Reads input files up to the tree. The tokens are returned apart, so that they can be dropped
/// early: they take much memory.
#[must_use]
pub fn parse_files(
    inputs: &[PathBuf],
    options: &Options,
    files: &dyn Files,
) -> (Vec<Token>, Parsed) {
    let mut sources = SourceMap::new();
    let (tokens, preprocess) = tokenize(inputs, &options.preprocess, files, &mut sources);
    let fingerprint = fingerprint(&tokens);
    let (tree, syntax) = parse(&tokens);
    // The input files may declare the interface themselves, as GenoM3's templates do.
    let standard = options.standard_interface && !declares_genom(&tree);
    let standard = standard.then(|| {
        let (tokens, _) = tokenize_text("<genom>", STANDARD, &mut sources);
        sources.mark_synthetic("<genom>");
        parse(&tokens).0
    });
    (tokens, Parsed { tree, standard, sources, fingerprint, preprocess, syntax })
}

impl Parsed {
    /// Resolves all names and checks all rules.
    #[must_use]
    pub fn check(self) -> Analysis {
        let Parsed { tree, standard, sources, fingerprint, preprocess: mut diagnostics, syntax } =
            self;
        let root_of = |file: u32| {
            let span = Span { file, ..Span::default() };
            sources.include_chain(span).last().map_or(file, |outermost| outermost.file)
        };
        // Of a text that was not read to its end, only the reason is reported.
        let stopped = diagnostics.stopped;
        let tree = if stopped { Tree { statements: Vec::new(), lost: tree.lost } } else { tree };
        let (mut specification, mut semantics) = check(tree, standard, &root_of);
        specification.fingerprint = fingerprint;
        let mut rest = syntax;
        if rest.errors() > 0 {
            // Parts that failed to parse may use what seems unused.
            semantics.retain(|said| !said.code.starts_with("W09"));
        }
        rest.append(semantics);
        if stopped {
            rest = Diagnostics::default();
        }
        leave_out(&mut diagnostics, &mut rest);
        rest.sort_by_place();
        diagnostics.append(rest);
        Analysis { specification, diagnostics, sources }
    }
}

/// A hash of what the tokens are, without their places.
fn fingerprint(tokens: &[Token]) -> u64 {
    struct Hashed(DefaultHasher);
    impl std::fmt::Write for Hashed {
        fn write_str(&mut self, text: &str) -> std::fmt::Result {
            self.0.write(text.as_bytes());
            Ok(())
        }
    }
    let mut hashed = Hashed(DefaultHasher::new());
    for token in tokens {
        // Writing into a hash cannot fail.
        let _ = write!(hashed, "{:?} ", token.kind);
    }
    hashed.0.finish()
}

fn declares_genom(tree: &Tree) -> bool {
    tree.statements.iter().any(
        |statement| matches!(statement, Statement::Interface(body) if &*body.name.text == "genom"),
    )
}
