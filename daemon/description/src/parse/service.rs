//! Tasks, ports and services.

use super::{Parsed, Parser};
use crate::diagnostic::Diagnostic;
use crate::syntax::{
    Direction, PortDeclaration, Service, ServiceKind, ServiceParameter, ServiceParameters, Task,
    Variable, VariableParameter, VariableStep,
};
use crate::token::TokenKind;

impl Parser<'_> {
    pub(super) fn task(&mut self) -> Parsed<Task> {
        let start = self.span();
        self.bump();
        let name = self.name("the name of the task")?;
        let properties = self.properties(&name)?;
        self.semicolon(start)?;
        Ok(Task { name, properties })
    }

    pub(super) fn port(&mut self) -> Parsed<PortDeclaration> {
        let span = self.span();
        let word = self.word().unwrap_or_default();
        self.bump();
        let paper = word != "port";
        let multiple = !paper && self.eat_word("multiple");
        let out = if paper {
            word == "outport"
        } else if self.eat_word("in") {
            false
        } else if self.eat_word("out") {
            true
        } else {
            let help = matches!(self.word(), Some("data" | "event"))
                .then(|| "write `port in` or `port out`, then the type".to_owned());
            return self.refuse("E0103", "`in` or `out`", help);
        };
        let ty = self.type_spec()?;
        let name = self.name("the name of the port")?;
        if self.is("[") {
            let help = "name the array type with `typedef`".to_owned();
            return self.refuse("E0103", "`;`", Some(help));
        }
        let properties = self.properties(&name)?;
        self.semicolon(span)?;
        Ok(PortDeclaration { out, multiple, paper, ty, name, properties, span })
    }

    pub(super) fn service(&mut self) -> Parsed<Service> {
        let start = self.span();
        let kind = match self.word() {
            Some("attribute") => ServiceKind::Attribute,
            Some("function") => ServiceKind::Function,
            Some("activity") => ServiceKind::Activity,
            _ => ServiceKind::Service,
        };
        self.bump();
        let name = self.name("the name of the service")?;
        let span = self.since(start);
        let parameters = match kind {
            ServiceKind::Function | ServiceKind::Activity => ServiceParameters::Typed(
                self.with_code("E0112", |p| p.in_parentheses(Self::service_parameter))?,
            ),
            ServiceKind::Service if !self.is("(") => ServiceParameters::Variables(Vec::new()),
            ServiceKind::Attribute | ServiceKind::Service => ServiceParameters::Variables(
                self.with_code("E0112", |p| p.in_parentheses(Self::variable_parameter))?,
            ),
        };
        let properties = self.properties(&name)?;
        // dialects.md B: `;` is optional after the body of a service.
        if kind != ServiceKind::Service {
            self.semicolon(start)?;
        } else {
            self.eat(";");
        }
        Ok(Service { kind, name, parameters, properties, span })
    }

    pub(super) fn direction(&mut self) -> Parsed<Direction> {
        let direction = match self.word() {
            Some("in") => Direction::In,
            Some("out") => Direction::Out,
            Some("inout") => Direction::InOut,
            _ => return self.unexpected("`in`, `out` or `inout`"),
        };
        self.bump();
        Ok(direction)
    }

    fn service_parameter(&mut self) -> Parsed<ServiceParameter> {
        let direction = self.direction()?;
        let ty = self.type_spec()?;
        let declarator = self.declarator()?;
        let initializer = self.initializer_opt()?;
        Ok(ServiceParameter { direction, ty, declarator, initializer })
    }

    fn variable_parameter(&mut self) -> Parsed<VariableParameter> {
        let start = self.span();
        let direction = self.direction()?;
        if matches!(self.kind(), TokenKind::Keyword(_)) {
            let help = "a parameter of an attribute is a member of the IDS: write its name only";
            return self.refuse("E0112", "a member of the IDS", Some(help.to_owned()));
        }
        let variable = if self.is("::") { None } else { Some(self.variable()?) };
        let rename = if self.eat("::") { Some(self.name("a name")?) } else { None };
        let span = self.since(start);
        let initializer = self.initializer_opt()?;
        Ok(VariableParameter { direction, variable, rename, initializer, span })
    }

    pub(super) fn variable(&mut self) -> Parsed<Variable> {
        let root = self.name("a name")?;
        let mut steps = Vec::new();
        loop {
            if self.eat(".") {
                steps.push(VariableStep::Member(self.name("the name of a member")?));
            } else if self.eat("[") {
                steps.push(VariableStep::Index(self.expression()?));
                self.expect("]")?;
            } else {
                steps.shrink_to_fit();
                return Ok(Variable { root, steps });
            }
        }
    }

    /// Reports a codel of a state machine without `yield`.
    // genom3.md 3.1 L8.
    pub(super) fn missing_yield<T>(&mut self, codel: &str) -> Parsed<T> {
        let message = format!("codel `{codel}` of a state machine must say what it yields");
        let error = Diagnostic::error("E0108", self.span(), message)
            .help("add `yield STATE, ...`, with `ether` for the end");
        self.report(error);
        Err(super::Recover)
    }
}
