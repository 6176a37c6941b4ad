//! Where the parts of a component are in the text of its file.

use std::ops::Range;

use genom_description::token::{Token, TokenKind};

/// What a part of a component declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Port,
    Task,
    Service,
    /// The internal data.
    Ids,
    /// Types, properties, events.
    Other,
}

/// A part of a component: bytes from its first word to its `;`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Part {
    pub(super) kind: Kind,
    pub(super) bytes: Range<usize>,
}

/// The parts between the braces of a component.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Body {
    /// Byte behind the opening brace.
    pub(super) open: usize,
    pub(super) parts: Vec<Part>,
}

/// The body of component `name` in the file of this index; `None` if it is not there. Parts that
/// other files hold are left out.
pub(super) fn find(tokens: &[Token], file: u32, name: &str) -> Option<Body> {
    let here = |token: &Token| token.span.file == file;
    let at = tokens.windows(2).position(|pair| match pair {
        [keyword, own] => here(keyword) && word(keyword) == "component" && word(own) == name,
        _ => false,
    })?;
    let mut rest = tokens.get(at..)?.iter().skip_while(|token| sign(token) != "{");
    let open = rest.next().filter(|token| here(token))?.span.end as usize;
    let mut parts = Vec::new();
    let mut first: Option<&Token> = None;
    let mut depth = 0_usize;
    for token in rest {
        if depth == 0 && sign(token) == "}" {
            return Some(Body { open, parts });
        }
        let begin = *first.get_or_insert(token);
        match sign(token) {
            "{" | "(" => depth += 1,
            "}" | ")" => depth = depth.saturating_sub(1),
            ";" if depth == 0 => {
                if here(begin) && here(token) {
                    let bytes = begin.span.start as usize..token.span.end as usize;
                    parts.push(Part { kind: kind(word(begin)), bytes });
                }
                first = None;
            }
            _ => {}
        }
        if matches!(token.kind, TokenKind::Pragma(_)) && depth == 0 {
            first = None;
        }
    }
    None
}

fn kind(word: &str) -> Kind {
    match word {
        "port" | "inport" | "outport" => Kind::Port,
        "task" => Kind::Task,
        "attribute" | "function" | "activity" | "service" => Kind::Service,
        "ids" => Kind::Ids,
        _ => Kind::Other,
    }
}

fn word(token: &Token) -> &str {
    match &token.kind {
        TokenKind::Identifier(word) => word,
        TokenKind::Keyword(word) => word,
        _ => "",
    }
}

fn sign(token: &Token) -> &str {
    match &token.kind {
        TokenKind::Punctuation(sign) => sign,
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_description::preprocess::tokenize_text;
    use genom_description::source::SourceMap;

    #[test]
    fn parts_are_found_by_their_first_word_with_all_that_is_nested_in_them() {
        let text = "struct s { long component; };\ncomponent arm { ids { s a; };\n \
                    port out s p { doc \"};\"; };\n task t; \
                    activity go(in long x = { .a = 1 }) { task t; }; };";
        let mut sources = SourceMap::new();
        let (tokens, _) = tokenize_text("arm.gen", text, &mut sources);
        let file = sources.files().find(|(_, file)| !file.is_synthetic()).unwrap().0;
        let body = find(&tokens, file, "arm").unwrap();
        let parts: Vec<_> =
            body.parts.iter().map(|part| (part.kind, &text[part.bytes.clone()])).collect();
        assert_eq!(
            parts,
            [
                (Kind::Ids, "ids { s a; };"),
                (Kind::Port, "port out s p { doc \"};\"; };"),
                (Kind::Task, "task t;"),
                (Kind::Service, "activity go(in long x = { .a = 1 }) { task t; };"),
            ]
        );
        assert_eq!(find(&tokens, file, "leg"), None);
    }
}
