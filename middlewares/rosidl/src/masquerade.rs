//! Checks whether an IDL type or service may masquerade as a foreign one.

use std::collections::BTreeMap;

use genom_types::{Kind, TypeId, TypeTable};

use crate::interface::{Base, Field, Interface, Message, Shape};
use crate::library::{Library, LibraryError};
use crate::map::{MapError, Mapper};
use crate::names::TypeName;
use crate::structure::{Difference, compare};

/// The masquerade is not possible.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MasqueradeError {
    /// Our type has no equivalent in ROS at all.
    #[error(transparent)]
    Map(#[from] MapError),
    /// The foreign type is unknown.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// The structures of the two differ.
    #[error(transparent)]
    Differs(#[from] Box<Difference>),
    /// The foreign type has the wrong kind, such as a message instead of a service.
    #[error("{ours} cannot go as {theirs}: it needs {needed}")]
    Kind {
        /// Our name.
        ours: String,
        /// The foreign type.
        theirs: TypeName,
        /// Form of the name that is needed, such as `package/srv/Type`.
        needed: &'static str,
    },
}

/// How the response of a masqueraded service or action reports an exception.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// By output members `boolean success` and `string message`, at these indices.
    Members(usize, usize),
    /// There is no output; the response consists of `success` and `message`.
    Added,
    /// It cannot report exceptions.
    Silent,
}

/// How a masqueraded service or action is encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Manner {
    /// How exceptions are reported.
    pub failure: Failure,
    /// Whether the action's feedback is a single string, which then reports the state.
    pub states: bool,
}

/// A type and the table it is in.
pub type Typed<'a> = (&'a TypeTable, TypeId);

/// Our side of a comparison, and where foreign types are looked up.
pub struct Ours<'a> {
    /// All masquerades, by full IDL name.
    pub masquerades: &'a BTreeMap<String, TypeName>,
    /// Definitions of foreign types.
    pub library: &'a Library,
}

impl Ours<'_> {
    /// Checks whether a type may masquerade as a message.
    ///
    /// # Errors
    /// Their structures differ, or the message is unknown.
    pub fn message(&self, ty: Typed<'_>, foreign: &TypeName) -> Result<(), MasqueradeError> {
        let ours = ty.0.spelling(ty.1);
        match self.library.find(foreign)? {
            Interface::Message(theirs) => self.part(&ours, ty, &theirs),
            _ => self.refused(ours, foreign, "a package/msg/Type"),
        }
    }

    /// Checks whether a service may masquerade as a ROS service.
    ///
    /// # Errors
    /// Their structures differ, or the service is unknown.
    pub fn service(
        &self,
        name: &str,
        (input, output): (Typed<'_>, Typed<'_>),
        foreign: &TypeName,
    ) -> Result<Manner, MasqueradeError> {
        let Interface::Service(theirs) = self.library.find(foreign)? else {
            return self.refused(name.to_owned(), foreign, "a package/srv/Type");
        };
        self.part(&format!("the request of {name}"), input, &theirs.request)?;
        let failure =
            self.response(&format!("the response of {name}"), output, &theirs.response)?;
        Ok(Manner { failure, states: false })
    }

    /// Checks whether an activity may masquerade as a ROS action. The type of its feedback is
    /// arbitrary, but only a single string can report the state.
    ///
    /// # Errors
    /// Their structures differ, or the action is unknown.
    pub fn action(
        &self,
        name: &str,
        (input, output): (Typed<'_>, Typed<'_>),
        foreign: &TypeName,
    ) -> Result<Manner, MasqueradeError> {
        let Interface::Action(theirs) = self.library.find(foreign)? else {
            return self.refused(name.to_owned(), foreign, "a package/action/Type");
        };
        self.part(&format!("the goal of {name}"), input, &theirs.goal)?;
        let failure = self.response(&format!("the result of {name}"), output, &theirs.result)?;
        let states = matches!(
            &theirs.feedback.fields[..],
            [Field { base: Base::String(None), shape: Shape::One, .. }]
        );
        Ok(Manner { failure, states })
    }

    fn refused<T>(
        &self,
        ours: String,
        theirs: &TypeName,
        needed: &'static str,
    ) -> Result<T, MasqueradeError> {
        Err(MasqueradeError::Kind { ours, theirs: theirs.clone(), needed })
    }

    fn response(
        &self,
        name: &str,
        output: Typed<'_>,
        theirs: &Message,
    ) -> Result<Failure, MasqueradeError> {
        let rank = |name: &str, base: &Base| {
            let is = |field: &Field| {
                let bases = matches!(
                    (&field.base, base),
                    (Base::Bool, Base::Bool) | (Base::String(_), Base::String(_))
                );
                field.name == name && field.shape == Shape::One && bases
            };
            theirs.fields.iter().position(is)
        };
        let both = (rank("success", &Base::Bool), rank("message", &Base::String(None)));
        let members = output.0.members(output.1).len();
        if members == 0 && both == (Some(0), Some(1)) && theirs.fields.len() == 2 {
            return Ok(Failure::Added);
        }
        self.part(name, output, theirs)?;
        Ok(match both {
            // The output's members match the fields one to one unless a struct is flattened.
            (Some(success), Some(message)) if members == theirs.fields.len() => {
                Failure::Members(success, message)
            }
            _ => Failure::Silent,
        })
    }

    fn part(
        &self,
        name: &str,
        (table, ty): Typed<'_>,
        theirs: &Message,
    ) -> Result<(), MasqueradeError> {
        // Compare the type itself by its own structure, and the types within it as what they
        // masquerade as.
        let mut masquerades = self.masquerades.clone();
        let mut itself = ty;
        for _ in 0..=table.len() {
            let kind = table.kind(itself);
            kind.name().map(|name| masquerades.remove(&name.to_string()));
            let Kind::Typedef { target, .. } = kind else { break };
            itself = *target;
        }
        let mut mapper = Mapper::new(table, masquerades);
        let ours = mapper.fields(&TypeName::new("ours", "msg", "Ours"), ty)?;
        let made = mapper.finish();
        let foreign = |name: &TypeName| self.library.message(name).ok();
        let own = |name: &TypeName| {
            let found = made.iter().find_map(|interface| match interface {
                Interface::Message(message) if message.name == *name => Some(message.clone()),
                _ => None,
            });
            found.or_else(|| foreign(name))
        };
        Ok(compare(name, (&ours, &own), (theirs, &foreign))?)
    }
}
