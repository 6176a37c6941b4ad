//! Searches functions and types in the debug information of a library.

use std::collections::HashMap;

use gimli::{
    AttributeValue, DebuggingInformationEntry, DwTag, Dwarf, EndianSlice, EntriesTreeNode,
    RunTimeEndian, Unit,
};

use crate::Sections;

use super::node::{At, Composite, Function, Member, Node};

type Reader<'a> = EndianSlice<'a, RunTimeEndian>;
type Entry<'a> = DebuggingInformationEntry<Reader<'a>>;

/// The items that were found.
#[derive(Debug)]
pub struct Found<'n> {
    /// Functions, by their symbol.
    pub functions: HashMap<&'n str, Function>,
    /// Types, by the name that was searched.
    pub types: HashMap<&'n str, At>,
}

/// The items to search.
#[derive(Debug)]
pub struct Wanted<'n> {
    /// Functions, by their symbol in the library.
    pub functions: Vec<&'n str>,
    /// Types: typedefs, or in C++ structs, by full name without the leading `::`.
    pub types: Vec<&'n str>,
}

/// Parsed debug information.
#[derive(Debug)]
pub struct DebugInfo<'a> {
    dwarf: Dwarf<Reader<'a>>,
    units: Vec<Unit<Reader<'a>>>,
}

