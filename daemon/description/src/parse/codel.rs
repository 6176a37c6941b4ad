//! Codels, in the current language and in the papers' dialects.

use super::{Parsed, Parser};
use crate::model::Span;
use crate::syntax::{Codel, CodelParameter, Direction, Event, Qualifier};
use crate::token::TokenKind;

impl Parser<'_> {
    pub(super) fn validate_codel(&mut self) -> Parsed<Codel> {
        self.codel_call(false, None, None)
    }

    /// What follows `codel`.
    pub(super) fn codel(&mut self, asynchronous: bool) -> Parsed<Codel> {
        if self.eat("<") {
            let triggers = self.list(Self::event)?;
            self.expect(">")?;
            return self.codel_call(asynchronous, Some(triggers), None);
        }
        // dialects.md A: `codel a, b: f(...)`.
        let labelled = matches!(self.kind(), TokenKind::Identifier(_))
            && (self.second_is(":") || self.second_is(","));
        if labelled {
            let start = self.span();
            let triggers = self.list(|p| {
                let name = p.name("the name of an event")?;
                Ok(Event { pause: false, name })
            })?;
            self.expect(":")?;
            let labels = self.since(start);
            return self.codel_call(asynchronous, Some(triggers), Some(labels));
        }
        self.codel_call(asynchronous, None, None)
    }

    fn codel_call(
        &mut self,
        asynchronous: bool,
        triggers: Option<Vec<Event>>,
        labels: Option<Span>,
    ) -> Parsed<Codel> {
        let name = self.name("the name of a codel")?;
        let parameters = self.with_code("E0112", |p| p.in_parentheses(Self::codel_parameter))?;
        let machine = match triggers {
            None => None,
            Some(triggers) => {
                if !self.eat_word("yield") && !self.eat_word("yields") {
                    return self.missing_yield(&name.text);
                }
                Some((triggers, self.list(Self::event)?))
            }
        };
        let wcet = if self.eat_word("wcet") { Some(self.quantity()?) } else { None };
        Ok(Codel { asynchronous, name, parameters, machine, wcet, labels })
    }

    fn event(&mut self) -> Parsed<Event> {
        let name = self.name("a state")?;
        if &*name.text == "pause" && self.eat("::") {
            return Ok(Event { pause: true, name: self.name("a state")? });
        }
        Ok(Event { pause: false, name })
    }

    fn codel_parameter(&mut self) -> Parsed<CodelParameter> {
        let start = self.span();
        let (qualifier, paper) = match self.word() {
            Some("ids") => (Some(Qualifier::Ids), None),
            Some("local") => (Some(Qualifier::Local), None),
            Some("port") => (Some(Qualifier::Port), None),
            Some("remote") => (Some(Qualifier::Remote), None),
            Some("inport") => (Some(Qualifier::Port), Some(Direction::In)),
            Some("outport") => (Some(Qualifier::Port), Some(Direction::Out)),
            _ => (None, None),
        };
        if qualifier.is_some() {
            self.bump();
        }
        let direction = match paper {
            Some(direction) => direction,
            None => self.direction()?,
        };
        let variable = if self.is("::") { None } else { Some(self.variable()?) };
        let rename = if self.eat("::") { Some(self.name("a name")?) } else { None };
        let span = self.since(start);
        Ok(CodelParameter { qualifier, paper: paper.is_some(), direction, variable, rename, span })
    }
}
