//! Makes what a component needs of its types, and collects what cannot be made.

use genom_description::model::{Span, Specification};
use genom_types::{DataType, TypeId};

use super::error::LoadError;

/// Records errors while types are laid out.
pub(super) struct Checker<'a> {
    pub(super) specification: &'a Specification,
    pub(super) locate: &'a dyn Fn(Span) -> String,
    pub(super) errors: Vec<LoadError>,
}

impl Checker<'_> {
    /// Lays out a type; records an error if that fails.
    pub(super) fn lay_out(&mut self, ty: TypeId, what: &str, span: Span) -> Option<DataType> {
        self.made(DataType::new(&self.specification.types, ty), what, span)
    }

    /// What was made for a part of the description; records an error if that failed.
    pub(super) fn made<T>(
        &mut self,
        made: Result<T, impl ToString>,
        what: &str,
        span: Span,
    ) -> Option<T> {
        match made {
            Ok(made) => Some(made),
            Err(why) => {
                let (what, place, why) = (what.to_owned(), (self.locate)(span), why.to_string());
                self.errors.push(LoadError::Type { what, place, why });
                None
            }
        }
    }
}
