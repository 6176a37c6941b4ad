//! Types of a description, and where their parts lie in memory.

use serde::Deserialize;

use crate::foreign::Class;

/// A type as the request has it.
#[derive(Debug, Deserialize)]
pub(crate) struct RawType {
    kind: String,
    name: String,
    size: usize,
    fixed: bool,
    #[serde(default)]
    enumerators: Vec<String>,
    #[serde(default)]
    members: Vec<Member>,
    bound: Option<usize>,
    length: Option<usize>,
    element: Option<usize>,
    discriminant: Option<usize>,
    #[serde(default)]
    offsets: Vec<usize>,
}

/// A member of a struct, an exception or a union.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Member {
    pub(crate) name: String,
    pub(crate) offset: usize,
    #[serde(rename = "type")]
    pub(crate) ty: usize,
    /// Of a union: values of the discriminant; `None` is `default`.
    #[serde(default)]
    pub(crate) labels: Vec<Option<i64>>,
}

/// A type.
#[derive(Debug)]
pub(crate) struct Type {
    pub(crate) name: String,
    pub(crate) size: usize,
    /// It owns no memory elsewhere.
    pub(crate) fixed: bool,
    pub(crate) kind: Kind,
}

/// What a type is.
#[derive(Debug)]
pub(crate) enum Kind {
    Integer {
        signed: bool,
    },
    Float,
    Boolean,
    Char,
    Enum(Vec<String>),
    /// With a bound, so many bytes in place; without one, the address of memory of `malloc`.
    Text(Option<usize>),
    Array {
        element: usize,
        length: usize,
    },
    Sequence {
        element: usize,
        bound: Option<usize>,
        buffer: usize,
    },
    Optional {
        element: usize,
        at: usize,
    },
    Struct(Vec<Member>),
    Union {
        discriminant: usize,
        members: Vec<Member>,
    },
    /// Codels in Lua cannot use it.
    Unusable,
}

impl Kind {
    /// Whether codels get views of such values, not the values themselves.
    pub(crate) fn has_parts(&self) -> bool {
        matches!(
            self,
            Self::Array { .. } | Self::Sequence { .. } | Self::Struct(_) | Self::Union { .. }
        )
    }
}

/// All types of a component, by their index in the request.
#[derive(Debug)]
pub(crate) struct Types(Vec<Type>);

impl Types {
    pub(crate) fn new(raw: Vec<RawType>) -> Self {
        let count = raw.len();
        Self(raw.into_iter().map(|one| understand(one, count)).collect())
    }

    /// An index that genomd gave; of one that it did not, a type that nothing can use.
    pub(crate) fn get(&self, ty: usize) -> &Type {
        const NONE: &Type =
            &Type { name: String::new(), size: 0, fixed: true, kind: Kind::Unusable };
        self.0.get(ty).unwrap_or(NONE)
    }

    /// How C passes an input of this type by value; `None` if it passes an address.
    pub(crate) fn by_value(&self, ty: usize) -> Option<Class> {
        let Type { kind, size, .. } = self.get(ty);
        Some(match (kind, size) {
            (Kind::Integer { signed: true }, 2) => Class::I16,
            (Kind::Integer { signed: true }, 4) => Class::I32,
            (Kind::Integer { signed: true }, 8) => Class::I64,
            (Kind::Integer { signed: false }, 1) | (Kind::Boolean | Kind::Char, _) => Class::U8,
            (Kind::Integer { signed: false }, 2) => Class::U16,
            (Kind::Integer { signed: false }, 4) | (Kind::Enum(_), _) => Class::U32,
            (Kind::Integer { signed: false }, 8) => Class::U64,
            (Kind::Float, 4) => Class::F32,
            (Kind::Float, 8) => Class::F64,
            (Kind::Text(None), _) => Class::Address,
            _ => return None,
        })
    }

    /// The name of a part that codels in Lua cannot use.
    pub(crate) fn unusable(&self, ty: usize) -> Option<&str> {
        self.unusable_within(ty, &mut Vec::new())
    }

    fn unusable_within(&self, ty: usize, seen: &mut Vec<usize>) -> Option<&str> {
        if seen.contains(&ty) {
            return None;
        }
        seen.push(ty);
        let Type { name, kind, .. } = self.get(ty);
        match kind {
            Kind::Unusable => Some(name),
            Kind::Array { element, .. }
            | Kind::Sequence { element, .. }
            | Kind::Optional { element, .. } => self.unusable_within(*element, seen),
            Kind::Struct(members) | Kind::Union { members, .. } => {
                members.iter().find_map(|member| self.unusable_within(member.ty, seen))
            }
            _ => None,
        }
    }
}

fn understand(raw: RawType, count: usize) -> Type {
    let RawType { kind, name, size, fixed, members, .. } = raw;
    let known = |ty: Option<usize>| ty.filter(|ty| *ty < count);
    let sound = members.iter().all(|member| member.ty < count && member.offset <= size);
    let kind = match (kind.as_str(), known(raw.element), known(raw.discriminant)) {
        ("short" | "long" | "long long", ..) => Kind::Integer { signed: true },
        ("octet" | "unsigned short" | "unsigned long" | "unsigned long long", ..) => {
            Kind::Integer { signed: false }
        }
        ("float" | "double", ..) => Kind::Float,
        ("boolean", ..) => Kind::Boolean,
        ("char", ..) => Kind::Char,
        ("enum", ..) => Kind::Enum(raw.enumerators),
        ("string", ..) => Kind::Text(raw.bound),
        ("array", Some(element), _) => {
            Kind::Array { element, length: raw.length.unwrap_or_default() }
        }
        ("sequence", Some(element), _) => match raw.offsets.get(2) {
            Some(&buffer) => Kind::Sequence { element, bound: raw.bound, buffer },
            None => Kind::Unusable,
        },
        ("optional", Some(element), _) => match raw.offsets.first() {
            Some(&at) => Kind::Optional { element, at },
            None => Kind::Unusable,
        },
        ("struct" | "exception", ..) if sound => Kind::Struct(members),
        ("union", _, Some(discriminant)) if sound => Kind::Union { discriminant, members },
        _ => Kind::Unusable,
    };
    Type { name, size, fixed, kind }
}
