//! Types of one component and paths to its data, resolved once at load.

use genom_description::model::{Dialect, Service};
use genom_types::{CompiledPath, DataType, PathError, PathStep};

use super::checker::Checker;
use super::copies::{Copies, Place, ranked};

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
    pub(super) copies: Copies<Copy>,
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
        let kept = ranked(service).map(|(_, from, to)| match (from, to) {
            (_, Some(rank)) => Kept::Output(rank),
            (rank, None) => Kept::Input(rank.unwrap_or_default()),
        });
        let path = |place: &Place<'_, DataType>| match place {
            Place::Input(rank) => CompiledPath::new(&input, &[PathStep::Member(*rank)]),
            Place::Output(rank) => CompiledPath::new(&output, &[PathStep::Member(*rank)]),
            Place::Ids(ids, steps) => CompiledPath::new(ids, steps),
        };
        let copies = Copies::new(checker, service, ids, dialect, |from, to| {
            Ok::<_, PathError>(Copy { from: path(from)?, to: path(to)? })
        });
        Some(Self { kept: kept.collect(), input, output, local, copies })
    }
}
