//! Directives: lines that begin with `#`.

use genom_nearest::nearest;

use super::include::join;
use super::{Kind, PToken, Preprocessor, slice};
use crate::diagnostic::Diagnostic;
use crate::source::Span;

const DIRECTIVES: [&str; 15] = [
    "define", "undef", "include", "ifdef", "ifndef", "if", "elif", "else", "endif", "error",
    "warning", "line", "pragma", "ident", "sccs",
];

impl Preprocessor<'_> {
    /// Executes the directive that begins with `hash`.
    pub(super) fn directive(&mut self, hash: PToken) {
        let name = self.begin_directive();
        let text = self.text(name).to_owned();
        match (name.kind, text.as_str()) {
            (Kind::Newline | Kind::End, _) => self.end_directive(),
            // `# 12 "file" 1`: left by another preprocessor (genom3.md 1.4).
            (Kind::Number, _) => {
                let mut line = vec![name];
                line.extend(self.read_line());
                self.line(name, &line);
            }
            (_, "define") => {
                let line = self.read_line();
                self.define(name, &line);
            }
            (_, "undef") => self.undef(name),
            (_, "include") => {
                let line = self.read_line();
                self.include(name, &line);
            }
            (_, "if" | "ifdef" | "ifndef") => self.begin_condition(hash, name, &text),
            (_, "elif" | "else" | "endif") => self.next_condition(hash, name, &text),
            (_, "error" | "warning") => self.say(name, &text),
            (_, "line") => {
                let line = self.read_line();
                let line = self.expand_list(line);
                self.line(name, &line);
            }
            (_, "pragma") => {
                let line = self.read_line();
                self.pragma(name, &line);
            }
            _ => self.unknown(name, &text),
        }
    }

    /// Switches the scanner to a directive, and reads its name.
    pub(super) fn begin_directive(&mut self) -> PToken {
        if let Some(open) = self.open.last_mut() {
            open.scanner.directive = true;
        }
        self.line_token()
    }

    /// Switches the scanner back to text; the end of the line has been read.
    pub(super) fn end_directive(&mut self) {
        if let Some(open) = self.open.last_mut() {
            open.scanner.directive = false;
        }
    }

    /// The next token of the directive, without macro expansion.
    pub(super) fn line_token(&mut self) -> PToken {
        match self.open.last_mut() {
            Some(open) => open.scanner.next(&mut self.diagnostics),
            None => super::end_token(Span::default()),
        }
    }

    /// The rest of the directive as tokens.
    pub(super) fn read_line(&mut self) -> Vec<PToken> {
        let mut line = Vec::new();
        loop {
            let token = self.line_token();
            if matches!(token.kind, Kind::Newline | Kind::End) {
                break;
            }
            if !self.count_line(line.len(), token) {
                break;
            }
            line.push(PToken { first: false, ..token });
        }
        self.end_directive();
        line
    }

    /// Skips the rest of the line.
    pub(super) fn skip_line(&mut self) {
        while !matches!(self.line_token().kind, Kind::Newline | Kind::End) {}
        self.end_directive();
    }

    /// The rest of the directive, which is no program text: unpaired quotes are not reported.
    pub(super) fn read_line_quietly(&mut self) -> Vec<PToken> {
        self.set_quiet(true);
        let line = self.read_line();
        self.set_quiet(false);
        line
    }

    pub(super) fn set_quiet(&mut self, quiet: bool) {
        if let Some(open) = self.open.last_mut() {
            open.scanner.quiet = quiet;
        }
    }

    fn undef(&mut self, name: PToken) {
        let line = self.read_line();
        match line.first() {
            Some(token) if token.kind == Kind::Identifier => {
                let text = self.text(*token).to_owned();
                self.macros.remove(text.as_str());
            }
            other => {
                let span = other.map_or(name.span, |token| token.span);
                let message = "`#undef` must name a macro";
                self.diagnostics.push(Diagnostic::error("E0123", span, message));
            }
        }
    }

    /// `#error` and `#warning`.
    fn say(&mut self, name: PToken, directive: &str) {
        let line = self.read_line_quietly();
        let text = match (line.first(), line.last()) {
            (Some(first), Some(last)) => {
                let mut whole = first.text;
                whole.end = last.text.end;
                let buffer = self.buffers.get(whole.buffer as usize);
                buffer.map_or("", |buffer| slice(buffer, whole)).trim().to_owned()
            }
            _ => format!("#{directive}"),
        };
        let end = line.last().map_or(name.span, |last| last.span);
        let span = join(name.span, end);
        self.diagnostics.push(if directive == "error" {
            Diagnostic::error("E0130", span, text)
        } else {
            Diagnostic::warning("W0102", span, text)
        });
    }

    /// `#line N ["file"]`, and `# N ["file" [FLAG]]`.
    fn line(&mut self, name: PToken, line: &[PToken]) {
        let number = line.first().and_then(|token| self.text(*token).parse::<u32>().ok());
        let file = match line.get(1) {
            Some(token) if token.kind == Kind::String => Some(self.text(*token).to_owned()),
            Some(_) if line.first().is_some_and(|first| first.span != name.span) => {
                self.bad_line(name.span);
                return;
            }
            _ => None,
        };
        match number {
            Some(number) => {
                let path = file.map(|text| text.trim_matches('"').into());
                self.sources.mark_line(name.span, number, path);
            }
            None => self.bad_line(name.span),
        }
    }

    fn bad_line(&mut self, span: Span) {
        self.diagnostics.push(
            Diagnostic::error("E0123", span, "this line directive cannot be understood")
                .help("write `#line NUMBER` or `#line NUMBER \"file\"`"),
        );
    }

    /// Skips a line that begins with `##`.
    pub(super) fn pass_over(&mut self, sign: PToken) {
        if let Some(open) = self.open.last_mut() {
            open.scanner.directive = true;
        }
        self.set_quiet(true);
        self.skip_line();
        self.set_quiet(false);
        let message = "a line that begins with `##` is ignored";
        self.diagnostics.push(Diagnostic::warning("W0105", sign.span, message));
    }

    /// GenoM3 ignores unknown directives silently; here a warning proposes the nearest one.
    fn unknown(&mut self, name: PToken, text: &str) {
        self.read_line_quietly();
        if matches!(text, "ident" | "sccs" | "assert" | "unassert") {
            return;
        }
        let message = format!("unknown directive `#{text}` is ignored");
        let mut diagnostic = Diagnostic::warning("W0105", name.span, message);
        if let Some(known) = nearest(text, DIRECTIVES) {
            diagnostic = diagnostic.help(format!("did you mean `#{known}`?"));
        }
        self.diagnostics.push(diagnostic);
    }
}
