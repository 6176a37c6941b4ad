//! Parts of a component that have nothing to do with each other, as far as ticks are concerned.

use crate::codels::small;
use crate::services::Work;
use crate::system::System;

impl System {
    /// The component, once for each group of tasks that may delay each other: with the services of
    /// that group as its only clients, and with the other tasks idle once requests are served. What
    /// the tasks of a group do, and when, is the same as in the whole component: their nodes, and
    /// those of these services, conflict with no others; and no other service interrupts, orders or
    /// is what these are about.
    ///
    /// A task without period looks at the end of each request and activity, whatever it is about:
    /// what is in a group with one is not taken apart.
    pub(crate) fn apart(&self) -> Vec<(Vec<u16>, Self)> {
        let groups = Groups::new(self);
        let tasks = small(self.periods.len());
        let woken =
            (0..tasks).filter(|task| self.is_aperiodic(*task) && groups.matters(self, *task));
        let whole = (0..tasks).filter(|task| !self.is_aperiodic(*task));
        if woken.count() > 0 {
            let mut part = self.clone();
            part.leave_out_twins();
            return vec![(whole.collect(), part)];
        }
        let mut done: Vec<u16> = Vec::new();
        let mut parts = Vec::new();
        for task in whole {
            let group = groups.of(task);
            if done.contains(&group) {
                continue;
            }
            done.push(group);
            let own = |context: u16| groups.of(context) == group;
            let mut part = self.clone();
            for (looked_at, task) in part.looked_at.iter_mut().zip(0..) {
                *looked_at = own(task);
            }
            for (client, service) in part.clients.iter_mut().zip(0u16..) {
                let builtin = self.services[usize::from(service)].builtin.is_some();
                *client &= builtin || own(tasks + service);
            }
            part.leave_out_twins();
            let tasks = (0..tasks).filter(|task| own(*task) && !self.is_aperiodic(*task));
            parts.push((tasks.collect(), part));
        }
        parts
    }

    /// Of services without activity that do the same, as many stay as are served at a time.
    fn leave_out_twins(&mut self) {
        for service in 0..small(self.services.len()) {
            let before = 0..service;
            let twins = before.filter(|other| {
                self.clients[usize::from(*other)] && self.are_twins(*other, service)
            });
            if twins.count() >= self.bounds.requests {
                self.clients[usize::from(service)] = false;
            }
        }
    }

    /// Whether two services differ in nothing that ticks depend on: neither has an activity or a
    /// codel of its own, or a place in an order, and what they transfer conflicts with the same.
    fn are_twins(&self, a: u16, b: u16) -> bool {
        let (one, other) = (&self.services[usize::from(a)], &self.services[usize::from(b)]);
        let plain = |service: &crate::services::Service| {
            service.machine.is_none()
                && !service.ordered
                && service.builtin.is_none()
                && service.after.is_empty()
                && service.before.is_empty()
        };
        let alike = |(a, b): (&Work, &Work)| match (a, b) {
            (Work::Transfer(a), Work::Transfer(b)) => {
                let mut nodes = 0..small(self.plan.nodes().len());
                nodes.all(|node| {
                    let same = self.conflicts.between(*a, node) == self.conflicts.between(*b, node);
                    same || node == *a || node == *b
                })
            }
            _ => false,
        };
        plain(one)
            && plain(other)
            && one.interrupts == other.interrupts
            && one.work.len() == other.work.len()
            && one.work.iter().zip(&other.work).all(alike)
    }
}

/// Contexts that may have to do with each other.
struct Groups {
    /// For each context, one of its group; itself, or one with a lower number.
    of: Vec<u16>,
}

impl Groups {
    fn new(system: &System) -> Self {
        let tasks = small(system.periods.len());
        let contexts = tasks + small(system.services.len());
        let mut groups = Self { of: (0..contexts).collect() };
        let mut nodes: Vec<(u16, u16)> = Vec::new();
        for machine in &system.machines {
            let own = machine.codels.iter().flatten().chain(&machine.fetch);
            nodes.extend(own.map(|node| (machine.task, *node)));
            if let Some(service) = machine.service {
                groups.join(machine.task, tasks + service);
            }
        }
        for (service, at) in system.services.iter().zip(0u16..) {
            nodes.extend(service.work.iter().filter_map(|work| match work {
                Work::Codel(node) | Work::Transfer(node) => Some((tasks + at, *node)),
                Work::Abort => None,
            }));
            for other in service.before.iter().chain(&service.after) {
                groups.join(tasks + at, tasks + other);
            }
            for (other, facts) in (0u16..).zip(&system.services) {
                if service.interrupts[usize::from(other)] && facts.machine.is_some() {
                    groups.join(tasks + at, tasks + other);
                }
            }
        }
        for (at, (context, node)) in nodes.iter().enumerate() {
            for (other, conflicting) in &nodes[at + 1..] {
                if system.conflicts.between(*node, *conflicting) {
                    groups.join(*context, *other);
                }
            }
        }
        groups
    }

    fn of(&self, context: u16) -> u16 {
        let mut at = context;
        while self.of[usize::from(at)] != at {
            at = self.of[usize::from(at)];
        }
        at
    }

    fn join(&mut self, a: u16, b: u16) {
        let (a, b) = (self.of(a), self.of(b));
        self.of[usize::from(a.max(b))] = a.min(b);
    }

    /// Whether a task with a period is in the group of this one.
    fn matters(&self, system: &System, task: u16) -> bool {
        let others = 0..small(system.periods.len());
        let mut periodic = others.filter(|other| !system.is_aperiodic(*other));
        periodic.any(|other| self.of(other) == self.of(task))
    }
}
