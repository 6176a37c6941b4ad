//! Reads declarations and functions.

use std::rc::Rc;

use super::code::{Expr, Function, Kind, Statement, Type};
use super::express::Reader;
use super::lex::Token;
use super::names::Name;

/// Numbers of which no range is told.
const INT: Type = Type::Int(-32_768, 32_767);

impl Reader<'_> {
    /// All declarations of a model.
    pub(crate) fn declarations(&mut self) {
        while *self.peek() != Token::End {
            self.declaration();
        }
    }

    fn declaration(&mut self) {
        if self.takes("typedef") {
            let of = self.type_();
            let name = self.name();
            self.names.add(&name, Name::Type(of));
            return self.expect(";");
        }
        if self.takes("const") {
            self.expect("int");
            let name = self.name();
            if self.takes("[") {
                let count = self.count("]");
                self.expect("=");
                let values = self.values();
                // Constants have no range of their own.
                let of = Type::Array(Rc::new(Type::Int(i32::MIN, i32::MAX)), count);
                self.names.table(&name, &of, &values);
            } else {
                self.expect("=");
                let value = self.constant();
                self.names.add(&name, Name::Number(value));
            }
            return self.expect(";");
        }
        let of = self.type_();
        let name = self.name();
        if self.takes("(") {
            return self.function(name, of);
        }
        if of == Type::Channel {
            self.names.add(&name, Name::Channel);
            return self.expect(";");
        }
        self.variable(&name, of, false);
        self.expect(";");
    }

    /// A number of elements.
    fn count(&mut self, end: &str) -> usize {
        let count = self.constant();
        self.expect(end);
        usize::try_from(count).expect("a number of elements")
    }

    fn values(&mut self) -> Vec<i32> {
        self.expect("{");
        let mut all = vec![self.constant()];
        while self.takes(",") {
            all.push(self.constant());
        }
        self.expect("}");
        all
    }

    pub(crate) fn type_(&mut self) -> Type {
        if self.takes("urgent") {
            self.expect("broadcast");
            self.expect("chan");
            return Type::Channel;
        }
        if self.takes("struct") {
            self.expect("{");
            let mut fields = Vec::new();
            while !self.takes("}") {
                let of = self.type_();
                let name = self.name();
                let of = self.elements(of);
                self.expect(";");
                assert!(!super::lex::is_reserved(&name), "{name}");
                fields.push((name, of));
            }
            return Type::Record(Rc::new(fields));
        }
        let word = self.name();
        match word.as_str() {
            "void" => Type::Void,
            "bool" => Type::Bool,
            "clock" => Type::Clock,
            "int" if self.takes("[") => {
                let least = self.constant();
                self.expect(",");
                let most = self.constant();
                self.expect("]");
                assert!(least <= most, "from {least} to {most}");
                Type::Int(least, most)
            }
            "int" => INT,
            _ => match self.names.find(&word) {
                Some(Name::Type(of)) => of.clone(),
                other => panic!("`{word}` as a type: {other:?}"),
            },
        }
    }

    fn elements(&mut self, of: Type) -> Type {
        if !self.takes("[") {
            return of;
        }
        let count = self.count("]");
        Type::Array(Rc::new(of), count)
    }

    /// A variable, and what sets it. Those of a model are 0 or as they say; a list has one value for
    /// each.
    fn variable(&mut self, name: &str, of: Type, in_function: bool) -> Option<Expr> {
        let of = self.elements(of);
        // What is told of a variable does not know it.
        let first = self.takes("=").then(|| self.pure(Kind::Int));
        let place = self.names.variable(name, &of);
        if in_function {
            let first = first.unwrap_or(Expr::Number(0));
            return Some(Expr::Assign(place, Box::new(first)));
        }
        match first {
            None => {}
            Some(Expr::Number(value)) => self.names.first.push((place.base, value)),
            Some(other) => panic!("{name} is {other:?}"),
        }
        None
    }

    fn function(&mut self, name: String, gives: Type) {
        self.names.open();
        (self.names.frame, self.names.in_function) = (0, true);
        let mut takes = Vec::new();
        while !self.takes(")") {
            if !takes.is_empty() {
                self.expect(",");
            }
            let of = self.type_();
            takes.push(of.range().unwrap_or_else(|| panic!("{name} takes {of:?}")));
            let parameter = self.name();
            self.names.variable(&parameter, &of);
        }
        self.expect("{");
        let body = self.block(&gives);
        let changes = self.does(&body);
        self.names.close();
        self.names.in_function = false;
        let frame = self.names.frame;
        let at = self.names.fixed.functions.len();
        self.names.fixed.functions.push(Function {
            name: name.clone(),
            gives,
            takes,
            frame,
            body,
            changes,
        });
        // It is not known within itself: there is no recursion.
        self.names.add(&name, Name::Function(at));
    }

    /// Variables, then statements.
    fn block(&mut self, gives: &Type) -> Statement {
        let mut all = Vec::new();
        while self.is_word("int") || self.is_word("bool") {
            let of = self.type_();
            let name = self.name();
            all.extend(self.variable(&name, of, true).map(Statement::Do));
            self.expect(";");
        }
        while !self.takes("}") {
            all.push(self.statement(gives));
        }
        Statement::All(all)
    }

    fn statement(&mut self, gives: &Type) -> Statement {
        if self.takes("{") {
            self.names.open();
            let block = self.block(gives);
            self.names.close();
            return block;
        }
        if self.takes("return") {
            let value = (*gives != Type::Void).then(|| self.pure(Kind::Int));
            self.expect(";");
            return Statement::Return(value);
        }
        if self.takes("if") {
            let condition = self.condition();
            let then = Box::new(self.statement(gives));
            let otherwise = self.takes("else").then(|| Box::new(self.statement(gives)));
            return Statement::If(condition, then, otherwise);
        }
        if self.takes("while") {
            let condition = self.condition();
            return Statement::While(condition, Box::new(self.statement(gives)));
        }
        if self.takes("for") {
            self.expect("(");
            let first = self.effect();
            self.expect(";");
            let condition = self.pure(Kind::Int);
            self.expect(";");
            let step = self.effect();
            self.expect(")");
            return Statement::For(
                Box::new([first, condition, step]),
                Box::new(self.statement(gives)),
            );
        }
        let effect = self.effect();
        self.expect(";");
        Statement::Do(effect)
    }

    /// One that may change something: UPPAAL calls it once.
    fn condition(&mut self) -> Expr {
        self.expect("(");
        let (expr, kind) = self.expr();
        assert_eq!(kind, Kind::Int);
        self.expect(")");
        expr
    }

    /// An expression that does something.
    pub(crate) fn effect(&mut self) -> Expr {
        let (expr, _) = self.expr();
        assert!(self.changes(&expr, true), "{expr:?} does nothing");
        expr
    }

    fn does(&self, statement: &Statement) -> bool {
        let does = |one: &Statement| self.does(one);
        let changes = |expr: &Expr| self.changes(expr, false);
        match statement {
            Statement::Do(expr) => changes(expr),
            Statement::If(condition, then, otherwise) => {
                changes(condition) || does(then) || otherwise.as_deref().is_some_and(does)
            }
            Statement::While(condition, body) => changes(condition) || does(body),
            Statement::For(head, body) => head.iter().any(changes) || does(body),
            Statement::Return(value) => value.as_ref().is_some_and(changes),
            Statement::All(all) => all.iter().any(does),
        }
    }
}
