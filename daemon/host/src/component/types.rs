//! Types of one component and paths to its data, resolved once at load.

use genom_description::model::{self, Dialect, Direction, Parameter, Service, Span, Specification};
use genom_types::{CompiledPath, DataType, PathError, PathStep, TypeId};

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
        match DataType::new(&self.specification.types, ty) {
            Ok(ty) => Some(ty),
            Err(why) => {
                let place = (self.locate)(span);
                let (what, why) = (what.to_owned(), why.to_string());
                self.errors.push(LoadError::Type { what, place, why });
                None
            }
        }
    }
}

/// The record that holds a parameter of a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kept {
    /// The input record, in the member with this index.
    Input(usize),
    /// The output record, also for `inout` parameters (genom3.md 7.3.4).
    Output(usize),
}

/// Records of a service, and the copies between them and the IDS.
#[derive(Debug)]
pub(super) struct ServiceTypes {
    pub(super) input: DataType,
    pub(super) output: DataType,
    pub(super) local: DataType,
    /// The record that codels use for each parameter.
    pub(super) kept: Vec<Kept>,
    /// From the inputs to the outputs, at the start.
    pub(super) inout: Vec<Copy>,
    /// From the inputs to the IDS.
    pub(super) store: Vec<Copy>,
    /// From the outputs to the IDS: values set by a validate codel in the papers' dialects.
    pub(super) store_validated: Vec<Copy>,
    /// From the IDS to the outputs.
    pub(super) fetch: Vec<Copy>,
    /// From the IDS to the inputs: the current values of an attribute.
    pub(super) current: Vec<Copy>,
}

/// A value to copy from one record to another.
#[derive(Debug)]
pub(super) struct Copy {
    pub(super) from: CompiledPath,
    pub(super) to: CompiledPath,
}

impl ServiceTypes {
    /// The records of `service`.
    pub(super) fn new(
        checker: &mut Checker<'_>,
        service: &Service,
        ids: Option<&DataType>,
        dialect: Dialect,
    ) -> Option<Self> {
        let what = |part| format!("{part} of service `{}`", service.name);
        let input = checker.lay_out(service.input, &what("inputs"), service.span);
        let output = checker.lay_out(service.output, &what("outputs"), service.span);
        let local = checker.lay_out(service.local, &what("local variables"), service.span);
        let (input, output, local) = (input?, output?, local?);
        let mut types = Self {
            input,
            output,
            local,
            kept: Vec::new(),
            inout: Vec::new(),
            store: Vec::new(),
            store_validated: Vec::new(),
            fetch: Vec::new(),
            current: Vec::new(),
        };
        let (mut inputs, mut outputs) = (0.., 0..);
        for parameter in &service.parameters {
            let from = (parameter.direction != Direction::Out).then(|| inputs.next()).flatten();
            let to = (parameter.direction != Direction::In).then(|| outputs.next()).flatten();
            if let Err(why) = types.add(parameter, from, to, ids, dialect) {
                let place = (checker.locate)(parameter.span);
                let what = format!("parameter `{}` of `{}`", parameter.name, service.name);
                checker.errors.push(LoadError::Type { what, place, why: why.to_string() });
            }
        }
        Some(types)
    }

    fn add(
        &mut self,
        parameter: &Parameter,
        from: Option<usize>,
        to: Option<usize>,
        ids: Option<&DataType>,
        dialect: Dialect,
    ) -> Result<(), PathError> {
        let member = |root: &DataType, rank| CompiledPath::new(root, &[PathStep::Member(rank)]);
        if let (Some(from), Some(to)) = (from, to) {
            let (from, to) = (member(&self.input, from)?, member(&self.output, to)?);
            self.inout.push(Copy { from, to });
        }
        self.kept.push(match (from, to) {
            (_, Some(rank)) => Kept::Output(rank),
            (rank, None) => Kept::Input(rank.unwrap_or_default()),
        });
        let (Some(target), Some(ids)) = (&parameter.target, ids) else { return Ok(()) };
        let place = CompiledPath::new(ids, &steps(&target.path))?;
        if let Some(rank) = from {
            self.current.push(Copy { from: place.clone(), to: member(&self.input, rank)? });
        }
        match (from, to) {
            // dialects.md B: the validate codel gets the new value, which is then stored.
            (Some(_), Some(rank)) if dialect != Dialect::Current => {
                let from = member(&self.output, rank)?;
                self.store_validated.push(Copy { from, to: place.clone() });
            }
            // genom3.md 7.3.6: the IDS get the value of the request, also for `inout`.
            (Some(rank), _) => {
                self.store.push(Copy { from: member(&self.input, rank)?, to: place.clone() });
            }
            (None, _) => {}
        }
        if let Some(rank) = to {
            self.fetch.push(Copy { from: place, to: member(&self.output, rank)? });
        }
        Ok(())
    }
}

/// Converts the steps of the model to those of the types.
pub(super) fn steps(path: &[model::PathStep]) -> Vec<PathStep> {
    let step = |step: &model::PathStep| match *step {
        model::PathStep::Member(index) => PathStep::Member(index),
        model::PathStep::Index(index) => PathStep::Index(index),
    };
    path.iter().map(step).collect()
}
