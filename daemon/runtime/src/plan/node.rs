//! Exclusion nodes and their conflicts: the static part of genom3.md 4.5 and 7.10.

use genom_description::model::{
    CodelIx, CodelKind, Component, Ix as _, Node, Owner, ServiceIx, ServiceKind, Source,
};

use super::conflict::Touching;

/// Exclusion nodes of a component: its codels, then the data transfer of each service.
///
/// The relation is symmetric: if one node excludes another, the other excludes it too.
#[derive(Debug)]
pub struct Nodes {
    codels: usize,
    /// For each node, the nodes that must not run at the same time, including itself, in order.
    conflicts: Vec<Box<[usize]>>,
    /// Whether `exclusively` waits for the node. Async codels may block for long, and are waited
    /// for only if they have a port or remote that could be changed under them.
    global: Vec<bool>,
    /// For each node, the first earlier one that never runs at the same time, because one task or
    /// service runs both, and that has the same conflicts.
    twins: Vec<Option<usize>>,
}

impl Nodes {
    pub(super) fn new(model: &Component) -> Self {
        let codels = model.codels.len();
        let count = codels + model.services.len();
        let mut matrix = vec![vec![false; count]; count];
        for (node, row) in matrix.iter_mut().enumerate() {
            for &other in model.exclusion(node) {
                if let Some(cell) = row.get_mut(other) {
                    *cell = true;
                }
            }
        }
        let touching = |node: usize| match model.node(node) {
            Node::Codel(codel) => Touching::Codel(&model.codels[codel]),
            Node::Transfer(service) => Touching::Transfer(&model.services[service]),
        };
        // Nodes of control run in parallel here, so they can conflict with each other as well.
        let beside = |node: usize| match model.node(node) {
            Node::Codel(codel) => !matches!(model.codels[codel].kind, CodelKind::Fsm { .. }),
            Node::Transfer(_) => true,
        };
        // The exclusion of the model does not cover transfers of activities in the papers'
        // dialects.
        let of_papers = |node: usize| match model.node(node) {
            Node::Codel(_) => false,
            Node::Transfer(service) => {
                let service = &model.services[service];
                service.through_ids && service.kind != ServiceKind::Attribute
            }
        };
        let excluded = |a: usize, b: usize| {
            let ours = (beside(a) && beside(b)) || of_papers(a) || of_papers(b);
            let given = a == b || matrix[a][b] || matrix[b][a];
            given || (ours && touching(a).conflicts(&touching(b)))
        };
        let conflicts: Vec<Box<[usize]>> =
            (0..count).map(|a| (0..count).filter(|b| excluded(a, *b)).collect()).collect();
        let global = |node: usize| {
            model.codel_of_node(node).is_none_or(|codel| {
                !codel.asynchronous
                    || codel
                        .parameters
                        .iter()
                        .any(|p| matches!(p.source, Source::Port(_) | Source::Remote(_)))
            })
        };
        let twins = twins(&conflicts, |node| match model.node(node) {
            Node::Transfer(service) => Some(Owner::Service(service)),
            Node::Codel(codel) => match (&model.codels[codel].kind, model.codels[codel].owner) {
                (CodelKind::Fsm { .. }, Owner::Task(task)) => Some(Owner::Task(task)),
                (CodelKind::Fsm { .. }, Owner::Service(ix)) => {
                    model.services[ix].task.map(Owner::Task)
                }
                (_, Owner::Service(ix)) => Some(Owner::Service(ix)),
                (_, Owner::Task(_)) => None,
            },
        });
        Self { codels, conflicts, global: (0..count).map(global).collect(), twins }
    }

    /// Nodes with a given relation, for tests and benchmarks of the exclusion.
    #[must_use]
    pub fn of_pairs(count: usize, pairs: &[(usize, usize)]) -> Self {
        let conflicts = (0..count)
            .map(|node| {
                let with = |other: &usize| {
                    *other == node
                        || pairs.contains(&(node, *other))
                        || pairs.contains(&(*other, node))
                };
                (0..count).filter(with).collect()
            })
            .collect();
        Self { codels: count, conflicts, global: vec![true; count], twins: vec![None; count] }
    }

    /// Index of the node of a codel.
    #[must_use]
    #[inline]
    pub fn codel(&self, codel: CodelIx) -> usize {
        codel.index()
    }

    /// Index of the node of a service's data transfer.
    #[must_use]
    pub fn transfer(&self, service: ServiceIx) -> usize {
        self.codels + service.index()
    }

    /// An earlier node that never runs at the same time as this one and has the same conflicts.
    #[must_use]
    pub fn twin(&self, node: usize) -> Option<usize> {
        self.twins.get(node).copied().flatten()
    }

    /// Number of nodes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.conflicts.len()
    }

    /// Whether there is no node.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.conflicts.is_empty()
    }

    /// Nodes that must not run at the same time as this one, including itself.
    #[must_use]
    pub fn conflicts(&self, node: usize) -> &[usize] {
        self.conflicts.get(node).map_or(&[], |list| list)
    }

    /// Whether excluding everything waits for this node.
    #[must_use]
    pub fn is_global(&self, node: usize) -> bool {
        self.global.get(node).copied().unwrap_or(true)
    }
}

/// For each node, the first one of the same task or service that has the same conflicts.
fn twins(
    conflicts: &[Box<[usize]>],
    runner: impl Fn(usize) -> Option<Owner>,
) -> Vec<Option<usize>> {
    let others = |node: usize| conflicts[node].iter().filter(move |other| **other != node);
    let same = |a: usize, b: usize| {
        runner(a).is_some() && runner(a) == runner(b) && others(a).eq(others(b))
    };
    (0..conflicts.len()).map(|node| (0..node).find(|before| same(*before, node))).collect()
}
