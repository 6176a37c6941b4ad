//! Paths into the IDS and other values, as attributes and codels write them (genom3.md 4.4).

use genom_types::{Kind, TypeId};

use super::Checker;
use super::state::{BodyId, Parameter, Target};
use crate::diagnostic::Diagnostic;
use crate::model::{Direction, PathStep, Span};
use crate::syntax::{self, Name, Variable, VariableParameter, VariableStep};

impl Checker {
    /// Path from the IDS to a variable; `None` for the whole IDS.
    // genom3.md 3.7 K14.
    pub(super) fn ids_path(
        &mut self,
        id: BodyId,
        variable: Option<&Variable>,
        span: Span,
    ) -> Option<(Vec<PathStep>, TypeId)> {
        let Some(ids) = self.bodies[id].ids else {
            let lost = variable.is_some_and(|v| self.lost.contains(&v.root.text));
            if !lost && !self.lost.contains("ids") {
                let what = if self.bodies[id].interface { "interface" } else { "component" };
                let message = format!("{what} `{}` has no ids", self.bodies[id].name);
                self.push(
                    Diagnostic::error("E0714", span, message)
                        .help("declare `ids { ... };` before this"),
                );
            }
            return None;
        };
        let mut path = Vec::new();
        let Some(variable) = variable else { return Some((path, ids)) };
        let ty = self.step_member(ids, &variable.root, &mut path)?;
        let ty = self.walk(ty, &variable.steps, &mut path)?;
        Some((path, ty))
    }

    /// Follows steps from a value of type `ty`.
    // genom3.md 3.7 K15 to K17.
    pub(super) fn walk(
        &mut self,
        mut ty: TypeId,
        steps: &[VariableStep],
        path: &mut Vec<PathStep>,
    ) -> Option<TypeId> {
        for step in steps {
            let walked = self.walked(ty);
            if self.is_error(walked) {
                return None;
            }
            ty = match step {
                VariableStep::Member(name) => self.step_member(walked, name, path)?,
                VariableStep::Index(expression) => {
                    let index = self.positive_u32(expression)?;
                    let (element, bound) = match self.types.kind(walked) {
                        Kind::Array { element, length } => (*element, Some(*length)),
                        Kind::Sequence { element, bound } => (*element, *bound),
                        _ => {
                            let message = format!("{} has no elements", self.type_name(walked));
                            self.push(Diagnostic::error("E0716", expression.span, message));
                            return None;
                        }
                    };
                    if bound.is_some_and(|bound| index >= bound) {
                        let message = format!(
                            "element {index} is out of bounds in {}",
                            self.type_name(walked)
                        );
                        self.push(Diagnostic::error("E0717", expression.span, message));
                    }
                    path.push(PathStep::Index(index));
                    element
                }
            };
        }
        Some(ty)
    }

    fn step_member(&mut self, ty: TypeId, name: &Name, path: &mut Vec<PathStep>) -> Option<TypeId> {
        if let Some((rank, member)) = self.member(ty, &name.text) {
            path.push(PathStep::Member(rank));
            return Some(member);
        }
        if !self.lost.contains(&name.text) && !self.is_error(ty) {
            let message = format!("unknown member `{}` in {}", name.text, self.type_name(ty));
            let help = self.suggest(&name.text, |this| this.member_names(ty));
            let mut error = Diagnostic::error("E0715", name.span, message);
            error.help = help;
            self.push(error);
        }
        None
    }

    /// A parameter that is a member of the IDS.
    pub(super) fn attribute_parameter(
        &mut self,
        id: BodyId,
        dcl: &VariableParameter,
    ) -> Option<Parameter> {
        let name = match (&dcl.rename, &dcl.variable) {
            (Some(name), _) => name,
            (None, Some(variable)) => variable.last(),
            (None, None) => return None,
        };
        let Some((path, ty)) = self.ids_path(id, dcl.variable.as_ref(), dcl.span) else {
            self.lost.insert(name.text.clone());
            return None;
        };
        let default = dcl.initializer.as_ref().and_then(|init| self.initial(init, ty));
        Some(Parameter {
            name: name.text.clone(),
            direction: direction(dcl.direction),
            ty,
            default,
            target: Some(Target { path, variable: dcl.variable.clone() }),
            span: name.span,
        })
    }

    /// Names of the members of the IDS, for suggestions.
    pub(super) fn ids_names(&self, id: BodyId) -> Vec<&str> {
        self.bodies[id].ids.map(|ids| self.member_names(ids)).unwrap_or_default()
    }
}

pub(super) fn direction(syntax: syntax::Direction) -> Direction {
    match syntax {
        syntax::Direction::In => Direction::In,
        syntax::Direction::Out => Direction::Out,
        syntax::Direction::InOut => Direction::InOut,
    }
}
