//! The types that codels in Python import from `COMPONENT_types`, as a stub for editors and type
//! checkers (`.pyi`). It is not needed at run time.

use std::collections::HashSet;
use std::fmt::Write;

use genom_description::model::{Component, Specification};
use genom_types::{Kind, Member, ScopedName, TypeId, TypeTable};
use serde_json::Value;

use super::order;

/// Words that no name of Python is: such a name gets an underscore.
const KEYWORDS: &[&str] = &[
    "False", "None", "True", "and", "as", "assert", "async", "await", "break", "class", "continue",
    "def", "del", "elif", "else", "except", "finally", "for", "from", "global", "if", "import",
    "in", "is", "lambda", "nonlocal", "not", "or", "pass", "raise", "return", "try", "while",
    "with", "yield",
];

const PRELUDE: &str = "\
from enum import IntEnum
from typing import Any, Optional

from genom.codel import Elements, Raised, Union, View
";

/// A scope, which may be a class as well, with all that is in it in order of declaration.
#[derive(Default)]
struct Scope {
    /// The first line of the class.
    head: Option<String>,
    /// Its members, a line each.
    body: Vec<String>,
    /// Lines after it, in the scope that it is in.
    after: Vec<String>,
    inner: Vec<(String, Scope)>,
}

impl Scope {
    fn at(&mut self, path: &[String]) -> &mut Self {
        let Some((first, rest)) = path.split_first() else { return self };
        let found = self.inner.iter().position(|(name, _)| name == first);
        let at = found.unwrap_or_else(|| {
            self.inner.push((first.clone(), Self::default()));
            self.inner.len() - 1
        });
        self.inner[at].1.at(rest)
    }

    fn write(&self, out: &mut String, depth: usize) {
        let indent = "    ".repeat(depth);
        for line in &self.body {
            // Writing to a String cannot fail.
            let _ = writeln!(out, "{indent}{line}");
        }
        for (name, scope) in &self.inner {
            let head = scope.head.clone().unwrap_or_else(|| format!("class {}:", word(name)));
            if !scope.body.is_empty() || !scope.inner.is_empty() {
                let _ = writeln!(out, "\n{indent}{head}");
                scope.write(out, depth + 1);
            }
            for line in &scope.after {
                let _ = writeln!(out, "{indent}{line}");
            }
        }
    }
}

struct Writer<'a> {
    types: &'a TypeTable,
    /// The component, whose scope is that of the module.
    own: Option<&'a str>,
}

pub(super) fn write(
    spec: &Specification,
    chosen: &[&Component],
    records: &HashSet<TypeId>,
) -> String {
    let names: Vec<_> = chosen.iter().map(|component| component.name.as_str()).collect();
    let writer = Writer { types: &spec.types, own: names.first().copied() };
    let mut scope = Scope::default();
    for step in order::order(&spec.types, records) {
        if let order::Step::Define(id) = step {
            writer.define(id, &mut scope);
        }
    }
    for one in &spec.constants {
        let ty = match &one.value {
            Value::Bool(_) => "bool",
            Value::String(_) => "str",
            Value::Number(number) if number.is_f64() => "float",
            _ => "int",
        };
        let text = format!("{}: {ty}", word(one.name.last()));
        scope.at(writer.path(&one.name)).after.push(text);
    }
    let mut out =
        format!("\"\"\"Types of {}: made by genomd, do not edit.\"\"\"\n\n", names.join(", "));
    out.push_str(PRELUDE);
    scope.write(&mut out, 0);
    out
}

impl Writer<'_> {
    /// A name with the scopes that it is in, without that of the component.
    fn path<'n>(&self, name: &'n ScopedName) -> &'n [String] {
        match name.segments() {
            [first, rest @ ..] if Some(first.as_str()) == self.own && !rest.is_empty() => rest,
            all => all,
        }
    }

    fn define(&self, id: TypeId, all: &mut Scope) {
        let kind = self.types.kind(id);
        let Some(name) = kind.name() else { return };
        let class = word(name.last());
        let scope = all.at(self.path(name));
        match kind {
            Kind::Enum { enumerators, .. } => {
                scope.head = Some(format!("class {class}(IntEnum):"));
                let rank = |(rank, one): (usize, &String)| format!("{one} = {rank}");
                scope.body.extend(enumerators.iter().enumerate().map(rank));
                // In IDL, enumerators stand in the scope of their enumeration.
                scope.after.extend(enumerators.iter().map(|one| format!("{one} = {class}.{one}")));
            }
            Kind::Struct { members, .. } => self.class(scope, &class, "View", members),
            Kind::Exception { members, .. } => self.class(scope, &class, "Raised", members),
            Kind::Union { discriminant, members, .. } => {
                scope.head = Some(format!("class {class}(Union):"));
                scope.body.push(format!("d: {}", self.spell(*discriminant)));
                let member = |name: &str, ty| format!("{}: {}", word(name), self.spell(ty));
                scope.body.extend(members.iter().map(|one| member(&one.name, one.ty)));
            }
            Kind::Typedef { target, .. } => {
                scope.after.push(format!("{class} = {}", self.spell(*target)));
            }
            _ => {}
        }
    }

    /// A class with attributes, all of which may be given when one is made.
    fn class(&self, scope: &mut Scope, name: &str, base: &str, members: &[Member]) {
        scope.head = Some(format!("class {name}({base}):"));
        let mut given = String::new();
        for one in members {
            let (name, ty) = (word(&one.name), self.spell(one.ty));
            scope.body.push(format!("{name}: {ty}"));
            let _ = write!(given, ", {name}: {ty} = ...");
        }
        let star = if given.is_empty() { "" } else { ", *" };
        scope.body.push(format!("def __init__(self{star}{given}) -> None: ..."));
    }

    /// The type of a member.
    fn spell(&self, id: TypeId) -> String {
        match self.types.kind(id) {
            Kind::Boolean => "bool".to_owned(),
            Kind::Char | Kind::String { .. } => "str".to_owned(),
            Kind::Float | Kind::Double => "float".to_owned(),
            kind if kind.rust_number().is_some() => "int".to_owned(),
            // An array of NumPy, or a memoryview.
            Kind::Array { .. } if self.is_of_numbers(id) => "Any".to_owned(),
            Kind::Array { element, .. } | Kind::Sequence { element, .. } => {
                format!("Elements[{}]", self.spell(*element))
            }
            Kind::Optional { element } => format!("Optional[{}]", self.spell(*element)),
            Kind::Typedef { target, .. } => self.spell(*target),
            kind => match kind.name() {
                Some(name) if !matches!(kind, Kind::Native { .. }) => {
                    let path = self.path(name).iter();
                    path.map(|one| word(one)).collect::<Vec<_>>().join(".")
                }
                _ => "Any".to_owned(),
            },
        }
    }

    fn is_of_numbers(&self, id: TypeId) -> bool {
        match self.types.resolved(id) {
            Kind::Array { element, .. } => self.is_of_numbers(*element),
            Kind::Char => false,
            kind => matches!(kind, Kind::Boolean) || kind.rust_number().is_some(),
        }
    }
}

fn word(name: &str) -> String {
    if KEYWORDS.contains(&name) { format!("{name}_") } else { name.to_owned() }
}
