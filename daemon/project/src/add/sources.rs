//! The sources of a component's codels, and what an addition to its description adds to them.

use std::collections::HashSet;
use std::path::Path;

use genom_description::Analysis;
use genom_description::model::{Codel, Component};

use super::error::AddError;
use super::files::{Extended, read};
use super::rust;
use crate::c_source::functions;
use crate::skeleton::{Language, Sheet, Source, is_standard, merge, sheets};

/// Adds the functions that the component has now and did not have `before`. `directory` is that of
/// the description.
pub(super) fn extend(
    directory: &Path,
    before: &Component,
    after: &Analysis,
) -> Result<Extended, AddError> {
    let Some(component) = after.specification.components.first() else {
        return Ok(Extended::default());
    };
    let known: HashSet<&str> = before.codels.iter().map(|codel| codel.name.as_str()).collect();
    let new =
        |codel: &&Codel| !is_standard(component, codel) && !known.contains(codel.name.as_str());
    let new: Vec<&Codel> = component.codels.iter().filter(new).collect();
    if new.is_empty() {
        return Ok(Extended::default());
    }
    if directory.join("Cargo.toml").is_file() {
        return rust::extend(directory, &after.specification, component, &new);
    }
    let folder = if directory.join("codels").is_dir() { "codels" } else { "" };
    let sources = read(directory, Path::new(folder), &["c", "cc", "cpp", "cxx"])?;
    let names: HashSet<&str> = new.iter().map(|codel| codel.name.as_str()).collect();
    let sheets = placed(&sources, component, after, &names);
    let merged = merge(&sheets, &sources);
    let mut extended = Extended::default();
    for source in merged.changed {
        let known = sources.iter().any(|old| old.path == source.path);
        if !known && directory.join("CMakeLists.txt").is_file() {
            let path = source.path.display();
            extended.advice.push(format!("name {path} among the SOURCES in CMakeLists.txt"));
        }
        extended.files.push((directory.join(source.path), source.text));
    }
    let added = merged.added.into_iter();
    extended.functions = added.map(|(name, path)| (name, directory.join(path))).collect();
    extended.advice.extend(merged.conflicts.iter().map(|conflict| {
        format!(
            "{}:{}: {} is there already, and the description asks for\n    {}",
            directory.join(&conflict.path).display(),
            conflict.line,
            conflict.name,
            conflict.wanted
        )
    }));
    Ok(extended)
}

/// The new functions, each in the source of its task if that is there, else in the one that defines
/// most codels: so build files that list sources need no change.
fn placed(
    sources: &[Source],
    component: &Component,
    after: &Analysis,
    new: &HashSet<&str>,
) -> Vec<Sheet> {
    let own: HashSet<&str> = component.codels.iter().map(|codel| codel.name.as_str()).collect();
    let count = |source: &&Source| {
        let defined = functions(&source.text);
        defined.iter().filter(|function| own.contains(function.name.as_str())).count()
    };
    // Of several, the first.
    let main = sources.iter().rev().max_by_key(count);
    let language = match main {
        Some(source) if source.path.extension().is_some_and(|it| it != "c") => Language::Cxx,
        Some(_) => Language::C,
        None => Language::of(component),
    };
    let mut list: Vec<Sheet> = Vec::new();
    for mut sheet in sheets(&after.specification, component, language, false) {
        sheet.functions.retain(|function| new.contains(function.name.as_str()));
        let there = sources.iter().any(|source| source.path == sheet.path);
        if let Some(main) = main.filter(|_| !there) {
            sheet.path.clone_from(&main.path);
        }
        match list.iter_mut().find(|other| other.path == sheet.path) {
            Some(other) => other.functions.append(&mut sheet.functions),
            None => list.push(sheet),
        }
    }
    list
}
