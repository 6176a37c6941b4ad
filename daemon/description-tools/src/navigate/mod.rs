//! For editors: declarations and uses of names, their meaning, and completion.
//!
//! It works on texts with errors, and does not report them: `check` does.

mod body;
mod complete;
mod context;
mod extent;
mod hover;
mod outline;
mod paint;
mod rename;
mod symbol;
mod walk;

pub use complete::{Completion, CompletionKind};
pub use outline::Outline;
pub use paint::Paint;
pub use rename::RenameError;
pub use symbol::{Symbol, SymbolKind};

use std::path::{Path, PathBuf};

use genom_description::model::Span;
use genom_description::source::Files;
use genom_description::token::Token;
use genom_description::{Analysis, Options, parse_files};
use genom_types::ScopedName;

use self::extent::Extents;
use self::symbol::{Space, Table};
use self::walk::Walker;

/// A specification that answers questions about positions in its text.
#[derive(Debug)]
pub struct Navigator {
    /// Model, diagnostics and sources of the specification.
    pub analysis: Analysis,
    table: Table,
    tokens: Vec<Token>,
}

impl Navigator {
    /// Reads input files, in order, as one specification.
    #[must_use]
    pub fn read(inputs: &[PathBuf], options: &Options, files: &dyn Files) -> Self {
        let (tokens, parsed) = parse_files(inputs, options, files);
        let mut walker =
            Walker { table: Table::new(), extents: Extents::new(&tokens), pending: Vec::new() };
        if let Some(standard) = &parsed.standard {
            walker.tree(standard);
        }
        walker.tree(&parsed.tree);
        let table = walker.resolve();
        Self { analysis: parsed.check(), table, tokens }
    }

    /// Index of a file by the path it was reached by; of several inclusions, the first.
    #[must_use]
    pub fn file(&self, path: &Path) -> Option<u32> {
        let mut files = self.analysis.sources.files();
        files.find(|(_, file)| file.path() == path).map(|(rank, _)| rank)
    }

    /// The name at a byte offset of a file (or ending there), and its symbol.
    #[must_use]
    pub fn symbol_at(&self, file: u32, offset: u32) -> Option<(Span, &Symbol)> {
        let (span, id) = self.use_at(file, offset)?;
        Some((span, self.table.get(id)?))
    }

    fn use_at(&self, file: u32, offset: u32) -> Option<(Span, usize)> {
        let uses = &self.table.uses;
        let after = uses.partition_point(|(span, _)| (span.file, span.start) <= (file, offset));
        let before = uses.get(..after)?.iter().rev();
        // All names made by a macro have one position: the first is taken.
        before
            .take_while(|(span, _)| span.file == file)
            .take(8)
            .copied()
            .find(|(span, _)| span.end >= offset)
    }

    /// Position of the declaration of a type, or of a member of one, by full name.
    #[must_use]
    pub fn declared(&self, name: &ScopedName, member: Option<&str>) -> Option<Span> {
        let mut at = 0;
        for segment in name.segments() {
            at = self.table.local(at, Space::Scope, segment)?;
        }
        if let Some(member) = member {
            at = self.table.local(at, Space::Member, member)?;
        }
        self.table.get(at).map(|symbol| symbol.span)
    }

    /// Position of the declaration of the name at a byte offset, or the file included there.
    #[must_use]
    pub fn definition(&self, file: u32, offset: u32) -> Option<Span> {
        let sources = &self.analysis.sources;
        let included = sources.files().find(|(_, inner)| {
            let from = inner.included_from();
            from.is_some_and(|at| at.file == file && at.start <= offset && offset <= at.end)
        });
        if let Some((file, _)) = included {
            return Some(Span { file, start: 0, end: 0 });
        }
        let (_, symbol) = self.symbol_at(file, offset)?;
        let real = !sources.file(symbol.span.file)?.is_synthetic();
        real.then_some(symbol.span)
    }

    /// Every position that refers to the symbol at a byte offset, its declaration included. A codel
    /// is one function wherever it is used.
    #[must_use]
    pub fn references(&self, file: u32, offset: u32) -> Vec<Span> {
        let Some((_, wanted)) = self.use_at(file, offset) else { return Vec::new() };
        let symbol = |id: usize| self.table.get(id).filter(|one| one.kind == SymbolKind::Codel);
        let codel = symbol(wanted).map(|one| &one.name);
        let uses = self.table.uses.iter().filter(|(_, id)| {
            *id == wanted || codel.is_some() && symbol(*id).map(|one| &one.name) == codel
        });
        let mut places: Vec<Span> = uses.map(|(span, _)| *span).collect();
        places.dedup();
        places
    }
}
