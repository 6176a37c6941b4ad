//! Limits on what a text may expand to. Files, macros and the tokens they make are counted, so that
//! memory stays in proportion to the text (`docs/language.md` lists the limits).

use super::macros::Macro;
use super::{PToken, Preprocessor};
use crate::diagnostic::Diagnostic;
use crate::source::Span;

/// Tokens that macros may make in all: far more than in real descriptions.
pub(super) const MAX_EXPANDED: usize = 1 << 20;
/// Bytes of text that macros may make: `#` and `##` can double a text at each level, and a long
/// text can be used many times.
const MAX_EXPANDED_BYTES: usize = 1 << 24;
/// Tokens in one directive.
const MAX_LINE: usize = 1 << 18;
/// Tokens that the definitions of macros may hold.
const MAX_DEFINED: usize = 1 << 20;
/// What a macro costs besides its tokens, counted as tokens.
const MACRO: usize = 8;
/// Tokens passed to the parser, in all.
const MAX_TOKENS: usize = 1 << 20;
/// Bytes of text of those tokens.
const MAX_TEXT: usize = 1 << 25;

impl Preprocessor<'_> {
    /// Counts what a use of a macro will make, before it is made; false when that exceeds the
    /// limit.
    pub(super) fn count_expanded(
        &mut self,
        name: PToken,
        found: &Macro,
        tokens: usize,
        bytes: usize,
    ) -> bool {
        if self.fatal {
            return false;
        }
        self.made.expanded += tokens;
        self.made.bytes += bytes;
        let message = if self.made.expanded > MAX_EXPANDED {
            format!("macros expand to more than {MAX_EXPANDED} tokens")
        } else if self.made.bytes > MAX_EXPANDED_BYTES {
            format!("macros expand to more than {} MiB of text", MAX_EXPANDED_BYTES >> 20)
        } else {
            return true;
        };
        let mut error = Diagnostic::error("E0127", name.span, message)
            .help("a macro that uses another one twice doubles its size each time");
        if found.span != Span::default() {
            let note = format!("while expanding `{}`, defined here", found.name);
            error = error.note(found.span, note);
        }
        self.abandon(error);
        false
    }

    /// Counts tokens that are added to a list of macro tokens, with their text.
    pub(super) fn count_tokens(&mut self, name: PToken, found: &Macro, tokens: &[PToken]) -> bool {
        let bytes = tokens.iter().map(|token| token.length()).sum();
        self.count_expanded(name, found, tokens.len(), bytes)
    }

    /// Counts a definition.
    pub(super) fn count_definition(&mut self, name: Span, tokens: usize) -> bool {
        self.made.defined += tokens + MACRO;
        let fits = self.made.defined <= MAX_DEFINED;
        if !fits {
            let message = format!("macros hold more than {MAX_DEFINED} tokens in all");
            self.abandon(
                Diagnostic::error("E0133", name, message)
                    .help("include only the files that define what is used"),
            );
        }
        fits
    }

    /// Counts a token of a directive that already has `before` tokens.
    pub(super) fn count_line(&mut self, before: usize, token: PToken) -> bool {
        let fits = before < MAX_LINE;
        if !fits {
            let message = format!("a directive holds more than {MAX_LINE} tokens");
            self.abandon(Diagnostic::error("E0133", token.span, message).help("cut the line"));
        }
        fits
    }

    /// Counts a token that is passed to the lexer.
    pub(super) fn count_text(&mut self, token: PToken) -> bool {
        self.made.text += token.length();
        let message = if self.lexer.len() >= MAX_TOKENS {
            format!("the description has more than {MAX_TOKENS} words and signs")
        } else if self.made.text > MAX_TEXT {
            format!("the description is longer than {} MiB, all included", MAX_TEXT >> 20)
        } else {
            return true;
        };
        self.abandon(
            Diagnostic::error("E0133", token.span, message)
                .help("make several descriptions of it, each with the files it needs"),
        );
        false
    }
}

impl PToken {
    /// Bytes of its text.
    fn length(self) -> usize {
        (self.text.end - self.text.start) as usize
    }
}
