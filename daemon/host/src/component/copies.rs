//! Which values of a service are copied when: between its inputs, its outputs and the IDS.

use genom_description::model::{self, Dialect, Direction, Parameter, Service};
use genom_types::PathStep;

use super::checker::Checker;

/// A place that a parameter has. `T` is the type of the IDS, in the language of the codels.
pub(super) enum Place<'a, T> {
    /// In the inputs, the member with this index.
    Input(usize),
    /// The same in the outputs.
    Output(usize),
    Ids(&'a T, Vec<PathStep>),
}

/// The copies of a service. `C` is a value to copy from one place to another.
#[derive(Debug)]
pub(super) struct Copies<C> {
    /// From the inputs to the outputs, at the start.
    pub(super) inout: Vec<C>,
    /// From the inputs to the IDS.
    pub(super) store: Vec<C>,
    /// From the outputs to the IDS: values set by a validate codel in the papers' dialects.
    pub(super) store_validated: Vec<C>,
    /// From the IDS to the outputs.
    pub(super) fetch: Vec<C>,
    /// From the IDS to the inputs: the current values of an attribute.
    pub(super) current: Vec<C>,
}

impl<C> Copies<C> {
    /// The copies of `service`, of which `copy` makes each. Records errors.
    pub(super) fn new<'a, T, E: ToString>(
        checker: &mut Checker<'_>,
        service: &Service,
        ids: Option<&'a T>,
        dialect: Dialect,
        copy: impl Fn(&Place<'a, T>, &Place<'a, T>) -> Result<C, E>,
    ) -> Self {
        let mut copies = Self {
            inout: Vec::new(),
            store: Vec::new(),
            store_validated: Vec::new(),
            fetch: Vec::new(),
            current: Vec::new(),
        };
        for (parameter, from, to) in ranked(service) {
            let (from, to) = (from.map(Place::Input), to.map(Place::Output));
            let target = ids.zip(parameter.target.as_ref());
            let place = target.map(|(ids, target)| Place::Ids(ids, steps(&target.path)));
            let added = copies.add([from.as_ref(), to.as_ref(), place.as_ref()], dialect, &copy);
            let what = format!("parameter `{}` of `{}`", parameter.name, service.name);
            checker.made(added, &what, parameter.span);
        }
        copies
    }

    /// Adds the copies of a parameter.
    fn add<'a, T, E>(
        &mut self,
        [input, output, ids]: [Option<&Place<'a, T>>; 3],
        dialect: Dialect,
        copy: impl Fn(&Place<'a, T>, &Place<'a, T>) -> Result<C, E>,
    ) -> Result<(), E> {
        if let (Some(from), Some(to)) = (input, output) {
            self.inout.push(copy(from, to)?);
        }
        let Some(ids) = ids else { return Ok(()) };
        if let Some(input) = input {
            self.current.push(copy(ids, input)?);
        }
        match (input, output) {
            // dialects.md B: the validate codel gets the new value, which is then stored.
            (Some(_), Some(output)) if dialect != Dialect::Current => {
                self.store_validated.push(copy(output, ids)?);
            }
            // genom3.md 7.3.6: the IDS get the value of the request, also for `inout`.
            (Some(input), _) => self.store.push(copy(input, ids)?),
            (None, _) => {}
        }
        if let Some(output) = output {
            self.fetch.push(copy(ids, output)?);
        }
        Ok(())
    }
}

/// The parameters of a service, each with its index among the inputs and among the outputs.
pub(super) fn ranked(
    service: &Service,
) -> impl Iterator<Item = (&Parameter, Option<usize>, Option<usize>)> {
    let (mut inputs, mut outputs) = (0.., 0..);
    service.parameters.iter().map(move |parameter| {
        let from = (parameter.direction != Direction::Out).then(|| inputs.next()).flatten();
        let to = (parameter.direction != Direction::In).then(|| outputs.next()).flatten();
        (parameter, from, to)
    })
}

/// Converts the steps of the model to those of the types.
pub(super) fn steps(path: &[model::PathStep]) -> Vec<PathStep> {
    let step = |step: &model::PathStep| match *step {
        model::PathStep::Member(index) => PathStep::Member(index),
        model::PathStep::Index(index) => PathStep::Index(index),
    };
    path.iter().map(step).collect()
}
