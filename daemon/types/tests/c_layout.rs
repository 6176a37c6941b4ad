//! Layouts equal those of the C compiler, for random types mapped as genom3.md 5.2 says.

#![allow(clippy::unwrap_used, clippy::panic)] // also in helpers, where clippy.toml does not reach

mod support;

use std::collections::HashSet;
use std::fmt::Write as _;
use std::process::Command;
use std::sync::Arc;

use genom_types::{DataType, Kind, TypeId, TypeTable};
use support::{Rng, Types};

/// C declarations of types, written from the mapping table.
struct Header<'a> {
    table: &'a TypeTable,
    declared: HashSet<String>,
    text: String,
}

impl Header<'_> {
    /// The C declaration of `name` with that type; types it needs are declared first.
    fn declare(&mut self, id: TypeId, name: &str) -> String {
        match self.table.kind(id) {
            Kind::Array { element, length } => self.declare(*element, &format!("{name}[{length}]")),
            Kind::String { bound: Some(bound) } => format!("char {name}[{bound}]"),
            Kind::String { bound: None } => format!("char *{name}"),
            kind => {
                let tag = self.table.c_name(id);
                if self.declared.insert(tag.clone()) {
                    let body = self.body(kind, &tag);
                    self.text += &body;
                }
                format!("{tag} {name}")
            }
        }
    }

    fn body(&mut self, kind: &Kind, tag: &str) -> String {
        match kind {
            Kind::Sequence { element, bound: None } => {
                let buffer = self.declare(*element, "_element");
                // A pointer to an array or string element needs a typedef of the element.
                format!(
                    "typedef {};\ntypedef struct {{ uint32_t _maximum, _length; {tag}_element \
                     *_buffer; void (*_release)(void *); }} {tag};\n",
                    buffer.replacen("_element", &format!("{tag}_element"), 1)
                )
            }
            Kind::Sequence { element, bound: Some(bound) } => {
                let buffer = self.declare(*element, &format!("_buffer[{bound}]"));
                format!("typedef struct {{ uint32_t _maximum, _length; {buffer}; }} {tag};\n")
            }
            Kind::Optional { element } => {
                let value = self.declare(*element, "_value");
                format!("typedef struct {{ bool _present; {value}; }} {tag};\n")
            }
            Kind::Enum { .. } => format!("typedef uint32_t {tag};\n"),
            Kind::Struct { members, .. } => {
                let members: String =
                    members.iter().map(|m| self.declare(m.ty, &m.name) + "; ").collect();
                format!("typedef struct {{ {members}}} {tag};\n")
            }
            Kind::Union { discriminant, members, .. } => {
                let members: String =
                    members.iter().map(|m| self.declare(m.ty, &m.name) + "; ").collect();
                let d = self.declare(*discriminant, "_d");
                format!("typedef struct {{ {d}; union {{ {members}}} _u; }} {tag};\n")
            }
            Kind::Typedef { target, .. } => {
                let target = self.declare(*target, tag);
                format!("typedef {target};\n")
            }
            _ => String::new(),
        }
    }
}

/// C names of the members whose offsets `Layout::offsets` holds.
fn places(kind: &Kind) -> Vec<String> {
    let names: &[&str] = match kind {
        Kind::Sequence { bound: None, .. } => &["_maximum", "_length", "_buffer", "_release"],
        Kind::Sequence { .. } => &["_maximum", "_length", "_buffer"],
        Kind::Optional { .. } => &["_value"],
        Kind::Union { .. } => &["_u"],
        Kind::Struct { members, .. } => return members.iter().map(|m| m.name.clone()).collect(),
        _ => &[],
    };
    names.iter().map(|&name| name.to_owned()).collect()
}

#[test]
fn layouts_are_those_of_the_c_compiler() {
    let mut table = TypeTable::default();
    let mut rng = Rng::new(2024);
    let mut types = Types { table: &mut table, rng: &mut rng, fixed: false, count: 0 };
    for round in 0..80 {
        types.structure(1 + round % 4);
    }
    let table = Arc::new(table);
    let mut header = Header { table: &table, declared: HashSet::new(), text: String::new() };
    let (mut prints, mut ours) = (String::new(), String::new());
    for (id, kind) in table.iter() {
        if matches!(kind, Kind::String { .. } | Kind::Array { .. }) {
            continue;
        }
        let tag = table.c_name(id);
        _ = header.declare(id, "x");
        let ty = DataType::new(&table, id).unwrap();
        _ = write!(prints, "P(\"%s %zu %zu\", \"{tag}\", sizeof({tag}), _Alignof({tag}));");
        _ = write!(ours, "{tag} {} {}", ty.size(), ty.align());
        let places = places(kind);
        assert!(matches!(kind, Kind::Typedef { .. }) || places.len() == ty.layout().offsets.len());
        for (place, offset) in places.iter().zip(&ty.layout().offsets) {
            _ = write!(prints, "P(\" {place} %zu\", offsetof({tag}, {place}));");
            _ = write!(ours, " {place} {offset}");
        }
        prints += "P(\"\\n\");\n";
        ours += "\n";
    }
    let folder = tempfile::tempdir().unwrap();
    let (source, program) = (folder.path().join("layout.c"), folder.path().join("layout"));
    let text = format!(
        "#include <stdbool.h>\n#include <stddef.h>\n#include <stdint.h>\n#include <stdio.h>\n\
         #define P(...) printf(__VA_ARGS__)\n{}\nint main(void) {{\n{prints}return 0;\n}}\n",
        header.text
    );
    std::fs::write(&source, &text).unwrap();
    let built = Command::new("cc").args(["-w", "-o"]).arg(&program).arg(&source).output().unwrap();
    assert!(built.status.success(), "{}\n{text}", String::from_utf8_lossy(&built.stderr));
    let theirs = Command::new(&program).output().unwrap();
    let theirs = String::from_utf8(theirs.stdout).unwrap();
    assert!(ours.lines().count() > 300, "the generator made only {}", ours.lines().count());
    for (ours, theirs) in ours.lines().zip(theirs.lines()) {
        assert_eq!(ours, theirs);
    }
    assert_eq!(ours, theirs);
}
