//! A type with all that it is made of, to be sent to another process.

use std::collections::HashMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::data_type::DataType;
use crate::kind::{Kind, TypeId};
use crate::layout::LayoutError;
use crate::table::TypeTable;

/// Most types that a definition is read with.
const MOST: usize = 1 << 16;

/// A self-contained description of one type.
///
/// ```
/// # use std::sync::Arc;
/// # use genom_types::{DataType, Definition, Kind, TypeTable};
/// let mut table = TypeTable::default();
/// let element = table.add(Kind::Double);
/// let list = table.add(Kind::Sequence { element, bound: None });
/// let list = DataType::new(&Arc::new(table), list)?;
/// assert!(Definition::of(&list).read()?.same_as(&list));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Definition {
    /// The type comes first; the others in the order in which they are met.
    types: Vec<Kind>,
    /// Digest of the type where the definition was made.
    digest: String,
}

/// A definition that describes no type.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum DefinitionError {
    /// A type is made of one that is not part of the definition, or there are too many.
    #[error("the definition of a type is not complete, or has more than {MOST} types")]
    Incomplete,
    /// The type cannot be laid out.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// It is not the type that it was made of.
    #[error("the definition of {name} describes another type")]
    Digest {
        /// Spelling of the type.
        name: String,
    },
}

impl Definition {
    /// The definition of a type.
    #[must_use]
    pub fn of(ty: &DataType) -> Self {
        let (table, mut known, mut order) = (ty.table(), HashMap::new(), vec![ty.id()]);
        known.insert(ty.id(), TypeId(0));
        let mut types = Vec::new();
        while let Some(&id) = order.get(types.len()) {
            let mut kind = table.kind(id).clone();
            for part in kind.parts_mut() {
                let next = TypeId(u32::try_from(order.len()).unwrap_or(u32::MAX));
                let number = *known.entry(*part).or_insert(next);
                if number == next {
                    order.push(*part);
                }
                *part = number;
            }
            types.push(kind);
        }
        Self { types, digest: ty.digest().to_owned() }
    }

    /// The type.
    ///
    /// # Errors
    /// It is none, or not the one that the definition was made of.
    pub fn read(mut self) -> Result<DataType, DefinitionError> {
        let count = self.types.len();
        let inside = |id: &mut TypeId| id.index() < count;
        let complete = self.types.iter_mut().all(|kind| kind.parts_mut().into_iter().all(inside));
        if !complete || count == 0 || count > MOST {
            return Err(DefinitionError::Incomplete);
        }
        let ty = DataType::new(&Arc::new(TypeTable::of(self.types)), TypeId(0))?;
        match ty.digest() == self.digest {
            true => Ok(ty),
            false => Err(DefinitionError::Digest { name: ty.name().to_owned() }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::{Label, Member, ScopedName, UnionMember};

    fn member(name: &str, ty: TypeId) -> Member {
        Member { name: name.to_owned(), ty }
    }

    /// A tree: it contains itself in a sequence, a union and an array of enums.
    fn tree() -> DataType {
        let mut table = TypeTable::default();
        table.add(Kind::Double);
        let name = ScopedName::new(["demo", "tree"]);
        let tree = table.add(Kind::Forward { name: name.clone(), union: false });
        let children = table.add(Kind::Sequence { element: tree, bound: None });
        let color = table.add(Kind::Enum {
            name: ScopedName::new(["demo", "color"]),
            enumerators: vec!["RED".to_owned(), "BLUE".to_owned()],
        });
        let colors = table.add(Kind::Array { element: color, length: 3 });
        let text = table.add(Kind::String { bound: Some(8) });
        let either = table.add(Kind::Union {
            name: ScopedName::new(["demo", "either"]),
            discriminant: color,
            members: vec![
                UnionMember { name: "a".into(), ty: colors, labels: vec![Label::Value(0)] },
                UnionMember { name: "b".into(), ty: text, labels: vec![Label::Default] },
            ],
        });
        let members = vec![member("children", children), member("either", either)];
        table.complete(tree, Kind::Struct { name, members });
        DataType::new(&Arc::new(table), tree).unwrap()
    }

    #[test]
    fn a_type_is_the_same_after_a_way_through_text() {
        let sent = tree();
        let text = serde_json::to_string(&Definition::of(&sent)).unwrap();
        assert!(!text.contains("Double"), "only what it is made of: {text}");
        let received = serde_json::from_str::<Definition>(&text).unwrap().read().unwrap();
        assert!(received.same_as(&sent));
        assert_eq!((received.name(), received.digest()), (sent.name(), sent.digest()));
        assert_eq!(received.layout(), sent.layout());
    }

    #[test]
    fn a_definition_that_was_tampered_with_is_refused() {
        let good = Definition::of(&tree());
        let empty = Definition { types: Vec::new(), ..good.clone() };
        assert_eq!(empty.read().unwrap_err(), DefinitionError::Incomplete);
        let mut cut = good.clone();
        cut.types.pop();
        assert_eq!(cut.read().unwrap_err(), DefinitionError::Incomplete);
        let mut other = good.clone();
        other.digest.push('0');
        assert!(matches!(other.read().unwrap_err(), DefinitionError::Digest { .. }));
        let name = ScopedName::new(["endless"]);
        let endless = Kind::Struct { name, members: vec![member("self", TypeId(0))] };
        let endless = Definition { types: vec![endless], ..good.clone() };
        assert!(matches!(endless.read().unwrap_err(), DefinitionError::Layout(_)));
        let typedef = Kind::Typedef { name: ScopedName::new(["round"]), target: TypeId(0) };
        let round = Definition { types: vec![typedef], ..good };
        assert!(round.read().is_err());
    }
}
