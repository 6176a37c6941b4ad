//! Members of a value by their names, without a copy of the whole.

use crate::graph::{Scalar, Shape};
use crate::memory::View;
use crate::record::Record;

impl Record {
    /// The bytes of a member that is a sequence or an array of octets.
    #[must_use]
    pub fn octets(&self, member: &str) -> Option<&[u8]> {
        self.named(member)?.octets()
    }

    /// The bytes of a member that is a string.
    #[must_use]
    pub fn text(&self, member: &str) -> Option<&[u8]> {
        let view = self.named(member)?;
        matches!(view.node().shape, Shape::Text { .. }).then(|| view.text())
    }

    /// A member that is an integer and not negative, or a boolean.
    #[must_use]
    pub fn unsigned(&self, member: &str) -> Option<u64> {
        let view = self.named(member)?;
        let real = matches!(view.node().shape, Shape::Scalar(Scalar::Float | Scalar::Double));
        let scalar = matches!(view.node().shape, Shape::Scalar(_));
        if scalar && !real { u64::try_from(view.integer()).ok() } else { None }
    }

    fn named(&self, member: &str) -> Option<View<'_>> {
        self.view().members().find(|(name, _)| *name == member).map(|(_, view)| view)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use serde_json::json;

    use crate::{DataType, Kind, Member, Record, ScopedName, TypeTable};

    #[test]
    fn members_are_read_as_what_they_are_and_not_as_anything_else() {
        let mut table = TypeTable::default();
        let octet = table.add(Kind::Octet);
        let data = table.add(Kind::Sequence { element: octet, bound: None });
        let row = table.add(Kind::Array { element: octet, length: 2 });
        let text = table.add(Kind::String { bound: Some(8) });
        let long = table.add(Kind::Long);
        let longs = table.add(Kind::Sequence { element: long, bound: None });
        let members =
            [("data", data), ("row", row), ("text", text), ("long", long), ("longs", longs)];
        let members = members.map(|(name, ty)| Member { name: name.into(), ty }).into();
        let id = table.add(Kind::Struct { name: ScopedName::new(["all"]), members });
        let ty = DataType::new(&Arc::new(table), id).unwrap();
        let mut value = Record::new(&ty);
        assert_eq!(value.octets("data"), Some(&[][..]));
        let json = json!({"data": [7, 8, 9], "row": [1, 2], "text": "mono8", "long": 5});
        value.merge_json(&json).unwrap();
        assert_eq!(value.octets("data"), Some(&[7, 8, 9][..]));
        assert_eq!(value.octets("row"), Some(&[1, 2][..]));
        assert_eq!((value.text("text"), value.unsigned("long")), (Some(&b"mono8"[..]), Some(5)));
        value.merge_json(&json!({"long": -5})).unwrap();
        assert_eq!(value.unsigned("long"), None);
        for member in ["text", "long", "longs", "none"] {
            assert_eq!(value.octets(member), None, "{member}");
        }
        assert_eq!((value.text("data"), value.unsigned("text")), (None, None));
    }
}
