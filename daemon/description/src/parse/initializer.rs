//! Default values and documentation of parameters (genom3.md 2.4).

use super::{Parsed, Parser};
use crate::syntax::{InitialStep, InitialValue, Initializer};

impl Parser<'_> {
    /// `= initializer`, if it is there.
    pub(super) fn initializer_opt(&mut self) -> Parsed<Option<Initializer>> {
        if self.eat("=") {
            return self.initializer().map(Some);
        }
        if self.is(":") {
            let help = "documentation needs an equal sign: `=: \"doc\"`".to_owned();
            return self.refuse("E0112", "`=`, `,` or `)`", Some(help));
        }
        Ok(None)
    }

    fn initializer(&mut self) -> Parsed<Initializer> {
        let start = self.span();
        let mut step = None;
        let mut value = None;
        if self.eat("[") {
            step = Some(InitialStep::Index(self.expression()?));
            self.expect("]")?;
            self.expect("=")?;
        } else if self.eat(".") {
            step = Some(InitialStep::Member(self.name("the name of a member")?));
            self.expect("=")?;
        }
        if self.is("{") {
            value = Some(InitialValue::Compound(self.nested(Self::compound)?));
        } else if !self.is(":")
            && !(step.is_some() && (self.is(",") || self.is("}") || self.is(")")))
        {
            value = Some(InitialValue::Scalar(self.expression()?));
        }
        let doc = if self.eat(":") { Some(self.text()?) } else { None };
        Ok(Initializer { step, value, doc, span: self.since(start) })
    }

    fn compound(&mut self) -> Parsed<Vec<Initializer>> {
        self.expect("{")?;
        if self.eat("}") {
            return Ok(Vec::new());
        }
        let items = self.list(Self::initializer)?;
        if !self.eat("}") {
            return self.unexpected("`,` or `}`");
        }
        Ok(items)
    }
}
