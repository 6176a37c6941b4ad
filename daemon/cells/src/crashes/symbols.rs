//! Symbols of one file: names of functions, and its build id.

use std::fs::File;

use object::read::ReadCache;
use object::{Object as _, ObjectSegment as _, ObjectSymbol as _, SymbolKind};
use serde::{Deserialize, Serialize};

use super::names::plain;

/// What is in a file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub(super) struct Contents {
    pub(super) build_id: Option<String>,
    /// For each offset its address in the file, and the function with the offset in it; nothing at
    /// all of a file that cannot be read.
    pub(super) functions: Vec<(u64, Option<String>)>,
}

/// What is in a file.
pub(super) fn read(file: &File, offsets: &[u64]) -> Contents {
    let functions = functions(file, offsets).unwrap_or_default();
    Contents { build_id: build_id(file), functions }
}

fn build_id(file: &File) -> Option<String> {
    let cache = ReadCache::new(file);
    let file = object::File::parse(&cache).ok()?;
    let id = file.build_id().ok()??;
    Some(id.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// For each offset in a file, its address there, and the function with the offset in it.
fn functions(file: &File, offsets: &[u64]) -> Option<Vec<(u64, Option<String>)>> {
    let cache = ReadCache::new(file);
    let file = object::File::parse(&cache).ok()?;
    let address_of = |offset: u64| {
        let within = file.segments().find(|segment| {
            let (start, size) = segment.file_range();
            offset >= start && offset - start < size
        });
        within.map_or(offset, |segment| {
            segment.address().wrapping_add(offset - segment.file_range().0)
        })
    };
    let addresses: Vec<u64> = offsets.iter().map(|offset| address_of(*offset)).collect();
    let mut best: Vec<Option<(u64, String)>> = vec![None; addresses.len()];
    let (low, high) = (*addresses.iter().min()?, *addresses.iter().max()?);
    for symbol in file.symbols().chain(file.dynamic_symbols()) {
        // Most are far from all of them, and there may be a million.
        let start = symbol.address();
        if start > high {
            continue;
        }
        let size = symbol.size();
        if size == 0 || start.saturating_add(size) <= low || symbol.kind() != SymbolKind::Text {
            continue;
        }
        for (address, best) in addresses.iter().zip(&mut best) {
            let nearer = best.as_ref().is_none_or(|(before, _)| *before < start);
            if *address >= start && *address - start < size && nearer {
                let Ok(name) = symbol.name() else { continue };
                *best = Some((start, plain(name)));
            }
        }
    }
    let told = addresses.into_iter().zip(best).map(|(address, best)| {
        (address, best.map(|(start, name)| format!("{name}+{:#x}", address - start)))
    });
    Some(told.collect())
}
