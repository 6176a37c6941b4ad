//! Mistakes in the declarations of codels, explained against the description: a compiler knows only
//! the header, and a linker only names.

use std::path::PathBuf;

use genom_description::Analysis;
use genom_description::model::Component;

use crate::skeleton::{Language, Source, merge, sheets};

/// What is wrong with the codels that `told` speaks of: each line names the source, if there is
/// one, the place in the description, and the declaration that it asks for.
pub(super) fn explain(
    told: &str,
    analysis: &Analysis,
    component: &Component,
    sources: &[PathBuf],
) -> Vec<String> {
    let sources: Vec<Source> = sources
        .iter()
        .filter_map(|path| {
            let bytes = std::fs::read(path).ok()?;
            let text = String::from_utf8_lossy(&bytes).into_owned();
            Some(Source { path: path.clone(), text })
        })
        .collect();
    let spec = &analysis.specification;
    let sheets = sheets(spec, component, Language::of(component), true);
    let compared = merge(&sheets, &sources);
    let spoken_of = |name: &str| told.split(|c: char| !is_word(c)).any(|word| word == name);
    let place = |name: &str| {
        let codel = component.codels.iter().find(|codel| codel.name == name);
        let place = codel.map(|codel| analysis.sources.location(codel.span));
        place.map_or_else(String::new, |at| format!("{}:{}", at.path.display(), at.line))
    };
    let mut list = Vec::new();
    for conflict in compared.conflicts.iter().filter(|conflict| spoken_of(&conflict.name)) {
        list.push(format!(
            "{}:{}: {} is not what {} asks for:\n    {}",
            conflict.path.display(),
            conflict.line,
            conflict.name,
            place(&conflict.name),
            conflict.wanted
        ));
    }
    let wanted = sheets.iter().flat_map(|sheet| &sheet.functions);
    for function in wanted.filter(|function| spoken_of(&function.name)) {
        if compared.added.iter().any(|(name, _)| *name == function.name) {
            list.push(format!(
                "{}: codel {} is in none of the sources; it is to be declared as\n    {}",
                place(&function.name),
                function.name,
                function.declaration
            ));
        }
    }
    list
}

fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}
