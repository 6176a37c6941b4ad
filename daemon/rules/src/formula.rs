//! Formulas become programs; rules about services are formulas, too.

use genom_protocol::supervision::{Atom, Formula, What, Within};
use genom_runtime::{Bounds, Part, Program, Rule, nanos};

use crate::happening::Means;
use crate::{Compiler, NoSuchRule};

impl Compiler<'_> {
    pub(crate) fn formula(&self, formula: &Formula) -> Result<Rule, NoSuchRule> {
        let mut parts = Vec::new();
        self.parts(formula, &mut parts)?;
        match Program::new(parts) {
            Ok(program) if program.hears().is_empty() => {
                self.idle("it names nothing that happens, so it is never looked at".to_owned())
            }
            Ok(program) => Ok(Rule::Formula(program)),
            Err(source) => {
                Err(NoSuchRule::Program { at: self.at, rule: self.text.clone(), source })
            }
        }
    }

    /// `start(service) -> once end(first)`.
    pub(crate) fn service_after(&self, service: String, first: String) -> Result<Rule, NoSuchRule> {
        self.service(&service)?;
        self.service(&first)?;
        if service == first {
            return self.idle(format!("{service} cannot come after itself"));
        }
        let ended = Formula::Once(Within::EVER, Box::new(atom(What::End, first)));
        let start = Box::new(atom(What::Start, service));
        self.formula(&Formula::Implies(start, Box::new(ended)))
    }

    /// `start(service) -> not run(other)`.
    pub(crate) fn service_never_while(
        &self,
        service: String,
        other: String,
    ) -> Result<Rule, NoSuchRule> {
        self.service(&service)?;
        self.service(&other)?;
        if service == other {
            return self.idle(format!("{service} cannot start while it does not run itself"));
        }
        let quiet = Formula::Not(Box::new(atom(What::Run, other)));
        let start = Box::new(atom(What::Start, service));
        self.formula(&Formula::Implies(start, Box::new(quiet)))
    }

    /// Adds the parts of a formula, itself last; returns its place.
    fn parts(
        &self,
        formula: &Formula,
        parts: &mut Vec<(Part, String)>,
    ) -> Result<usize, NoSuchRule> {
        let part = match formula {
            Formula::Constant(value) => Part::Constant(*value),
            Formula::Atom(atom) => match self.means(atom)? {
                Means::Happens(all) => Part::Happens(all),
                Means::Runs(service) => Part::Runs(service),
            },
            Formula::Not(a) => Part::Not(self.parts(a, parts)?),
            Formula::And(a, b) => Part::And(self.parts(a, parts)?, self.parts(b, parts)?),
            Formula::Or(a, b) => Part::Or(self.parts(a, parts)?, self.parts(b, parts)?),
            Formula::Implies(a, b) => Part::Implies(self.parts(a, parts)?, self.parts(b, parts)?),
            Formula::Previous(a) => Part::Previous(self.parts(a, parts)?),
            Formula::Once(within, a) => Part::Once(bounds(*within), self.parts(a, parts)?),
            Formula::Historically(within, a) => {
                Part::Historically(bounds(*within), self.parts(a, parts)?)
            }
            Formula::Since(within, a, b) => {
                Part::Since(bounds(*within), self.parts(a, parts)?, self.parts(b, parts)?)
            }
        };
        parts.push((part, formula.to_string()));
        Ok(parts.len() - 1)
    }
}

fn atom(what: What, name: String) -> Formula {
    Formula::Atom(Atom { what: Some(what), name, column: 1 })
}

fn bounds(within: Within) -> Bounds {
    Bounds { least: nanos(within.least), most: within.most.map_or(u64::MAX, nanos) }
}
