//! Codels in Rust, on the SDK: functions marked `#[genom::codel]`, listed in `genom::component!`.

use std::path::Path;

use genom_description::model::{Codel, CodelKind, Component, Direction, Specification};
use genom_types::{Kind, TypeId, TypeTable};

use super::error::AddError;
use super::files::{Extended, read};
use crate::skeleton::{Source, about, first_yield};

/// Adds a function for each codel to the source that has most of them, and lists it in
/// `genom::component!`.
pub(super) fn extend(
    directory: &Path,
    spec: &Specification,
    component: &Component,
    new: &[&Codel],
) -> Result<Extended, AddError> {
    let mut sources = read(directory, Path::new("src"), &["rs"])?;
    let list = sources.iter().position(|source| source.text.contains("component!"));
    let lacks = |path: &Path, why: &str| AddError::Sources {
        path: directory.join(path),
        why: why.to_owned(),
    };
    let list = list.ok_or_else(|| lacks(Path::new("src"), "no file has `genom::component!`"))?;
    let marks = |source: &Source| source.text.matches("#[genom::codel]").count();
    let most = (0..sources.len()).rev().max_by_key(|at| sources.get(*at).map_or(0, marks));
    let most = most.unwrap_or(list);
    let mut extended = Extended::default();
    let mut missing = Vec::new();
    let functions: Vec<String> =
        new.iter().map(|codel| function(spec, component, codel, &sources, &mut missing)).collect();
    let Some(target) = sources.get_mut(most) else { return Ok(extended) };
    let module = module(&target.path);
    for function in functions {
        if !target.text.ends_with('\n') {
            target.text.push('\n');
        }
        target.text.push('\n');
        target.text.push_str(&function);
    }
    let path = target.path.clone();
    if let Some(lib) = sources.get_mut(list) {
        let paths: Vec<String> =
            new.iter()
                .map(|codel| {
                    if list == most {
                        codel.name.clone()
                    } else {
                        format!("{module}{}", codel.name)
                    }
                })
                .collect();
        let listed = listed(&lib.text, &paths);
        lib.text = listed
            .ok_or_else(|| lacks(&lib.path, "`genom::component!` has no list `codels: [...]`"))?;
    }
    extended.functions =
        new.iter().map(|codel| (codel.name.clone(), directory.join(&path))).collect();
    for at in [most, list] {
        if let Some(source) = sources.get(at) {
            let file = (directory.join(&source.path), source.text.clone());
            if !extended.files.contains(&file) {
                extended.files.push(file);
            }
        }
    }
    missing.sort();
    missing.dedup();
    extended.advice.extend(missing);
    Ok(extended)
}

/// `codels::` for `src/codels.rs`.
fn module(path: &Path) -> String {
    match path.file_stem().and_then(|stem| stem.to_str()) {
        None | Some("lib") => "crate::".to_owned(),
        Some(stem) => format!("{stem}::"),
    }
}

/// The text of `genom::component!` with further codels at the end of their list.
fn listed(text: &str, paths: &[String]) -> Option<String> {
    let call = text.find("component!")?;
    let open = call + text.get(call..)?.find("codels:")?;
    let open = open + text.get(open..)?.find('[')? + 1;
    let close = open + text.get(open..)?.find(']')?;
    let inner = text.get(open..close)?;
    let kept = inner.trim_end();
    let comma = if kept.trim().is_empty() || kept.ends_with(',') { "" } else { "," };
    let last =
        kept.rsplit('\n').next().filter(|line| kept.contains('\n') && !line.trim().is_empty());
    let entries: String = match last {
        // A line each, as the others.
        Some(line) => {
            let indent = line.get(..line.len() - line.trim_start().len()).unwrap_or_default();
            paths.iter().map(|path| format!("\n{indent}{path},")).collect()
        }
        None => format!("{}{}", if kept.is_empty() { "" } else { " " }, paths.join(", ")),
    };
    let tail = inner.get(kept.len()..).unwrap_or_default();
    Some(format!("{}{kept}{comma}{entries}{tail}{}", text.get(..open)?, text.get(close..)?))
}

fn function(
    spec: &Specification,
    component: &Component,
    codel: &Codel,
    sources: &[Source],
    missing: &mut Vec<String>,
) -> String {
    let mut types = Types { table: &spec.types, sources, missing };
    let parameters: Vec<String> = codel
        .parameters
        .iter()
        .map(|one| format!("{}: {}", word(&one.name), types.passed(one.ty, one.direction)))
        .collect();
    let outputs = codel.parameters.iter().filter(|one| one.direction != Direction::In);
    let mut lines: Vec<String> = codel
        .parameters
        .iter()
        .filter(|one| one.direction == Direction::In)
        .map(|one| format!("    let _ = {};\n", word(&one.name)))
        .collect();
    lines.extend(outputs.map(|one| format!("    let _ = &{};\n", word(&one.name))));
    let (returned, value) = match &codel.kind {
        CodelKind::Fsm { .. } => {
            let event = first_yield(component, codel);
            (" -> genom::Event", format!("    genom::event!(\"::{}::{event}\")\n", component.name))
        }
        _ => ("", String::new()),
    };
    let comment = about(&spec.types, component, codel);
    let comment = comment.trim().trim_start_matches("/* ").trim_end_matches(" */");
    format!(
        "/// {comment}\n#[genom::codel]\npub(crate) fn {}({}){returned} {{\n    // your code\n{}{value}}}\n",
        codel.name,
        parameters.join(", "),
        lines.concat()
    )
}

