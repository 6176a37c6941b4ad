//! Comparison of what differs from C in C++ codels (genom3.md 6): objects of the standard library,
//! references, ports with virtual functions.

use genom_description::model::{Parameter, Port, PortDirection};
use genom_description_tools as tools;
use genom_types::{DataType, Kind, TypeId};

use super::super::mismatch::{Agreement, Mismatch};
use super::compare::{Comparison, Part};
use crate::cxx::CxxType;
use genom_elf::debug::{At, Composite, Node};

impl Comparison<'_> {
    /// The spelling of a type in C++.
    pub(super) fn in_cxx(&self, ty: TypeId) -> String {
        tools::declaration(self.types(), ty, "").trim_end().to_owned()
    }

    /// Compares a datum that is no scalar, with a type that was not compared with it yet.
    pub(super) fn object(
        &mut self,
        ty: TypeId,
        place: At,
        node: Node,
        at: Option<At>,
    ) -> Agreement {
        let types = self.types();
        match (types.kind(ty), node) {
            (Kind::Native { .. }, Node::Pointer(_)) => Ok(()),
            (Kind::Array { .. } | Kind::String { bound: Some(_) }, Node::Array { .. }) => {
                let (lengths, element) = self.dimensions(ty);
                self.array(&lengths, element, place)
            }
            (Kind::Union { .. }, Node::Struct(found)) => self.union(ty, &found, at),
            (Kind::String { bound: None }, Node::Struct(found)) => {
                self.template(ty, &found, "basic_string<char", at)
            }
            (Kind::Sequence { element, bound: None }, Node::Struct(found)) => {
                self.template(ty, &found, "vector<", at)?;
                // For a vector of bits the name is enough.
                if types.resolved(*element) == &Kind::Boolean || found.element.is_none() {
                    return Ok(());
                }
                let inside = self.memory(*element, found.element);
                inside.map_err(|why| why.within(format!("`{}`: its element", self.in_cxx(ty))))
            }
            (
                Kind::Sequence { .. }
                | Kind::Optional { .. }
                | Kind::Struct { .. }
                | Kind::Exception { .. },
                Node::Struct(found),
            ) => self.aggregate(ty, &found, at),
            _ => self.differ(ty, at),
        }
    }

    fn layout_in_cxx(&self, ty: TypeId) -> Result<CxxType, Mismatch> {
        let data = DataType::new(&self.plan.specification().types, ty)?;
        Ok(CxxType::new(&data)?)
    }

    /// Compares a class of the standard library, by name and size.
    fn template(&self, ty: TypeId, found: &Composite, name: &str, at: Option<At>) -> Agreement {
        if !found.name.starts_with(name) {
            return self.differ(ty, at);
        }
        let wanted = self.layout_in_cxx(ty)?.size() as u64;
        match found.size {
            Some(size) if size != wanted => {
                let class = self.in_cxx(ty);
                Err(Mismatch::OtherLibrary { class, ours: wanted, theirs: size })
            }
            _ => Ok(()),
        }
    }

    fn aggregate(&mut self, ty: TypeId, found: &Composite, at: Option<At>) -> Agreement {
        let types = self.types();
        let layout = self.layout_in_cxx(ty)?;
        let wanted: Vec<(String, usize, Part)> = match types.kind(ty) {
            Kind::Sequence { element, bound } => {
                let elements = Part::Elements(*element, bound.unwrap_or_default().into());
                vec![("e".to_owned(), 0, elements), ("n".to_owned(), layout.offset(1), Part::Size)]
            }
            Kind::Optional { element } => {
                let value = ("_value".to_owned(), layout.offset(0), Part::Datum(*element));
                vec![("_present".to_owned(), 0, Part::Flag), value]
            }
            _ => {
                let members = types.members(ty).iter().enumerate();
                let part = |(rank, member): (usize, &genom_types::Member)| {
                    (member.name.clone(), layout.offset(rank), Part::Datum(member.ty))
                };
                members.map(part).collect()
            }
        };
        self.members(&self.in_cxx(ty), wanted, layout.size(), found, at)
    }

    /// Compares the class of a port: an abstract struct with virtual functions in a fixed order.
    pub(super) fn abstract_port(&mut self, port: &Port, at: Option<At>) -> Agreement {
        let wanted: &[&str] = match (port.direction, port.multiple) {
            (PortDirection::In, _) => &["data", "read"],
            (PortDirection::Out, false) => &["data", "write"],
            (PortDirection::Out, true) => &["data", "write", "open", "close"],
        };
        let Some(found) = self.abstract_struct(at, wanted)? else { return Ok(()) };
        let Some((_, data)) = found.methods.first() else { return Ok(()) };
        // `this`, and the element's name.
        let arguments = if port.multiple { 2 } else { 1 };
        if data.parameters.len() != arguments {
            return Err(match port.multiple {
                true => Mismatch::Methods { kind: "multiple", arguments: "the name of an element" },
                false => Mismatch::Methods { kind: "simple", arguments: "nothing" },
            });
        }
        let datum = self.pointer(data.result).and_then(|target| self.memory(port.ty, target));
        datum.map_err(|why| why.within("its data"))
    }

    /// Compares the class of a remote: an abstract struct with `call`.
    pub(super) fn abstract_remote(
        &mut self,
        parameters: &[Parameter],
        at: Option<At>,
    ) -> Agreement {
        let Some(found) = self.abstract_struct(at, &["call"])? else { return Ok(()) };
        let Some((_, call)) = found.methods.first() else { return Ok(()) };
        // `this` comes first.
        let arguments = call.parameters.get(1..).unwrap_or_default();
        let (wanted, found) = (parameters.len(), arguments.len());
        if wanted != found {
            return Err(Mismatch::Call { wanted, found });
        }
        for (parameter, (_, at)) in parameters.iter().zip(arguments) {
            self.passed(parameter.ty, parameter.direction, *at)
                .map_err(|why| why.within(format!("argument `{}` of its call", parameter.name)))?;
        }
        Ok(())
    }

    /// Checks for a struct with these virtual functions in this order; `None` when only its name is
    /// known.
    fn abstract_struct(
        &self,
        at: Option<At>,
        wanted: &[&str],
    ) -> Result<Option<Composite>, Mismatch> {
        let target = self.pointer(at)?;
        let Some((_, node)) = self.info.stripped(target) else { return Ok(None) };
        let Node::Struct(found) = node else {
            return Err(Mismatch::other("an object", self.spelled(at)));
        };
        if found.size.is_none() {
            return Ok(None);
        }
        let names: Vec<&str> = found.methods.iter().map(|(name, _)| name.as_str()).collect();
        if names != wanted {
            let (wanted, found) = (wanted.join(", "), names.join(", "));
            let wanted = format!("an object with {wanted}");
            return Err(Mismatch::other(wanted, format!("one with {found}")));
        }
        Ok(Some(found))
    }
}
