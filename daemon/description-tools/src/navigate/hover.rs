//! Hover texts of names: declaration, documentation, size.

use genom_description::model::{Component, Service, Span};
use genom_types::{DataType, Kind, TypeId, TypeTable};

use super::Navigator;
use super::symbol::{Symbol, SymbolKind};

/// Most lines shown of a declaration.
const LINES: usize = 20;

impl Navigator {
    /// The hover text at a byte offset of a file, in Markdown, and the name it describes.
    #[must_use]
    pub fn hover(&self, file: u32, offset: u32) -> Option<(Span, String)> {
        let (span, symbol) = self.symbol_at(file, offset)?;
        let mut text = format!("```genom\n{}\n```\n", self.signature(symbol));
        if let Some(doc) = self.doc(symbol) {
            text.push_str(&format!("\n{doc}\n"));
        }
        if let Some(layout) = self.layout(symbol) {
            text.push_str(&format!("\n{layout}\n"));
        }
        Some((span, text))
    }

    /// The declaration as written, with its outer indentation removed.
    pub(super) fn signature(&self, symbol: &Symbol) -> String {
        let sources = &self.analysis.sources;
        let text = sources.text(symbol.signature).trim_end_matches(';');
        let text = match symbol.kind {
            SymbolKind::State => format!("state {}", symbol.name),
            SymbolKind::Enumerator => {
                let parent = self.table.get(symbol.parent).map_or("", |parent| &parent.name);
                format!("enum {parent} {{ {} }}", symbol.name)
            }
            SymbolKind::Parameter => format!("parameter {text}"),
            _ if text.is_empty() => symbol.name.to_string(),
            _ => text.to_owned(),
        };
        // The smallest indentation after the first line, usually that of the closing brace, is
        // removed.
        let indent = text.lines().skip(1).filter(|line| !line.trim().is_empty());
        let indent = indent.map(|line| line.len() - line.trim_start().len()).min().unwrap_or(0);
        let lines = text.lines().enumerate().map(|(rank, line)| {
            if rank == 0 { line } else { line.get(indent..).unwrap_or_default() }
        });
        let mut shown: Vec<&str> = lines.take(LINES).collect();
        if text.lines().count() > LINES {
            shown.push("...");
        }
        shown.join("\n")
    }

    /// The `doc` of a symbol, else the comment before its declaration or after it on the same line.
    pub(super) fn doc(&self, symbol: &Symbol) -> Option<String> {
        if symbol.doc.is_some() {
            return symbol.doc.clone();
        }
        let text = self.analysis.sources.file(symbol.extent.file)?.text();
        let after = text.get(symbol.extent.end as usize..)?.lines().next().unwrap_or_default();
        let after = after.trim_start_matches([',', ';']).trim();
        if let Some(comment) = comment(after) {
            return Some(comment);
        }
        let before = text.get(..symbol.extent.start as usize)?;
        let blank = before.len() - before.trim_end().len();
        let near = before.get(before.len() - blank..)?.matches('\n').count() <= 1;
        let before = before.trim_end();
        if !near {
            return None;
        }
        if before.ends_with("*/") {
            let start = before.rfind("/*")?;
            // A comment after something else on its line describes that.
            let line = before.get(..start)?.rsplit('\n').next().unwrap_or_default();
            return if line.trim().is_empty() { comment(before.get(start..)?) } else { None };
        }
        let lines: Vec<&str> = before
            .lines()
            .rev()
            .map_while(|line| line.trim().strip_prefix("//").map(str::trim))
            .collect();
        (!lines.is_empty()).then(|| lines.into_iter().rev().collect::<Vec<_>>().join("\n"))
    }

    /// Size, alignment and, for a member, offset in memory.
    fn layout(&self, symbol: &Symbol) -> Option<String> {
        let types = &self.analysis.specification.types;
        let id = self.type_of(symbol)?;
        let ty = DataType::new(types, id).ok()?;
        let bytes = |size: usize| format!("{size} byte{}", if size == 1 { "" } else { "s" });
        let named = if symbol.kind.is_type() || symbol.kind == SymbolKind::Exception {
            String::new()
        } else {
            format!("`{}`: ", types.spelling(id))
        };
        let mut text = format!("{named}{}, alignment {}", bytes(ty.size()), ty.align());
        if !ty.is_fixed_size() {
            text.push_str(", and memory of its own");
        }
        if symbol.kind == SymbolKind::Member
            && let Some(record) = self.table.get(symbol.parent)
            && let Some(record) = self.type_of(record)
            && let Ok(record) = DataType::new(types, record)
            && let Some(offset) =
                record.member_index(&symbol.name).and_then(|rank| record.member_offset(rank))
        {
            text.push_str(&format!(", offset {offset}"));
        }
        Some(text)
    }

    /// The checked type of a symbol that is a type or has one.
    fn type_of(&self, symbol: &Symbol) -> Option<TypeId> {
        use SymbolKind as K;
        let types = &self.analysis.specification.types;
        match symbol.kind {
            K::Ids => self.component(symbol.parent)?.ids,
            K::Member => {
                let record = self.type_of(self.table.get(symbol.parent)?)?;
                member(types, record, &symbol.name)
            }
            K::Port => {
                let component = self.component(symbol.parent)?;
                Some(component.ports.iter().find(|port| *port.name == *symbol.name)?.ty)
            }
            K::Parameter | K::Local => {
                let service = self.service(symbol.parent)?;
                let mut all = service.parameters.iter().chain(&service.locals);
                Some(all.find(|parameter| *parameter.name == *symbol.name)?.ty)
            }
            kind if kind.is_type() || kind == K::Exception => {
                let name = self.full_name(symbol);
                let named = |kind: &Kind| kind.name().is_some_and(|it| it.segments() == name);
                types.iter().find(|(_, kind)| named(kind)).map(|(id, _)| id)
            }
            _ => None,
        }
    }

    fn component(&self, id: usize) -> Option<&Component> {
        let name = &self.table.get(id)?.name;
        self.analysis.specification.components.iter().find(|component| *component.name == **name)
    }

    fn service(&self, id: usize) -> Option<&Service> {
        let symbol = self.table.get(id)?;
        let component = self.component(symbol.parent)?;
        component.services.iter().find(|service| *service.name == *symbol.name)
    }

    fn full_name(&self, symbol: &Symbol) -> Vec<String> {
        let mut name = vec![symbol.name.to_string()];
        let mut at = symbol.parent;
        while let Some(parent) = self.table.get(at).filter(|_| at != 0) {
            name.push(parent.name.to_string());
            at = parent.parent;
        }
        name.reverse();
        name
    }
}

fn member(types: &TypeTable, record: TypeId, name: &str) -> Option<TypeId> {
    if let Kind::Union { members, .. } = types.resolved(record) {
        return members.iter().find(|member| member.name == name).map(|member| member.ty);
    }
    types.members(record).iter().find(|member| member.name == name).map(|member| member.ty)
}

/// The text of a comment without delimiters; `None` if it is not a comment.
fn comment(text: &str) -> Option<String> {
    if let Some(line) = text.strip_prefix("//") {
        return Some(line.trim().to_owned());
    }
    let inside = text.strip_prefix("/*")?.split("*/").next()?;
    let lines: Vec<&str> =
        inside.lines().map(|line| line.trim().trim_start_matches('*').trim()).collect();
    let text = lines.join("\n").trim().to_owned();
    (!text.is_empty()).then_some(text)
}
