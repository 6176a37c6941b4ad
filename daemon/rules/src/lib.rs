//! The rules that a component is supervised by: names become indices, before anything runs.

#![forbid(unsafe_code)]

mod beat;
mod error;
mod formula;
mod happening;
mod order;

use std::time::Duration;

use genom_description::model::{
    Codel, CodelIx, CodelKind, Component as Model, Owner, ServiceIx, ServiceKind, StateIx, TaskIx,
};
use genom_nearest::suggest;
use genom_protocol::{Condition, LoadRequest, OwnResponse, SupervisionEntry, Whose};
use genom_runtime::{Beats, Rule, Supervised};

pub use error::NoSuchRule;

/// The rules of a request.
///
/// # Errors
/// The first that does not fit.
pub fn rules(request: &LoadRequest, model: &Model) -> Result<Vec<Supervised>, NoSuchRule> {
    let compiled = request.supervision.iter().enumerate().map(|(at, entry)| {
        let condition = entry.condition().map_err(|error| NoSuchRule::Idle {
            at,
            rule: "supervision".to_owned(),
            why: error.to_string(),
        })?;
        let compiler = Compiler { model, at, text: condition.to_string() };
        let rule = compiler.rule(condition)?;
        compiler.check_reactions(&rule, entry, request)?;
        Ok(Supervised { rule, interrupts: entry.does(OwnResponse::Interrupt) })
    });
    compiled.collect()
}

struct Compiler<'a> {
    model: &'a Model,
    /// Its place in the list.
    at: usize,
    /// The rule in words.
    text: String,
}