impl<'a> DebugInfo<'a> {
    /// Parses the debug information in `sections`.
    ///
    /// # Errors
    /// A unit cannot be read.
    pub fn new(sections: &'a Sections<'_>) -> gimli::Result<Self> {
        let endian = match sections.little_endian {
            true => RunTimeEndian::Little,
            false => RunTimeEndian::Big,
        };
        let section = |id: gimli::SectionId| -> gimli::Result<Reader<'a>> {
            Ok(EndianSlice::new(sections.get(id.name()), endian))
        };
        let dwarf = Dwarf::load(section)?;
        let mut headers = dwarf.units();
        let mut units = Vec::new();
        while let Some(header) = headers.next()? {
            units.push(dwarf.unit(header)?);
        }
        Ok(Self { dwarf, units })
    }

    /// Whether a unit keeps its types in a separate file (`-gsplit-dwarf`).
    pub fn is_split(&self) -> bool {
        let mut roots = self.units.iter().filter_map(|unit| {
            let mut entries = unit.entries();
            entries.next_dfs().ok()?.map(|root| {
                [gimli::DW_AT_dwo_name, gimli::DW_AT_GNU_dwo_name]
                    .iter()
                    .any(|name| root.attr_value(*name).is_some())
            })
        });
        roots.any(|split| split)
    }

    /// Searches the functions that the library defines, and the types.
    pub fn find<'n>(&self, wanted: &Wanted<'n>) -> Found<'n> {
        let mut found = Found { functions: HashMap::new(), types: HashMap::new() };
        for unit in 0..self.units.len() {
            // A unit that cannot be read is skipped.
            if let Err(why) = self.find_in(unit, wanted, &mut found) {
                tracing::debug!("debug information, unit {unit}: {why}");
            }
        }
        found
    }

    fn find_in<'n>(
        &self,
        unit: usize,
        wanted: &Wanted<'n>,
        found: &mut Found<'n>,
    ) -> gimli::Result<()> {
        let mut tree = self.units[unit].entries_tree(None)?;
        self.find_below(unit, tree.root()?, "", wanted, found)
    }

    /// Searches the children of a unit, or of a namespace or struct called `scope`.
    fn find_below<'n>(
        &self,
        unit: usize,
        node: EntriesTreeNode<'_, '_, Reader<'a>>,
        scope: &str,
        wanted: &Wanted<'n>,
        found: &mut Found<'n>,
    ) -> gimli::Result<()> {
        let mut children = node.children();
        while let Some(child) = children.next()? {
            let entry = child.entry();
            let offset = entry.offset();
            match entry.tag() {
                gimli::DW_TAG_subprogram if scope.is_empty() && is_defined(entry) => {
                    let name = self.symbol(unit, entry);
                    if let Some(name) = wanted.functions.iter().find(|wanted| **wanted == name) {
                        found.functions.insert(name, self.function(unit, child)?);
                    }
                }
                gimli::DW_TAG_typedef | gimli::DW_TAG_structure_type | gimli::DW_TAG_namespace => {
                    let space = if scope.is_empty() { "" } else { "::" };
                    let name = format!("{scope}{space}{}", self.name(unit, entry));
                    let is_type = !is(entry, gimli::DW_TAG_namespace)
                        && entry.attr_value(gimli::DW_AT_declaration).is_none();
                    let right = wanted.types.iter().find(|wanted| **wanted == name);
                    if let Some(right) = right.filter(|_| is_type) {
                        found.types.insert(right, At { unit, offset });
                    }
                    let way = format!("{name}::");
                    if wanted.types.iter().any(|wanted| wanted.starts_with(&way)) {
                        self.find_below(unit, child, &name, wanted, found)?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The symbol of a function: its own name in C, a mangled one in C++.
    fn symbol(&self, unit: usize, entry: &Entry<'a>) -> String {
        match entry.attr_value(gimli::DW_AT_linkage_name) {
            Some(name) => self.text(unit, name),
            None => self.name(unit, entry),
        }
    }

    /// Result and parameters of a function, or of a function type.
    fn function(
        &self,
        unit: usize,
        node: EntriesTreeNode<'_, '_, Reader<'a>>,
    ) -> gimli::Result<Function> {
        let result = self.ty(unit, node.entry());
        let mut parameters = Vec::new();
        let mut children = node.children();
        while let Some(child) = children.next()? {
            if child.entry().tag() == gimli::DW_TAG_formal_parameter {
                let entry = child.entry();
                parameters.push((self.name(unit, entry), self.ty(unit, entry)));
            }
        }
        Ok(Function { result, parameters })
    }

    /// The type at a location.
    pub fn node(&self, at: At) -> Node {
        self.read(at).unwrap_or(Node::Unknown)
    }

    fn read(&self, at: At) -> gimli::Result<Node> {
        let mut tree = self.units[at.unit].entries_tree(Some(at.offset))?;
        let node = tree.root()?;
        let entry = node.entry();
        let inner = self.ty(at.unit, entry);
        let name = self.name(at.unit, entry);
        let size = number(entry, gimli::DW_AT_byte_size);
        Ok(match entry.tag() {
            gimli::DW_TAG_base_type => Node::Base {
                name,
                size: size.unwrap_or(0),
                encoding: match entry.attr_value(gimli::DW_AT_encoding) {
                    Some(AttributeValue::Encoding(encoding)) => encoding,
                    _ => gimli::DwAte(0),
                },
            },
            gimli::DW_TAG_pointer_type => Node::Pointer(inner),
            gimli::DW_TAG_reference_type | gimli::DW_TAG_rvalue_reference_type => {
                Node::Reference(inner)
            }
            gimli::DW_TAG_const_type => Node::Qualified("const", inner),
            gimli::DW_TAG_volatile_type => Node::Qualified("volatile", inner),
            gimli::DW_TAG_restrict_type => Node::Qualified("restrict", inner),
            gimli::DW_TAG_atomic_type => Node::Qualified("_Atomic", inner),
            gimli::DW_TAG_typedef => Node::Typedef(name, inner),
            gimli::DW_TAG_enumeration_type => Node::Enum { name, size: size.unwrap_or(0) },
            gimli::DW_TAG_structure_type | gimli::DW_TAG_class_type => {
                Node::Struct(self.composite(at.unit, node, name, size)?)
            }
            gimli::DW_TAG_union_type => Node::Union(self.composite(at.unit, node, name, size)?),
            gimli::DW_TAG_array_type => {
                let mut lengths = Vec::new();
                let mut children = node.children();
                while let Some(child) = children.next()? {
                    if child.entry().tag() == gimli::DW_TAG_subrange_type {
                        let last = number(child.entry(), gimli::DW_AT_upper_bound);
                        let count = number(child.entry(), gimli::DW_AT_count);
                        lengths.push(count.or(last.and_then(|last| last.checked_add(1))));
                    }
                }
                Node::Array { element: inner, lengths }
            }
            gimli::DW_TAG_subroutine_type => Node::Function(self.function(at.unit, node)?),
            _ => Node::Unknown,
        })
    }

    fn composite(
        &self,
        unit: usize,
        node: EntriesTreeNode<'_, '_, Reader<'a>>,
        name: String,
        size: Option<u64>,
    ) -> gimli::Result<Composite> {
        let mut found = Composite { name, size, ..Composite::default() };
        let mut children = node.children();
        while let Some(child) = children.next()? {
            let entry = child.entry();
            if is(entry, gimli::DW_TAG_template_type_parameter) && found.element.is_none() {
                found.element = self.ty(unit, entry);
            }
            if is(entry, gimli::DW_TAG_subprogram)
                && entry.attr_value(gimli::DW_AT_virtuality).is_some()
            {
                let name = self.name(unit, entry);
                found.methods.push((name, self.function(unit, child)?));
                continue;
            }
            // Static data members of classes are marked external; they are not part of the layout.
            let own = is(entry, gimli::DW_TAG_member)
                && entry.attr_value(gimli::DW_AT_external).is_none();
            if own || is(entry, gimli::DW_TAG_inheritance) {
                let offset = number(entry, gimli::DW_AT_data_member_location).unwrap_or(0);
                let (name, ty) = (self.name(unit, entry), self.ty(unit, entry));
                found.members.push(Member { name, offset, ty });
            }
        }
        Ok(found)
    }

    fn name(&self, unit: usize, entry: &Entry<'a>) -> String {
        entry.attr_value(gimli::DW_AT_name).map_or(String::new(), |name| self.text(unit, name))
    }

    fn text(&self, unit: usize, text: AttributeValue<Reader<'a>>) -> String {
        let text = self.dwarf.attr_string(&self.units[unit], text).ok();
        text.map_or(String::new(), |text| text.to_string_lossy().into_owned())
    }

    /// The type that an entry refers to; `None` for `void`, or a type in another file.
    fn ty(&self, unit: usize, entry: &Entry<'a>) -> Option<At> {
        match entry.attr_value(gimli::DW_AT_type)? {
            AttributeValue::UnitRef(offset) => Some(At { unit, offset }),
            AttributeValue::DebugInfoRef(offset) => {
                let found = self.units.iter().enumerate().find_map(|(unit, candidate)| {
                    Some((unit, offset.to_unit_offset(&candidate.header)?))
                });
                found.map(|(unit, offset)| At { unit, offset })
            }
            _ => None,
        }
    }

    /// The type behind typedefs and qualifiers; `None` for `void`.
    pub fn stripped(&self, mut at: Option<At>) -> Option<(At, Node)> {
        // More steps than any real chain has.
        for _ in 0..64 {
            let here = at?;
            match self.node(here) {
                Node::Typedef(_, inner) | Node::Qualified(_, inner) => at = inner,
                node => return Some((here, node)),
            }
        }
        None
    }

    /// The C declaration of a function.
    pub fn declaration(&self, name: &str, function: &Function) -> String {
        let parameters = function.parameters.iter().map(|(name, ty)| {
            let ty = self.spell(*ty);
            let space = if ty.ends_with(['*', '&']) { "" } else { " " };
            format!("{ty}{space}{name}")
        });
        let parameters: Vec<_> = parameters.collect();
        format!("{} {name}({})", self.spell(function.result), parameters.join(", "))
    }

    /// The members of a struct: `{ double x; char what[64]; }`.
    pub fn layout(&self, at: At) -> String {
        match self.stripped(Some(at)) {
            Some((_, Node::Struct(found))) => {
                let member =
                    |member: &Member| format!("{} {};", self.spell(member.ty), member.name);
                let members: Vec<_> = found.members.iter().map(member).collect();
                format!("{{ {} }}", members.join(" "))
            }
            _ => self.spell(Some(at)),
        }
    }

    /// A type as written in C, by its typedef where it has one.
    pub fn spell(&self, at: Option<At>) -> String {
        self.spell_to(at, 16)
    }

    fn spell_to(&self, at: Option<At>, depth: usize) -> String {
        let Some(at) = at else { return "void".to_owned() };
        if depth == 0 {
            return "...".to_owned();
        }
        match self.node(at) {
            // As <stdbool.h> spells it.
            Node::Base { name, .. } if name == "_Bool" => "bool".to_owned(),
            Node::Base { name, .. } | Node::Typedef(name, _) => name,
            Node::Qualified(word, inner) => match inner.map(|inner| self.node(inner)) {
                Some(Node::Pointer(_)) => format!("{} {word}", self.spell_to(inner, depth - 1)),
                _ => format!("{word} {}", self.spell_to(inner, depth - 1)),
            },
            Node::Pointer(inner) | Node::Reference(inner) => {
                let sign = if matches!(self.node(at), Node::Pointer(_)) { '*' } else { '&' };
                let inner = self.spell_to(inner, depth - 1);
                let space = if inner.ends_with('*') { "" } else { " " };
                format!("{inner}{space}{sign}")
            }
            Node::Struct(composite) => tagged("struct", &composite.name),
            Node::Union(composite) => tagged("union", &composite.name),
            Node::Enum { name, .. } => tagged("enum", &name),
            Node::Array { element, lengths } => {
                let length = |length: &Option<u64>| {
                    length.map_or("[]".to_owned(), |length| format!("[{length}]"))
                };
                let lengths: String = lengths.iter().map(length).collect();
                format!("{}{lengths}", self.spell_to(element, depth - 1))
            }
            Node::Function(_) => "function".to_owned(),
            Node::Unknown => "?".to_owned(),
        }
    }
}

fn tagged(keyword: &str, name: &str) -> String {
    if name.is_empty() { format!("{keyword} {{...}}") } else { format!("{keyword} {name}") }
}

/// Whether an entry of a function is a definition, not a declaration.
fn is_defined(entry: &Entry<'_>) -> bool {
    entry.attr_value(gimli::DW_AT_declaration).is_none()
        && entry.attr_value(gimli::DW_AT_external).is_some()
}

fn is(entry: &Entry<'_>, tag: DwTag) -> bool {
    entry.tag() == tag
}

fn number(entry: &Entry<'_>, name: gimli::DwAt) -> Option<u64> {
    entry.attr_value(name)?.udata_value()
}
