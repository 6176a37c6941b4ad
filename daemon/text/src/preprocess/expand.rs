//! Macro expansion (C99 6.10.3): arguments, `#`, `##`, and rescanning.
//!
//! Tokens of a macro's body get the position where the macro is used; tokens of its arguments keep
//! their own position.

use std::rc::Rc;

use super::macros::{Item, Macro, Role, Shape};
use super::scanner::Scanner;
use super::state::Context;
use super::{Kind, PToken, Preprocessor, Text, end_token};
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::source::Loaded;
use crate::source::Span;

/// Deepest nesting of macros in arguments of macros.
const MAX_NESTING: usize = 100;

impl Preprocessor<'_> {
    /// The next token with macros expanded.
    pub(super) fn expanded(&mut self) -> PToken {
        loop {
            let mut token = self.raw();
            if token.kind != Kind::Identifier || token.frozen {
                return token;
            }
            let text = self.text(token);
            let initial = text.as_bytes().first().copied().unwrap_or_default();
            if !self.initials[usize::from(initial)] {
                return token;
            }
            if text == "_Pragma" {
                self.pragma_operator(token);
                continue;
            }
            let Some(found) = self.macros.get(text).cloned() else {
                return token;
            };
            if found.busy.get() {
                token.frozen = true;
                return token;
            }
            if !self.expand(token, &found) {
                return token;
            }
        }
    }

    /// Expands a list of tokens as if nothing followed it.
    pub(super) fn expand_list(&mut self, tokens: Vec<PToken>) -> Vec<PToken> {
        self.contexts.push(Context { tokens, at: 0, of: None, barrier: true });
        let depth = self.contexts.len();
        let mut out = Vec::new();
        loop {
            let token = self.expanded();
            if token.kind == Kind::End {
                break;
            }
            out.push(token);
        }
        for context in self.contexts.drain(depth - 1..) {
            if let Some(of) = context.of {
                of.busy.set(false);
            }
        }
        out
    }

    /// Replaces a use of a macro by its expansion; false when it turns out not to be a use.
    fn expand(&mut self, name: PToken, found: &Rc<Macro>) -> bool {
        let tokens = match found.shape {
            Shape::File | Shape::Line => {
                let made = vec![self.place_token(name, found.shape)];
                if !self.count_tokens(name, found, &made) {
                    return true;
                }
                made
            }
            Shape::Object => self.replace(name, found, &[]),
            Shape::Function { parameters, variadic } => {
                let keep = std::mem::replace(&mut self.keep_open, self.open.len());
                let arguments = self.arguments(name, found);
                self.keep_open = keep;
                match arguments {
                    Arguments::NoUse => return false,
                    Arguments::Unusable => return true,
                    Arguments::Found(arguments) => {
                        match self.fit(name, found, arguments, parameters, variadic) {
                            Some(arguments) => self.replace(name, found, &arguments),
                            None => return true,
                        }
                    }
                }
            }
        };
        // The tokens were counted while they were made.
        if !self.count_expanded(name, found, 1, 0) {
            return true;
        }
        if self.contexts.is_empty() {
            self.sources.record_expansion(name.span, &found.name, found.span);
        }
        found.busy.set(true);
        self.contexts.push(Context { tokens, at: 0, of: Some(Rc::clone(found)), barrier: false });
        true
    }

    /// Reads the arguments of a function-like macro.
    fn arguments(&mut self, name: PToken, found: &Macro) -> Arguments {
        let opening = self.raw();
        if opening.kind == Kind::End || self.text(opening) != "(" {
            if opening.kind != Kind::End {
                let tokens = vec![opening];
                self.contexts.push(Context { tokens, at: 0, of: None, barrier: false });
            }
            return Arguments::NoUse;
        }
        let mut arguments = vec![Vec::new()];
        let mut depth = 0_usize;
        loop {
            let mut token = self.raw();
            if token.kind == Kind::End {
                if !self.fatal {
                    let message =
                        format!("the arguments of macro `{}` are never closed", found.name);
                    self.diagnostics.push(
                        Diagnostic::error("E0125", name.span, message)
                            .note(found.span, "the macro is defined here")
                            .help("close them with `)`"),
                    );
                }
                return Arguments::Unusable;
            }
            match (token.kind, self.text(token)) {
                (Kind::Punctuation, "(") => depth += 1,
                (Kind::Punctuation, ")") if depth == 0 => return Arguments::Found(arguments),
                (Kind::Punctuation, ")") => depth -= 1,
                (Kind::Punctuation, ",") if depth == 0 => {
                    if !self.count_expanded(name, found, 1, 0) {
                        return Arguments::Unusable;
                    }
                    arguments.push(vec![token]);
                    continue;
                }
                _ => {}
            }
            token.first = false;
            // Tokens of nested arguments are held once at each level.
            if !self.count_expanded(name, found, 1, 0) {
                return Arguments::Unusable;
            }
            if let Some(last) = arguments.last_mut() {
                last.push(token);
            }
        }
    }

    /// Fits the arguments given to the number of parameters.
    fn fit(
        &mut self,
        name: PToken,
        found: &Macro,
        given: Vec<Vec<PToken>>,
        parameters: usize,
        variadic: bool,
    ) -> Option<Vec<Vec<PToken>>> {
        // Each argument but the first begins with its comma, which those of `...` keep.
        let count = given.len();
        let without_comma = |(rank, mut argument): (usize, Vec<PToken>)| {
            if rank > 0 {
                argument.remove(0);
            }
            argument
        };
        if parameters == 0 && count == 1 && given.iter().all(Vec::is_empty) {
            return Some(Vec::new());
        }
        if variadic && count + 1 >= parameters {
            let mut rest = given;
            let tail = rest.split_off((parameters - 1).min(rest.len()));
            let mut arguments: Vec<_> = rest.into_iter().enumerate().map(without_comma).collect();
            let skip = usize::from(parameters > 1 && !tail.is_empty());
            arguments.push(tail.into_iter().flatten().skip(skip).collect());
            return Some(arguments);
        }
        if count == parameters {
            return Some(given.into_iter().enumerate().map(without_comma).collect());
        }
        let least = if variadic { "at least " } else { "" };
        let wanted = parameters - usize::from(variadic);
        let message =
            format!("macro `{}` takes {least}{wanted} arguments, {count} given", found.name);
        self.diagnostics.push(
            Diagnostic::error("E0125", name.span, message)
                .note(found.span, "the macro is defined here"),
        );
        None
    }

    /// The body of a macro with its parameters replaced by arguments.
    fn replace(&mut self, name: PToken, found: &Macro, raw: &[Vec<PToken>]) -> Vec<PToken> {
        let mut full: Vec<Option<Vec<PToken>>> = vec![None; raw.len()];
        let mut out: Vec<PToken> = Vec::new();
        // After `##`: whether its left operand left a token to paste to.
        let mut paste: Option<bool> = None;
        for (rank, item) in found.body.iter().enumerate() {
            if self.fatal {
                break;
            }
            let next_pastes = found.body.get(rank + 1).is_some_and(|n| n.role == Role::Paste);
            let operand = match item.role {
                Role::Paste => continue,
                Role::Plain => vec![PToken { span: name.span, first: false, ..item.token }],
                Role::Stringize(parameter) => {
                    let given = raw.get(parameter).map_or(&[][..], Vec::as_slice);
                    match self.stringize(name, found, item, given) {
                        Some(made) => vec![made],
                        None => break,
                    }
                }
                Role::Parameter(parameter) => {
                    let given = raw.get(parameter).map_or(&[][..], Vec::as_slice);
                    if paste.is_some() || next_pastes {
                        given.to_vec()
                    } else {
                        let done = match full.get_mut(parameter).and_then(Option::take) {
                            Some(done) => done,
                            None => self.argument(name, given),
                        };
                        let used = spaced(&done, item.token.space);
                        if let Some(slot) = full.get_mut(parameter) {
                            *slot = Some(done);
                        }
                        used
                    }
                }
            };
            if !self.count_tokens(name, found, &operand) {
                break;
            }
            let left = paste.take();
            if next_pastes {
                paste = Some(left == Some(true) || !operand.is_empty());
            }
            match left {
                Some(true) => self.paste(name, found, item, &mut out, &operand),
                _ => out.extend(operand),
            }
        }
        if let Some(first) = out.first_mut() {
            first.space = name.space;
        }
        out
    }

    /// An argument, fully expanded on its own.
    fn argument(&mut self, name: PToken, given: &[PToken]) -> Vec<PToken> {
        if self.nesting >= MAX_NESTING {
            let message = format!("macro arguments are nested more than {MAX_NESTING} deep");
            self.abandon(Diagnostic::error("E0127", name.span, message));
            return Vec::new();
        }
        self.nesting += 1;
        let done = self.expand_list(given.to_vec());
        self.nesting -= 1;
        done
    }

    /// The text of an argument as a string; `None` when it is too long.
    fn stringize(
        &mut self,
        name: PToken,
        found: &Macro,
        item: &Item,
        argument: &[PToken],
    ) -> Option<PToken> {
        let mut text = String::from("\"");
        for (rank, token) in argument.iter().enumerate() {
            let before = text.len();
            if rank > 0 && token.space {
                text.push(' ');
            }
            let spelled = self.text(*token);
            if matches!(token.kind, Kind::String | Kind::Char) {
                text.push_str(&spelled.replace('\\', "\\\\").replace('"', "\\\""));
            } else {
                text.push_str(spelled);
            }
            if !self.count_expanded(name, found, 0, text.len() - before) {
                return None;
            }
        }
        text.push('"');
        Some(self.made(Kind::String, &text, name.span, item.token.space))
    }

    /// Glues the last token of `out` and the first of `operand`.
    fn paste(
        &mut self,
        name: PToken,
        found: &Macro,
        item: &Item,
        out: &mut Vec<PToken>,
        operand: &[PToken],
    ) {
        let Some((&right, rest)) = operand.split_first() else {
            // GNU: `, ## __VA_ARGS__` without arguments removes the comma.
            if matches!(item.role, Role::Parameter(p) if found.is_rest(p))
                && out.last().is_some_and(|last| self.text(*last) == ",")
            {
                out.pop();
            }
            return;
        };
        let Some(left) = out.pop() else {
            out.extend(operand);
            return;
        };
        let text = format!("{}{}", self.text(left), self.text(right));
        if !self.count_expanded(name, found, 0, text.len()) {
            return;
        }
        let loaded = Loaded::new(text.clone().into_bytes());
        let mut probe = Scanner::new(loaded.logical, 0, 0);
        probe.quiet = true;
        let whole = probe.next(&mut Diagnostics::default());
        if whole.text.end as usize == text.len() && whole.kind != Kind::End {
            out.push(self.made(whole.kind, &text, name.span, left.space));
        } else {
            out.extend([left, PToken { space: false, ..right }]);
            // Two punctuation tokens may stay side by side, as in `&&`: no warning.
            let signs = [left, right].iter().all(|token| token.kind == Kind::Punctuation);
            let rest = matches!(item.role, Role::Parameter(p) if found.is_rest(p));
            if !signs && !rest {
                let message = format!("`##` makes `{text}`, which is no token");
                self.diagnostics.push(
                    Diagnostic::error("E0126", name.span, message)
                        .note(item.token.span, "in this macro"),
                );
            }
        }
        out.extend(rest);
    }

    /// Makes a token that is in no file.
    pub(super) fn made(&mut self, kind: Kind, text: &str, span: Span, space: bool) -> PToken {
        let text: Text = self.scratch(text);
        PToken { kind, text, space, ..end_token(span) }.not_first()
    }

    fn place_token(&mut self, name: PToken, shape: Shape) -> PToken {
        let place = self.sources.location(name.span);
        let (kind, text) = match shape {
            Shape::Line => (Kind::Number, place.line.to_string()),
            _ => {
                let path = place.path.to_string_lossy();
                (Kind::String, format!("\"{}\"", path.replace('\\', "\\\\").replace('"', "\\\"")))
            }
        };
        self.made(kind, &text, name.span, name.space)
    }
}

enum Arguments {
    /// No `(` follows: the name is not a use of the macro.
    NoUse,
    /// Reported already.
    Unusable,
    Found(Vec<Vec<PToken>>),
}

impl Macro {
    /// Whether a parameter takes all remaining arguments.
    fn is_rest(&self, parameter: usize) -> bool {
        matches!(self.shape, Shape::Function { parameters, variadic: true }
            if parameter + 1 == parameters)
    }
}

impl PToken {
    fn not_first(self) -> Self {
        Self { first: false, ..self }
    }
}

/// The same tokens; `space` says whether the first has a space before it.
fn spaced(tokens: &[PToken], space: bool) -> Vec<PToken> {
    let mut tokens = tokens.to_vec();
    if let Some(first) = tokens.first_mut() {
        first.space = space;
    }
    tokens
}
