//! Maps IDL types to messages that have the same encoding.
//!
//! | IDL | ROS |
//! |---|---|
//! | boolean, octet, char | `bool`, `uint8`, `int8` |
//! | integers, float, double | `int16` to `uint64`, `float32`, `float64` |
//! | enum | `uint32`, with constants |
//! | string, `string<n>` | `string`, `string<=n-1`: the C array also holds a NUL |
//! | array | `T[n]`, row-major |
//! | sequence, optional | `T[]`, `T[<=n]`, `T[<=1]` |
//! | struct | a message |
//! | union | a message: `genom_discriminant`, then each member as `T[<=1]` |
//!
//! ROS has no arrays of arrays, and a message cannot be a single value. For these there are
//! messages with one member `data`, which does not change the encoding.

mod problem;

use std::collections::{BTreeMap, BTreeSet};

use genom_types::message::{camel, snake};
use genom_types::{Kind, Member, ScopedName, TypeId, TypeTable};

pub use problem::{MapError, Place, Problem};

use crate::interface::{Action, Base, Constant, Field, Interface, Message, Service, Shape};
use crate::names::{self, TypeName};

/// Greatest length of a DDS type name in Cyclone DDS and Fast DDS.
const LONGEST: usize = 255;

/// Name of the first member of a union's message.
const DISCRIMINANT: &str = "genom_discriminant";

/// Collects the messages that the types of one table need.
pub struct Mapper<'a> {
    table: &'a TypeTable,
    /// ROS types as which IDL types and services masquerade, by full IDL name.
    masquerades: BTreeMap<String, TypeName>,
    made: BTreeMap<TypeName, (Option<TypeId>, Interface)>,
    /// Types being mapped, to detect those that contain themselves.
    open: Vec<TypeId>,
}

/// Fields of a message that is being made.
struct Draft {
    message: Message,
    /// The type whose members they are.
    of: Option<ScopedName>,
    /// IDL name of each field, by its ROS name.
    names: BTreeMap<String, String>,
    enums: BTreeSet<TypeId>,
}

impl Draft {
    fn new(name: TypeName, of: Option<&ScopedName>) -> Self {
        let mut message = Message::new(name);
        message.comment = of.map(ToString::to_string);
        Self { message, of: of.cloned(), names: BTreeMap::new(), enums: BTreeSet::new() }
    }

    fn at(&self, member: &str) -> Place {
        match &self.of {
            Some(of) => Place::Member(of.clone(), member.to_owned()),
            None => Place::Nameless,
        }
    }
}

impl<'a> Mapper<'a> {
    /// A mapper for the types of a table. `masquerades` is keyed by the full IDL name of a type or
    /// service.
    #[must_use]
    pub fn new(table: &'a TypeTable, masquerades: BTreeMap<String, TypeName>) -> Self {
        Self { table, masquerades, made: BTreeMap::new(), open: Vec::new() }
    }

    /// The messages, services and actions that are needed, sorted by name, without those of ROS
    /// itself.
    #[must_use]
    pub fn finish(self) -> Vec<Interface> {
        self.made.into_values().map(|(_, interface)| interface).collect()
    }

    /// The message of a port.
    ///
    /// # Errors
    /// The type, or one within it, has no equivalent in ROS.
    pub fn port(&mut self, ty: TypeId) -> Result<TypeName, MapError> {
        if let Some(foreign) = self.foreign(ty) {
            return Ok(foreign);
        }
        let name = names::message(self.table, ty);
        if name.package != "std_msgs" {
            self.need(&name, ty, &Place::Nameless)?;
        }
        Ok(name)
    }

    /// The fields of a type, as a message of this name. Also for a type that masquerades as
    /// another.
    ///
    /// # Errors
    /// The type, or one within it, has no equivalent in ROS.
    pub fn fields(&mut self, name: &TypeName, ty: TypeId) -> Result<Message, MapError> {
        self.open.push(self.table.resolve(ty));
        let message = self.message(name, ty);
        self.open.pop();
        message
    }

