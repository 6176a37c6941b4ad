//! Tokens as text: what `genom3 -E` prints.

use std::fmt::Write as _;

use crate::source::SourceMap;
use crate::token::{Pragma, Token, TokenKind};

/// Lines that are left blank rather than replaced by a line marker.
const NEAR: u32 = 8;

/// The tokens on the lines that they come from. Line markers (`# 3 "file"`) tell where that is, as
/// far as `markers` asks for them (genom3.md 1.4).
#[must_use]
pub fn printed(tokens: &[Token], sources: &SourceMap, markers: bool) -> String {
    let mut text = String::new();
    let mut place: Option<(u32, u32)> = None;
    for token in tokens.iter().filter(|token| token.kind != TokenKind::End) {
        let line = sources.location(token.span).line;
        let file = token.span.file;
        match place {
            Some((same, at)) if same == file && line >= at && line - at <= NEAR => {
                (at..line).for_each(|_| text.push('\n'));
            }
            _ => {
                if !text.is_empty() && !text.ends_with('\n') {
                    text.push('\n');
                }
                if markers {
                    let path = sources.file(file).map(|file| file.path().display().to_string());
                    let _ = writeln!(text, "# {line} \"{}\"", path.unwrap_or_default());
                }
            }
        }
        if !text.is_empty() && !text.ends_with('\n') {
            text.push(' ');
        }
        one(&mut text, &token.kind);
        place = Some((file, line));
    }
    if !text.is_empty() {
        text.push('\n');
    }
    text
}

fn one(text: &mut String, kind: &TokenKind) {
    // Writing to a String cannot fail.
    let _ = match kind {
        TokenKind::Identifier(name) => write!(text, "{name}"),
        TokenKind::Keyword(word) | TokenKind::Punctuation(word) => write!(text, "{word}"),
        TokenKind::Integer(value) => write!(text, "{value}"),
        TokenKind::Float(value) => write!(text, "{value:?}"),
        TokenKind::Fixed => write!(text, "0d"),
        TokenKind::Char(code) if code.is_ascii_graphic() && !b"'\\".contains(code) => {
            write!(text, "'{}'", char::from(*code))
        }
        TokenKind::Char(code) => write!(text, "'\\x{code:02x}'"),
        TokenKind::String(value) => write!(text, "{}", quoted(value)),
        TokenKind::Pragma(pragma) => {
            let (name, words) = match &**pragma {
                Pragma::Requires(words) => ("requires", words),
                Pragma::Provides(words) => ("provides", words),
                Pragma::Masquerade(words) => ("masquerade", words),
            };
            let words: String =
                words.iter().map(|(word, _)| format!(" {}", quoted(word))).collect();
            write!(text, "#pragma {name}{words}")
        }
        TokenKind::End => Ok(()),
    };
}

/// The lexer keeps all escapes but that of the quotation mark.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\\\""))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preprocess::tokenize_text;

    fn print(text: &str, markers: bool) -> String {
        let mut sources = SourceMap::new();
        let (tokens, _) = tokenize_text("a.gen", text, &mut sources);
        printed(&tokens, &sources, markers)
    }

    #[test]
    fn macros_are_replaced_and_lines_kept() {
        let text = "#define N 3\n\nconst long a = N;\nconst string b = \"x\\\"y\";\n";
        assert_eq!(
            print(text, true),
            "# 3 \"a.gen\"\nconst long a = 3 ;\nconst string b = \"x\\\"y\" ;\n"
        );
        assert_eq!(print("#if 0\nx\n#endif\n", true), "");
    }

    #[test]
    fn what_is_printed_reads_the_same_again() {
        let text = "#pragma requires \"a >= 1\"\nconst char c = '\\n'; const double d = 1e-3;\n";
        let once = print(text, false);
        assert_eq!(print(&once, false), once);
    }
}
