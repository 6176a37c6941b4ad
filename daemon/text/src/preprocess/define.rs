//! `#define`: what is stored, and when two definitions are equal.

use std::cell::Cell;
use std::rc::Rc;

use super::macros::{Item, Macro, Role, Shape};
use super::{Kind, PToken, Preprocessor};
use crate::diagnostic::Diagnostic;
use crate::source::Span;

/// Kind of a macro, names of its parameters, and the rest of the line.
type Head<'t> = (Shape, Vec<Box<str>>, &'t [PToken]);

impl Preprocessor<'_> {
    /// `#define NAME ...`; `line` is what follows the word `define`.
    pub(super) fn define(&mut self, directive: PToken, line: &[PToken]) {
        let Some((&name, rest)) = line.split_first() else {
            self.bad_define(directive.span, "macro name missing after `#define`");
            return;
        };
        let spelled: Box<str> = self.text(name).into();
        if name.kind != Kind::Identifier || &*spelled == "defined" {
            self.bad_define(name.span, &format!("`{spelled}` cannot be the name of a macro"));
            return;
        }
        let opening = rest.first().filter(|token| !token.space && self.text(**token) == "(");
        let (shape, names, body) = match opening {
            None => (Shape::Object, Vec::new(), rest),
            Some(_) => match self.parameters(name.span, rest) {
                Some(found) => found,
                None => return,
            },
        };
        let span = name.span;
        let Some(body) = self.body(shape, &names, body) else { return };
        if !self.count_definition(span, body.len()) {
            return;
        }
        let made = Macro { name: spelled, shape, body, span, busy: Cell::new(false) };
        self.install(made);
    }

    /// Adds a macro; a different definition of an existing one is a warning.
    pub(super) fn install(&mut self, made: Macro) {
        if let Some(&initial) = made.name.as_bytes().first() {
            self.initials[usize::from(initial)] = true;
        }
        if let Some(old) = self.macros.get(&made.name).cloned()
            && !self.same(&old, &made)
        {
            let message = format!("macro `{}` is redefined", made.name);
            self.diagnostics.push(
                Diagnostic::warning("W0103", made.span, message)
                    .note(old.span, "first defined here")
                    .help(format!("write `#undef {}` before, if this is meant", made.name)),
            );
        }
        self.macros.insert(made.name.clone(), Rc::new(made));
    }

    /// Reads the parameter list at the beginning of `rest`; returns also what follows it.
    fn parameters<'t>(&mut self, name: Span, rest: &'t [PToken]) -> Option<Head<'t>> {
        let mut names: Vec<Box<str>> = Vec::new();
        let mut variadic = false;
        let mut at = 1;
        loop {
            let Some(&token) = rest.get(at) else {
                self.bad_define(name, "the parameter list of this macro is never closed");
                return None;
            };
            let text = self.text(token).to_owned();
            let separator = rest.get(at + 1).map_or("", |next| self.text(*next)).to_owned();
            match (token.kind, text.as_str()) {
                (_, ")") if names.is_empty() => break,
                (_, "...") => {
                    variadic = true;
                    names.push("__VA_ARGS__".into());
                }
                (Kind::Identifier, _) if names.iter().any(|known| **known == *text) => {
                    self.bad_define(token.span, &format!("parameter `{text}` is named twice"));
                    return None;
                }
                (Kind::Identifier, _) => {
                    names.push(text.into());
                    if separator == "..." {
                        variadic = true;
                        at += 1;
                    }
                }
                _ => {
                    let message = format!("`{text}` is not expected in a list of parameters");
                    self.bad_define(token.span, &message);
                    return None;
                }
            }
            at += 1;
            match rest.get(at).map_or("", |next| self.text(*next)) {
                ")" => break,
                "," if !variadic => at += 1,
                _ => {
                    self.bad_define(token.span, "`,` or `)` is expected after this parameter");
                    return None;
                }
            }
        }
        let shape = Shape::Function { parameters: names.len(), variadic };
        Some((shape, names, rest.get(at + 1..).unwrap_or_default()))
    }

    fn body(&mut self, shape: Shape, names: &[Box<str>], body: &[PToken]) -> Option<Vec<Item>> {
        let parameter = |text: &str| names.iter().position(|name| **name == *text);
        let function = matches!(shape, Shape::Function { .. });
        let mut items: Vec<Item> = Vec::with_capacity(body.len());
        let mut at = 0;
        while let Some(&token) = body.get(at) {
            let text = self.text(token).to_owned();
            let mut role = match token.kind {
                Kind::Identifier => parameter(&text).map_or(Role::Plain, Role::Parameter),
                Kind::Punctuation if text == "##" => Role::Paste,
                _ => Role::Plain,
            };
            if function && token.kind == Kind::Punctuation && text == "#" {
                let next = body.get(at + 1).map_or("", |next| self.text(*next));
                let Some(rank) = parameter(next) else {
                    self.bad_define(token.span, "`#` must stand before a parameter of the macro");
                    return None;
                };
                role = Role::Stringize(rank);
                at += 1;
            }
            items.push(Item { token, role });
            at += 1;
        }
        let pastes = |item: &&Item| item.role == Role::Paste;
        if let Some(item) = items.last().filter(pastes).or(items.first().filter(pastes)) {
            self.bad_define(item.token.span, "`##` must stand between two tokens");
            return None;
        }
        Some(items)
    }

    fn same(&self, old: &Macro, new: &Macro) -> bool {
        let alike =
            |(a, b): (&Item, &Item)| a.role == b.role && self.text(a.token) == self.text(b.token);
        old.shape == new.shape
            && old.body.len() == new.body.len()
            && old.body.iter().zip(&new.body).all(alike)
    }

    fn bad_define(&mut self, span: Span, message: &str) {
        self.diagnostics.push(Diagnostic::error("E0124", span, message));
    }
}
