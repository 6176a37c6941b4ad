//! The declarations of a file, as a tree.

use std::collections::HashMap;

use super::Navigator;
use super::symbol::{Symbol, SymbolKind};

/// A declaration, and those inside it.
#[derive(Clone, Debug)]
pub struct Outline<'a> {
    /// The symbol that it declares.
    pub symbol: &'a Symbol,
    /// Declarations inside it, in order.
    pub children: Vec<Outline<'a>>,
}

impl Navigator {
    /// The declarations of a file, without parameters, locals and states.
    #[must_use]
    pub fn outline(&self, file: u32) -> Vec<Outline<'_>> {
        use SymbolKind as K;
        let shown = |symbol: &Symbol| {
            let small = matches!(symbol.kind, K::Parameter | K::Local | K::State | K::Root);
            symbol.span.file == file && !small
        };
        let mut inside: HashMap<usize, Vec<usize>> = HashMap::new();
        for (id, symbol) in self.table.all.iter().enumerate().filter(|(_, symbol)| shown(symbol)) {
            // The enclosing declaration may be in another file, as for a reopened component.
            let parent = self.table.get(symbol.parent).filter(|parent| shown(parent));
            inside.entry(parent.map_or(0, |_| symbol.parent)).or_default().push(id);
        }
        self.level(0, &inside)
    }

    fn level(&self, parent: usize, inside: &HashMap<usize, Vec<usize>>) -> Vec<Outline<'_>> {
        let ids = inside.get(&parent).map_or(&[][..], Vec::as_slice);
        ids.iter()
            .filter_map(|id| {
                let symbol = self.table.get(*id)?;
                Some(Outline { symbol, children: self.level(*id, inside) })
            })
            .collect()
    }
}