/// A name that is a keyword of Rust is written `r#type`.
fn word(name: &str) -> String {
    const KEYWORDS: &[&str] = &[
        "as", "async", "await", "box", "dyn", "fn", "gen", "impl", "let", "loop", "match", "mod",
        "move", "mut", "priv", "pub", "ref", "trait", "type", "use", "where", "yield",
    ];
    if KEYWORDS.contains(&name) { format!("r#{name}") } else { name.to_owned() }
}

/// Types of the description as the sources of the project write them.
struct Types<'a> {
    table: &'a TypeTable,
    sources: &'a [Source],
    /// Types that the project does not have yet.
    missing: &'a mut Vec<String>,
}

impl Types<'_> {
    /// The type of a parameter, as the macro `codel` wants it.
    fn passed(&mut self, ty: TypeId, direction: Direction) -> String {
        let ty = self.table.resolve(ty);
        let own = self.stored(ty);
        match (direction, self.table.kind(ty)) {
            (Direction::In, Kind::Boolean) => "bool".to_owned(),
            (Direction::In, Kind::String { bound: None }) => "&std::ffi::CStr".to_owned(),
            (Direction::In, Kind::Enum { .. }) => own,
            (Direction::In, kind) if kind.rust_number().is_some() => own,
            (Direction::In, _) => format!("&{own}"),
            (Direction::Out | Direction::InOut, _) => format!("&mut {own}"),
        }
    }

    /// The type of a datum in memory.
    fn stored(&mut self, ty: TypeId) -> String {
        let ty = self.table.resolve(ty);
        if let Some(number) = self.table.kind(ty).rust_number() {
            return number.to_owned();
        }
        match self.table.kind(ty) {
            Kind::Boolean => "genom::Bool".to_owned(),
            Kind::String { bound: None } => "genom::Text".to_owned(),
            Kind::String { bound: Some(bound) } => format!("genom::BoundedString<{bound}>"),
            Kind::Array { element, length } => {
                let (element, length) = (*element, *length);
                format!("[{}; {length}]", self.stored(element))
            }
            Kind::Sequence { element, bound } => {
                let (element, bound) = (*element, *bound);
                let element = self.stored(element);
                match bound {
                    None => format!("genom::Sequence<{element}>"),
                    Some(bound) => format!("genom::BoundedSequence<{element}, {bound}>"),
                }
            }
            Kind::Optional { element } => {
                let element = *element;
                format!("genom::Optional<{}>", self.stored(element))
            }
            Kind::Enum { name, .. } => {
                let name = name.to_string();
                format!("genom::Enum<{}>", self.named(&name))
            }
            Kind::Native { name } => {
                let name = name.to_string();
                format!("genom::Native<{}>", self.named(&name))
            }
            kind => match kind.name().map(ToString::to_string) {
                Some(name) => self.named(&name),
                None => "()".to_owned(),
            },
        }
    }

    /// The path of the type that the project declares for this name of the description.
    fn named(&mut self, name: &str) -> String {
        let name = format!("::{}", name.trim_start_matches("::"));
        let mark = format!("name = \"{name}\"");
        for source in self.sources {
            let Some((_, after)) = source.text.split_once(&mark) else { continue };
            let words = after.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
            let mut words = words.skip_while(|word| !matches!(*word, "struct" | "enum"));
            if let Some(found) = words.nth(1) {
                let module = module(&source.path);
                let module = module.strip_prefix("crate::").unwrap_or(&module);
                return format!("crate::{module}{found}");
            }
        }
        let own = camel(name.rsplit("::").next().unwrap_or_default());
        let path = format!("crate::types::{own}");
        self.missing.push(format!("{path} is to be declared, with #[genom(name = \"{name}\")]"));
        path
    }
}

/// `out_of_range` as `OutOfRange`.
fn camel(name: &str) -> String {
    let parts = name.split('_').filter(|part| !part.is_empty());
    parts
        .map(|part| {
            let (first, rest) = part.split_at(part.chars().next().map_or(0, char::len_utf8));
            first.to_uppercase() + rest
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codels_are_listed_as_the_others_are() {
        let paths = ["codels::b".to_owned(), "codels::c".to_owned()];
        let text = "genom::component! {\n    codels: [\n        codels::a,\n    ],\n}\n";
        assert_eq!(
            listed(text, &paths).unwrap(),
            "genom::component! {\n    codels: [\n        codels::a,\n        codels::b,\n        codels::c,\n    ],\n}\n"
        );
        let one = "component! { codels: [a], exceptions: [] }";
        assert_eq!(
            listed(one, &paths).unwrap(),
            "component! { codels: [a, codels::b, codels::c], exceptions: [] }"
        );
        let none = "component! { codels: [] }";
        assert_eq!(listed(none, &paths).unwrap(), "component! { codels: [codels::b, codels::c] }");
        assert_eq!(listed("component! { exceptions: [] }", &paths), None);
    }

    #[test]
    fn names_are_written_as_in_rust() {
        assert_eq!(camel("out_of_range"), "OutOfRange");
        assert_eq!(camel("POSE"), "POSE");
        assert_eq!((word("type").as_str(), word("goal").as_str()), ("r#type", "goal"));
    }
}