    /// A service of this name. Its request has the members of `input`. Its response starts with the
    /// exception that ended it, if any, followed by the members of `output`.
    ///
    /// # Errors
    /// A parameter has no equivalent in ROS.
    pub fn service(
        &mut self,
        name: &TypeName,
        input: TypeId,
        output: TypeId,
    ) -> Result<(), MapError> {
        let request = self.fields(&name.part("_Request"), input)?;
        let response = self.response(&name.part("_Response"), output)?;
        let service = Service { name: name.clone(), request, response };
        self.add(name, Some(input), Interface::Service(service), &Place::Nameless)
    }

    /// An action of this name. Its result has the form of a service's response; its feedback is the
    /// state of the activity.
    ///
    /// # Errors
    /// A parameter has no equivalent in ROS.
    pub fn action(
        &mut self,
        name: &TypeName,
        input: TypeId,
        output: TypeId,
    ) -> Result<(), MapError> {
        let goal = self.fields(&name.part("_Goal"), input)?;
        let result = self.response(&name.part("_Result"), output)?;
        let feedback = Self::feedback(name);
        let action = Action { name: name.clone(), goal, result, feedback };
        self.add(name, Some(input), Interface::Action(action), &Place::Nameless)
    }

    /// The feedback of an action of this name: the state of the activity.
    #[must_use]
    pub fn feedback(name: &TypeName) -> Message {
        let mut feedback = Message::new(name.part("_Feedback"));
        feedback.fields.push(Field::one("genom_state", Base::String(None)));
        feedback
    }

    /// A response or result of this name: the exception, if any, and the members of `output`.
    ///
    /// # Errors
    /// A parameter has no equivalent in ROS.
    pub fn response(&mut self, name: &TypeName, output: TypeId) -> Result<Message, MapError> {
        let of = self.table.resolved(output).name().cloned();
        let mut draft = Draft::new(name.clone(), of.as_ref());
        for text in ["genom_exception", "genom_detail"] {
            draft.message.fields.push(Field::one(text, Base::String(None)));
            draft.names.insert(text.to_owned(), text.to_owned());
        }
        self.members(&mut draft, output)?;
        Ok(draft.message)
    }

    fn foreign(&self, ty: TypeId) -> Option<TypeName> {
        names::masqueraded(self.table, ty, &self.masquerades).cloned()
    }

    fn add(
        &mut self,
        name: &TypeName,
        ty: Option<TypeId>,
        interface: Interface,
        at: &Place,
    ) -> Result<(), MapError> {
        let legal = name.name.starts_with(|c: char| c.is_ascii_uppercase())
            && name.name.chars().all(|c| c.is_ascii_alphanumeric());
        let problem = if !legal || name.package.is_empty() {
            Problem::TypeName(name.clone())
        } else if name.to_dds("_FeedbackMessage").len() > LONGEST {
            Problem::TooLong(name.clone(), LONGEST)
        } else {
            self.made.insert(name.clone(), (ty, interface));
            return Ok(());
        };
        Err(MapError { place: at.clone(), problem: Box::new(problem) })
    }

    /// Makes the message of a type unless it exists.
    fn need(&mut self, name: &TypeName, ty: TypeId, from: &Place) -> Result<(), MapError> {
        let ty = self.table.resolve(ty);
        let at =
            self.table.kind(ty).name().map_or_else(|| from.clone(), |n| Place::Type(n.clone()));
        if let Some((other, _)) = self.made.get(name) {
            return match other {
                Some(other) if *other != ty && !self.table.equal(*other, ty) => {
                    let other = self.table.spelling(*other);
                    let problem = Box::new(Problem::TypeClash(name.clone(), other));
                    Err(MapError { place: at, problem })
                }
                _ => Ok(()),
            };
        }
        if self.open.contains(&ty) {
            return Err(MapError { place: at, problem: Box::new(Problem::Recursive) });
        }
        let message = self.fields(name, ty).map_err(|mut error| {
            if error.place == Place::Nameless {
                error.place = at.clone();
            }
            error
        })?;
        self.add(name, Some(ty), Interface::Message(message), &at)
    }

