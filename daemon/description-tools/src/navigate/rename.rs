//! Renames a symbol wherever it is used.

use genom_description::model::Span;
use genom_text::is_name;

use super::Navigator;
use super::symbol::{Symbol, SymbolKind};

/// Why a symbol cannot be renamed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RenameError {
    /// There is no name at that position.
    #[error("nothing here has a name that can be changed")]
    Nothing,
    /// The symbol is declared by genomd itself.
    #[error("`{name}` is part of every component and keeps its name")]
    Standard {
        /// Name of the symbol.
        name: String,
    },
    /// The new name is reserved, or not an identifier.
    #[error("`{name}` cannot be a name: letters, digits and `_`, and no word of the language")]
    Name {
        /// The requested name.
        name: String,
    },
    /// A macro makes one of the uses.
    #[error("macro `{name}` makes one of the places; change it there")]
    Macro {
        /// The macro.
        name: String,
    },
}

impl Navigator {
    /// The name at a byte offset of a file, if it can be changed.
    ///
    /// # Errors
    /// There is no name, or it cannot be changed.
    pub fn renamed_at(&self, file: u32, offset: u32) -> Result<Span, RenameError> {
        let (span, symbol) = self.symbol_at(file, offset).ok_or(RenameError::Nothing)?;
        self.is_ours(symbol)?;
        self.is_written(span, symbol)?;
        Ok(span)
    }

    /// All positions at which the new name has to be written.
    ///
    /// # Errors
    /// The name cannot be changed, or not to `to`.
    pub fn rename(&self, file: u32, offset: u32, to: &str) -> Result<Vec<Span>, RenameError> {
        let (_, symbol) = self.symbol_at(file, offset).ok_or(RenameError::Nothing)?;
        self.is_ours(symbol)?;
        if !is_name(to) {
            return Err(RenameError::Name { name: to.to_owned() });
        }
        let places = self.references(file, offset);
        places.iter().try_for_each(|span| self.is_written(*span, symbol))?;
        Ok(places)
    }

    fn is_ours(&self, symbol: &Symbol) -> Result<(), RenameError> {
        let file = self.analysis.sources.file(symbol.span.file);
        if symbol.kind == SymbolKind::Ids || symbol.kind == SymbolKind::Root {
            return Err(RenameError::Nothing);
        }
        let reserved = matches!(symbol.kind, SymbolKind::State)
            && matches!(&*symbol.name, "start" | "stop" | "ether");
        if reserved || file.is_none_or(|file| file.is_synthetic()) {
            return Err(RenameError::Standard { name: symbol.name.to_string() });
        }
        Ok(())
    }

    /// Checks that the name is in the text at that position, not made by a macro.
    fn is_written(&self, span: Span, symbol: &Symbol) -> Result<(), RenameError> {
        let sources = &self.analysis.sources;
        match sources.expansion(span) {
            Some(macro_) => Err(RenameError::Macro { name: macro_.name.clone() }),
            None if sources.text(span) == &*symbol.name => Ok(()),
            None => Err(RenameError::Nothing),
        }
    }
}
