//! Properties: the grammar accepts every one anywhere (genom3.md 2.4).

use std::rc::Rc;

use genom_nearest::meant;

use super::{Parsed, Parser};
use crate::syntax::{Name, Property, PropertyKind, Quantity, TimeUnit, words};

/// Properties of what components consist of.
const OF_PARTS: &[&str] = &[
    "period",
    "delay",
    "priority",
    "scheduling",
    "stack",
    "task",
    "interrupts",
    "before",
    "after",
    "validate",
    "local",
    "codel",
    "async",
    "input",
    "output",
];

/// Every property.
fn all() -> impl Iterator<Item = &'static str> {
    [words::PROPERTIES, OF_PARTS].into_iter().flatten().copied()
}

impl Parser<'_> {
    /// `{ property... }`, if it is there.
    pub(super) fn properties(&mut self, owner: &Name) -> Parsed<Vec<Property>> {
        let mut properties = Vec::new();
        if !self.eat("{") {
            return Ok(properties);
        }
        let level = self.braces;
        while !self.eat("}") {
            if self.at_end() {
                return self.unclosed(owner);
            }
            let from = self.at;
            match self.property() {
                Ok(Some(property)) => properties.push(property),
                // genom3.md 3.1 L7.
                Ok(None) => {
                    let help = self.word().and_then(|word| meant(word, all()));
                    let _ = self.refuse::<()>("E0107", "a property", help);
                    self.recover(level, from);
                }
                Err(_) => self.recover(level, from),
            }
        }
        properties.shrink_to_fit();
        Ok(properties)
    }

    /// A property; `None` if the current token begins none.
    pub(super) fn property(&mut self) -> Parsed<Option<Property>> {
        use PropertyKind as K;
        let Some(word) = self.word() else { return Ok(None) };
        let papers_only = matches!(word, "language" | "ids" | "input" | "output");
        if (papers_only && !self.second_is(":")) || !is_property(word) {
            return Ok(None);
        }
        let keyword = Name { text: word.into(), span: self.span() };
        self.bump();
        let colon = self.is(":").then(|| self.span());
        if colon.is_some() {
            self.bump();
        }
        let kind = match word {
            "doc" => K::Doc(self.text()?),
            "version" => K::Version(self.text()?),
            "lang" | "language" => K::Lang(self.text()?),
            "email" => K::Email(self.text()?),
            "require" | "requires" => K::Requires(self.list(Self::text)?),
            "codels-require" | "codels-requires" => K::CodelsRequire(self.list(Self::text)?),
            "clock-rate" => K::ClockRate(self.quantity()?),
            "provide" | "provides" => K::Provides(self.names("an interface")?),
            "use" | "uses" => K::Uses(self.names("an interface")?),
            "extend" | "extends" => K::Extends(self.names("an interface")?),
            "throw" | "throws" => K::Throws(self.list(|p| p.path("an exception"))?),
            "period" => K::Period(self.quantity()?),
            "delay" => K::Delay(self.quantity()?),
            "priority" => K::Priority(self.expression()?),
            "scheduling" => {
                if !self.eat_word("real-time") {
                    return self.unexpected("`real-time`");
                }
                K::RealTime
            }
            "stack" => {
                let value = self.expression()?;
                let unit = match self.word() {
                    Some("k") => 1 << 10,
                    Some("M") => 1 << 20,
                    _ => 1,
                };
                if unit > 1 {
                    self.bump();
                }
                K::Stack(value, unit)
            }
            "task" => K::Task(self.name("the name of a task")?),
            "interrupt" | "interrupts" => K::Interrupts(self.names("a service")?),
            "before" => K::Before(self.names("a service")?),
            "after" => K::After(self.names("a service")?),
            "validate" => K::Validate(Rc::new(self.validate_codel()?)),
            "local" => {
                let ty = self.type_spec()?;
                K::Local(ty, self.list(Self::declarator)?)
            }
            "async" => {
                if !self.is_word("codel") {
                    return self.unexpected("`codel`");
                }
                self.bump();
                K::Codel(Rc::new(self.codel(true)?))
            }
            "codel" => K::Codel(Rc::new(self.codel(false)?)),
            "ids" => K::IdsType(self.path("the struct that is the IDS")?),
            "input" => K::Input(self.list(Self::variable)?),
            "output" => K::Output(self.list(Self::variable)?),
            _ => return Ok(None),
        };
        self.semicolon(keyword.span)?;
        Ok(Some(Property { kind, keyword, colon }))
    }

    fn names(&mut self, what: &str) -> Parsed<Vec<Name>> {
        self.list(|p| p.name(what))
    }

    /// A number and its unit. A name before the unit is a constant.
    pub(super) fn quantity(&mut self) -> Parsed<Quantity> {
        let value = self.expression()?;
        let unit = match self.word() {
            Some("s") => Some(TimeUnit::Second),
            Some("ms") => Some(TimeUnit::Millisecond),
            Some("us") => Some(TimeUnit::Microsecond),
            _ => None,
        };
        if unit.is_some() {
            self.bump();
        }
        Ok(Quantity { value, unit: unit.unwrap_or(TimeUnit::Second) })
    }
}

fn is_property(word: &str) -> bool {
    all().any(|property| property == word)
        || matches!(
            word,
            "language"
                | "ids"
                | "require"
                | "codels-requires"
                | "provide"
                | "use"
                | "extend"
                | "throw"
                | "interrupt"
        )
}