    fn message(&mut self, name: &TypeName, ty: TypeId) -> Result<Message, MapError> {
        let of = self.table.resolved(ty).name().or_else(|| self.table.kind(ty).name()).cloned();
        let mut draft = Draft::new(name.clone(), of.as_ref());
        match self.table.resolved(ty) {
            Kind::Struct { .. } | Kind::Exception { .. } => self.members(&mut draft, ty)?,
            Kind::Union { discriminant, members, .. } => {
                self.field(&mut draft, DISCRIMINANT, *discriminant)?;
                for member in members {
                    self.field(&mut draft, &member.name, member.ty)?;
                    self.wrap_last(&mut draft, member.ty)?;
                }
            }
            _ => self.field(&mut draft, "data", ty)?,
        }
        Ok(draft.message)
    }

    fn members(&mut self, draft: &mut Draft, ty: TypeId) -> Result<(), MapError> {
        let table = self.table;
        table.members(ty).iter().try_for_each(|Member { name, ty }| self.field(draft, name, *ty))
    }

    /// Turns the last field from a single value into a sequence of at most one.
    fn wrap_last(&mut self, draft: &mut Draft, ty: TypeId) -> Result<(), MapError> {
        let Some(field) = draft.message.fields.pop() else { return Ok(()) };
        let place = draft.at(&field.name);
        let (base, shape) = match field.shape {
            Shape::One => (field.base, Shape::Sequence(Some(1))),
            _ => (self.wrapped(&draft.message.name, ty, &place)?, Shape::Sequence(Some(1))),
        };
        draft.message.fields.push(Field { base, shape, ..field });
        Ok(())
    }

    fn field(&mut self, draft: &mut Draft, idl: &str, ty: TypeId) -> Result<(), MapError> {
        let place = draft.at(idl);
        let wrong = |problem| MapError { place: place.clone(), problem: Box::new(problem) };
        let name = legal_member(idl).ok_or_else(|| wrong(Problem::Member(idl.to_owned())))?;
        if let Some(other) = draft.names.insert(name.clone(), idl.to_owned()) {
            return Err(wrong(Problem::MemberClash(name, other)));
        }
        let (base, shape) = self.what(&draft.message.name, ty, &place)?;
        self.enumerators(draft, ty);
        let comment = (name != idl).then(|| format!("IDL: {idl}"));
        draft.message.fields.push(Field { name, base, shape, comment });
        Ok(())
    }

