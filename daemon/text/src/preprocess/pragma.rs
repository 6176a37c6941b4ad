//! `#pragma` and `_Pragma` (genom3.md 1.3).

use super::include::join;
use super::scanner::Scanner;
use super::{Kind, PToken, Preprocessor};
use crate::diagnostic::Diagnostic;
use crate::lex::unescape;
use crate::source::Loaded;
use crate::source::Span;
use crate::token::Pragma;

type Words = Vec<(Box<str>, Span)>;

impl Preprocessor<'_> {
    /// `#pragma`; `line` is what follows the word.
    pub(super) fn pragma(&mut self, directive: PToken, line: &[PToken]) {
        let mut words = self.words(line);
        if words.is_empty() {
            return;
        }
        let (name, span) = words.remove(0);
        let place = join(directive.span, words.last().map_or(span, |(_, last)| *last));
        match name.to_ascii_lowercase().as_str() {
            "require" | "requires" => {
                self.require(&words, span);
                self.lexer.pragma(Pragma::Requires(words), place);
            }
            "provide" | "provides" => self.lexer.pragma(Pragma::Provides(words), place),
            "masquerade" => self.lexer.pragma(Pragma::Masquerade(words), place),
            "once" => {
                if let Some(open) = self.open.last() {
                    self.once.insert(open.identity.clone());
                }
            }
            // Unknown pragmas are for other tools.
            _ => {}
        }
    }

    /// `_Pragma("...")`: the same from inside a line or a macro.
    pub(super) fn pragma_operator(&mut self, operator: PToken) {
        let parts = [self.raw(), self.raw(), self.raw()];
        let sound = self.text(parts[0]) == "("
            && parts[1].kind == Kind::String
            && self.text(parts[2]) == ")";
        if !sound {
            self.diagnostics.push(
                Diagnostic::error("E0132", operator.span, "`_Pragma` takes one string")
                    .help("write `_Pragma(\"requires \\\"package\\\"\")`"),
            );
            return;
        }
        let text = self.text(parts[1]);
        let text = text.get(1..text.len().saturating_sub(1)).unwrap_or_default();
        let text = text.replace("\\\"", "\"").replace("\\\\", "\\");
        let loaded = Loaded::new(text.into_bytes());
        let made = self.scratch(&loaded.text);
        let mut scanner = Scanner::new(loaded.logical, operator.span.file, made.buffer);
        scanner.directive = true;
        let mut line = Vec::new();
        loop {
            let token = scanner.next(&mut self.diagnostics);
            if matches!(token.kind, Kind::End | Kind::Newline) {
                break;
            }
            line.push(PToken { span: operator.span, ..token });
        }
        self.pragma(operator, &line);
    }

    /// The words of a pragma, separated by blanks; a string is one word.
    fn words(&self, line: &[PToken]) -> Words {
        let mut words: Vec<(String, Span, bool)> = Vec::new();
        for token in line {
            let string = token.kind == Kind::String;
            let text = self.text(*token);
            match words.last_mut() {
                Some((word, span, false)) if !token.space && !string => {
                    word.push_str(text);
                    *span = join(*span, token.span);
                }
                _ if string => words.push((unescape(text), token.span, true)),
                _ => words.push((text.to_owned(), token.span, false)),
            }
        }
        words.into_iter().map(|(word, span, _)| (word.into(), span)).collect()
    }
}
