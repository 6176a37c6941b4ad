//! Whether an IDL type or service may go under the name of a foreign one.

use std::collections::BTreeMap;

use genom_types::{Kind, TypeId, TypeTable};

use crate::interface::{Base, Field, Interface, Message, Shape};
use crate::library::{Library, LibraryError};
use crate::map::{MapError, Mapper};
use crate::names::TypeName;
use crate::structure::{Difference, compare};

/// It may not.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MasqueradeError {
    /// It has no equivalent in ROS at all.
    #[error(transparent)]
    Map(#[from] MapError),
    /// The foreign type is not known.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// Both are known and differ.
    #[error(transparent)]
    Differs(#[from] Box<Difference>),
    /// A message where a service is needed, or the like.
    #[error("{ours} cannot go as {theirs}: it needs {needed}")]
    Kind {
        /// Ours.
        ours: String,
        /// The foreign type.
        theirs: TypeName,
        /// `package/srv/Type`
        needed: &'static str,
    },
}

/// How the response of a masqueraded service or action says that an exception ended it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The output has `boolean success` and `string message`, at these ranks.
    Members(usize, usize),
    /// There is no output, and the response is just `success` and `message`.
    Added,
    /// It cannot.
    Silent,
}

/// How a masqueraded service or action is put on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Manner {
    /// How exceptions are shown.
    pub failure: Failure,
    /// Whether the feedback of the action is one string, which tells the state.
    pub states: bool,
}

/// A type and the table it is in.
pub type Typed<'a> = (&'a TypeTable, TypeId);

/// What is compared, and with what it is found.
pub struct Ours<'a> {
    /// All masquerades, by full IDL name.
    pub masquerades: &'a BTreeMap<String, TypeName>,
    /// The foreign types.
    pub library: &'a Library,
}

impl Ours<'_> {
    /// Whether a type may go as a message.
    ///
    /// # Errors
    /// Their structures differ, or the message is not known.
    pub fn message(&self, ty: Typed<'_>, foreign: &TypeName) -> Result<(), MasqueradeError> {
        let ours = ty.0.spelling(ty.1);
        match self.library.find(foreign)? {
            Interface::Message(theirs) => self.part(&ours, ty, &theirs),
            _ => self.refused(ours, foreign, "a package/msg/Type"),
        }
    }

    /// Whether a service may go as a service of ROS.
    ///
    /// # Errors
    /// Their structures differ, or the service is not known.
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

    /// Whether an activity may go as an action of ROS. Its feedback may be any: only a single
    /// string can tell the state.
    ///
    /// # Errors
    /// Their structures differ, or the action is not known.
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
            // The members of the output are the fields, unless a struct is flattened.
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
        // The type itself is looked at as it is, what is inside as what it goes as.
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