    /// The type and shape of a field; `within` is the message whose package gets messages for
    /// unnamed types.
    fn what(
        &mut self,
        within: &TypeName,
        ty: TypeId,
        place: &Place,
    ) -> Result<(Base, Shape), MapError> {
        let wrong = |problem| Err(MapError { place: place.clone(), problem: Box::new(problem) });
        if let Some(foreign) = self.foreign(ty) {
            return Ok((Base::Message(foreign), Shape::One));
        }
        let one = |base| Ok((base, Shape::One));
        match self.table.resolved(ty).clone() {
            Kind::Boolean => one(Base::Bool),
            Kind::Char => one(Base::Int8),
            Kind::Octet => one(Base::UInt8),
            Kind::Short => one(Base::Int16),
            Kind::UnsignedShort => one(Base::UInt16),
            Kind::Long => one(Base::Int32),
            Kind::UnsignedLong | Kind::Enum { .. } => one(Base::UInt32),
            Kind::LongLong => one(Base::Int64),
            Kind::UnsignedLongLong => one(Base::UInt64),
            Kind::Float => one(Base::Float32),
            Kind::Double => one(Base::Float64),
            Kind::String { bound: None } => one(Base::String(None)),
            Kind::String { bound: Some(bound @ 2..) } => one(Base::String(Some(bound - 1))),
            Kind::String { bound: Some(_) } => wrong(Problem::EmptyString),
            Kind::Array { length: 0, .. } => wrong(Problem::EmptyArray),
            Kind::Array { element, length } => match self.what(within, element, place)? {
                (base, Shape::One) => Ok((base, Shape::Array(length))),
                // Row-major.
                (base, Shape::Array(inner)) => {
                    Ok((base, Shape::Array(length.saturating_mul(inner))))
                }
                _ => Ok((self.wrapped(within, element, place)?, Shape::Array(length))),
            },
            Kind::Sequence { element, bound } => {
                Ok((self.element(within, element, place)?, Shape::Sequence(bound)))
            }
            Kind::Optional { element } => {
                Ok((self.element(within, element, place)?, Shape::Sequence(Some(1))))
            }
            Kind::Struct { members, .. } | Kind::Exception { members, .. }
                if members.is_empty() =>
            {
                wrong(Problem::EmptyStruct)
            }
            Kind::Struct { .. } | Kind::Union { .. } | Kind::Exception { .. } => {
                let name = names::message(self.table, ty);
                self.need(&name, ty, place)?;
                one(Base::Message(name))
            }
            Kind::Native { .. } => wrong(Problem::Native),
            Kind::Any | Kind::Forward { .. } | Kind::Typedef { .. } => wrong(Problem::Incomplete),
        }
    }

    fn element(
        &mut self,
        within: &TypeName,
        element: TypeId,
        place: &Place,
    ) -> Result<Base, MapError> {
        match self.what(within, element, place)? {
            (base, Shape::One) => Ok(base),
            _ => self.wrapped(within, element, place),
        }
    }

    /// A message with a single member of this type.
    fn wrapped(&mut self, within: &TypeName, ty: TypeId, place: &Place) -> Result<Base, MapError> {
        let name = match self.table.kind(ty).name() {
            Some(_) => names::message(self.table, ty),
            None => TypeName::new(
                &within.package,
                "msg",
                &camel([self.table.c_name(ty).replace(['[', ']'], "_").as_str()]),
            ),
        };
        self.need(&name, ty, place)?;
        Ok(Base::Message(name))
    }

    /// Adds constants for the enumerators of a type, or of the elements of an array or sequence.
    fn enumerators(&mut self, draft: &mut Draft, ty: TypeId) {
        let ty = self.table.resolve(ty);
        match self.table.kind(ty) {
            Kind::Array { element, .. }
            | Kind::Sequence { element, .. }
            | Kind::Optional { element } => self.enumerators(draft, *element),
            Kind::Enum { name, enumerators } if draft.enums.insert(ty) => {
                let taken = |prefix: &str| {
                    let prefix = format!("{prefix}_");
                    draft.message.constants.iter().any(|c| c.name.starts_with(&prefix))
                };
                let short = constant(name.last());
                let prefix = if taken(&short) { constant(&name.to_c()) } else { short };
                for (rank, enumerator) in enumerators.iter().enumerate() {
                    draft.message.constants.push(Constant {
                        name: format!("{prefix}_{}", constant(enumerator)),
                        base: Base::UInt32,
                        value: rank.to_string(),
                    });
                }
            }
            _ => {}
        }
    }
}

/// Spells `idle` as `IDLE`.
fn constant(name: &str) -> String {
    snake(name).to_ascii_uppercase()
}

/// The name as ROS requires it: lower-case letters, digits, single underscores.
fn legal_member(idl: &str) -> Option<String> {
    let legal = |name: &str| {
        name.starts_with(|c: char| c.is_ascii_lowercase())
            && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
            && !name.ends_with('_')
            && !name.contains("__")
    };
    if legal(idl) {
        return Some(idl.to_owned());
    }
    Some(snake(idl)).filter(|name| legal(name))
}