impl Compiler<'_> {
    fn rule(&self, condition: Condition) -> Result<Rule, NoSuchRule> {
        Ok(match condition {
            Condition::Missed { task, ticks, within } => {
                let task = self.task(&task)?;
                if self.model.tasks[task].period.is_none() {
                    let name = &self.model.tasks[task].name;
                    return self.idle(format!("task {name} has no period, so it misses no ticks"));
                }
                Rule::Missed { task, ticks: ticks.into(), within }
            }
            Condition::Longest { codel, longest } => {
                let codels = self.codels(&codel)?;
                Rule::Longest { codels: codels.into_iter().map(|one| (one, longest)).collect() }
            }
            Condition::Wcet { codel } => self.wcet(codel.as_deref())?,
            Condition::Stuck { codel: Some(codel) } => Rule::Stuck { codels: self.codels(&codel)? },
            Condition::Stuck { codel: None } => {
                Rule::Stuck { codels: self.model.codels.places().collect() }
            }
            Condition::Activity { activity, longest } => {
                Rule::Activity { service: self.activity(&activity)?, longest }
            }
            Condition::After { codel, first } if codel == first => {
                return self.idle(format!("{codel} cannot come after itself"));
            }
            Condition::After { codel, first } => {
                Rule::After { codels: self.codels(&codel)?, first: self.codels(&first)? }
            }
            Condition::NeverWhile { codel, activity } => {
                let (codels, service) = (self.codels(&codel)?, self.activity(&activity)?);
                let own = |ix: &CodelIx| self.model.codels[*ix].owner == Owner::Service(service);
                if codels.iter().any(own) {
                    return self.idle(format!("{codel} is a codel of {activity} itself"));
                }
                Rule::During { codels, service }
            }
            Condition::Step { of, from, to } => self.step(&of, &from, &to)?,
            Condition::Cycle { task, longest } => Rule::Cycle { task: self.task(&task)?, longest },
            Condition::Stop { activity, longest } => {
                Rule::Stop { service: self.activity(&activity)?, longest }
            }
            Condition::Beat { of, least, longest, during } => {
                self.beat(&of, (least, longest), during.as_deref())?
            }
            Condition::ServiceAfter { service, first } => self.service_after(service, first)?,
            Condition::ServiceNeverWhile { service, other } => {
                self.service_never_while(service, other)?
            }
            Condition::Order(order) => self.order(&order)?,
            Condition::Formula(formula) => self.formula(&formula)?,
        })
    }

    fn wcet(&self, codel: Option<&str>) -> Result<Rule, NoSuchRule> {
        let all = match codel {
            Some(name) => self.codels(name)?,
            None => self.model.codels.places().collect(),
        };
        let stated = |ix: CodelIx| Some((ix, self.model.codels[ix].wcet?));
        let codels: Vec<(CodelIx, Duration)> = all.into_iter().filter_map(stated).collect();
        if !codels.is_empty() {
            return Ok(Rule::Longest { codels });
        }
        let whose = codel.map_or_else(
            || format!("no codel of {}", self.model.name),
            |name| format!("codel {name} has none: it"),
        );
        self.idle(format!("{whose} states a `wcet` in the description; say `longest_ms`"))
    }

    fn step(&self, of: &Whose, from: &str, to: &str) -> Result<Rule, NoSuchRule> {
        let (owner, codels) = match of {
            Whose::Activity(name) => {
                let service = self.activity(name)?;
                (Owner::Service(service), &self.model.services[service].codels)
            }
            Whose::Task(name) => {
                let task = self.task(name)?;
                (Owner::Task(task), &self.model.tasks[task].codels)
            }
        };
        let (start, end) = (self.state(from)?, self.state(to)?);
        if start == end {
            return self.idle("a state that yields itself takes no step".to_owned());
        }
        let codel = codels.iter().map(|&ix| &self.model.codels[ix]);
        let yields = codel.filter_map(|codel| match &codel.kind {
            CodelKind::Fsm { triggers, yields } if triggers.contains(&start) => Some(yields),
            _ => None,
        });
        if !yields.flatten().any(|one| one.state == end) {
            return self.idle(format!(
                "no codel of {of} yields {to} in state {from}; the description allows no such \
                 step, and one that it does not allow ends the activity with \
                 ::genom::bad_transition"
            ));
        }
        Ok(Rule::Step { owner, from: start, to: end })
    }

    /// Fails if a reaction has nothing to act upon.
    fn check_reactions(
        &self,
        rule: &Rule,
        entry: &SupervisionEntry,
        request: &LoadRequest,
    ) -> Result<(), NoSuchRule> {
        if entry.does(OwnResponse::Interrupt) && !self.has_activity(rule) {
            return self.idle("there is no activity that `interrupt` could stop".to_owned());
        }
        if entry.does(OwnResponse::Restart) && request.cell.is_none() {
            let name = request.instance();
            return self.idle(format!(
                "`restart` ends the process, and {name} runs in that of the daemon: put it into a \
                 cell (cell = \"{name}\"), or choose another reaction"
            ));
        }
        Ok(())
    }

    /// Whether activities of services can break it.
    fn has_activity(&self, rule: &Rule) -> bool {
        let of_service = |ix: &CodelIx| match self.model.codels[*ix].owner {
            Owner::Service(service) => self.model.services[service].kind == ServiceKind::Activity,
            Owner::Task(_) => false,
        };
        match rule {
            Rule::Missed { task, .. } => {
                self.model.services.iter().any(|service| service.task == Some(*task))
            }
            Rule::Longest { codels } => codels.iter().any(|(ix, _)| of_service(ix)),
            Rule::Stuck { codels } | Rule::After { codels, .. } | Rule::During { codels, .. } => {
                codels.iter().any(of_service)
            }
            Rule::Activity { .. } | Rule::Stop { .. } => true,
            Rule::Step { owner, .. } => matches!(owner, Owner::Service(_)),
            Rule::Cycle { task, .. } => {
                self.model.services.iter().any(|service| service.task == Some(*task))
            }
            Rule::Beat { of: Beats::Codels(codels), during, .. } => {
                during.is_some() || codels.iter().any(of_service)
            }
            Rule::Beat { of: Beats::Port(_), .. } => true,
            Rule::Order(order) => order.hears().iter().any(|(what, _)| self.of_activity(*what)),
            Rule::Formula(program) => program.hears().iter().any(|what| self.of_activity(*what)),
        }
    }

    fn task(&self, name: &str) -> Result<TaskIx, NoSuchRule> {
        let tasks = &self.model.tasks;
        let found = tasks.find(|task| task.name == name);
        self.found(found, "task", name, tasks.iter().map(|task| task.name.as_str()))
    }

    fn activity(&self, name: &str) -> Result<ServiceIx, NoSuchRule> {
        let services = &self.model.services;
        let is = |kind| kind == ServiceKind::Activity;
        let found = services.find(|service| service.name == name && is(service.kind));
        let all = services.iter().filter(|service| is(service.kind));
        self.found(found, "activity", name, all.map(|service| service.name.as_str()))
    }

    fn service(&self, name: &str) -> Result<ServiceIx, NoSuchRule> {
        let services = &self.model.services;
        let found = services.find(|service| service.name == name);
        self.found(found, "service", name, services.iter().map(|one| one.name.as_str()))
    }

    fn state(&self, name: &str) -> Result<StateIx, NoSuchRule> {
        let all = self.model.states.iter().map(String::as_str);
        self.found(self.model.state(name), "state", name, all)
    }

    /// All uses of a function as a codel.
    fn codels(&self, name: &str) -> Result<Vec<CodelIx>, NoSuchRule> {
        let is = |(ix, codel): (CodelIx, &Codel)| (codel.name == name).then_some(ix);
        let all: Vec<CodelIx> = self.model.codels.pairs().filter_map(is).collect();
        let found = (!all.is_empty()).then_some(all);
        let mut names: Vec<&str> =
            self.model.codels.iter().map(|codel| codel.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        self.found(found, "codel", name, names)
    }

    fn found<'a, T>(
        &self,
        found: Option<T>,
        what: &'static str,
        typed: &str,
        known: impl IntoIterator<Item = &'a str>,
    ) -> Result<T, NoSuchRule> {
        found.ok_or_else(|| NoSuchRule::NoSuch {
            at: self.at,
            rule: self.text.clone(),
            component: self.model.name.clone(),
            what,
            typed: typed.to_owned(),
            help: suggest(typed, known),
        })
    }

    fn idle<T>(&self, why: String) -> Result<T, NoSuchRule> {
        Err(NoSuchRule::Idle { at: self.at, rule: self.text.clone(), why })
    }
}
