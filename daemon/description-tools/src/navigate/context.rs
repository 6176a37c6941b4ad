//! The grammatical context of a position, derived from the tokens before it.
//!
//! The parser cannot give it, since the statement being written is incomplete.

use genom_description::token::{Token, TokenKind};

use super::Navigator;
use super::symbol::{Space, SymbolKind};

/// The tokens before a position.
pub(super) struct Context<'a> {
    /// Statements that open the blocks around it, outermost first.
    pub(super) blocks: Vec<&'a [Token]>,
    /// The current statement, without the word that is being written.
    pub(super) statement: &'a [Token],
}

/// A token as text; literals are empty.
pub(super) fn word(token: &Token) -> &str {
    match &token.kind {
        TokenKind::Identifier(text) => text,
        TokenKind::Keyword(text) | TokenKind::Punctuation(text) => text,
        _ => "",
    }
}

impl Context<'_> {
    /// The keyword of the innermost block, empty at top level.
    pub(super) fn block(&self) -> &str {
        self.blocks.last().and_then(|head| head.first()).map_or("", word)
    }

    /// Words of the statement.
    pub(super) fn words(&self) -> Vec<&str> {
        self.statement.iter().map(word).collect()
    }
}

impl Navigator {
    /// The context of a byte offset of a file; `None` in comments and strings.
    pub(super) fn context(&self, file: u32, offset: u32) -> Option<Context<'_>> {
        let text = self.analysis.sources.file(file)?.text();
        let first = self.tokens.iter().position(|token| token.span.file == file);
        let tokens = self.tokens.get(first.unwrap_or(self.tokens.len())..)?;
        let mut blocks: Vec<&[Token]> = Vec::new();
        let (mut start, mut parentheses, mut braces) = (0, 0_u32, 0_u32);
        let mut count = 0;
        for (rank, token) in tokens.iter().enumerate() {
            // Tokens of an included file belong to no statement of this one.
            if token.span.file != file {
                start = rank + 1;
                count = rank + 1;
                continue;
            }
            let is_word = matches!(token.kind, TokenKind::Identifier(_) | TokenKind::Keyword(_));
            let before = token.span.end < offset || (token.span.end == offset && !is_word);
            if !before || token.kind == TokenKind::End {
                if token.span.start < offset && matches!(token.kind, TokenKind::String(_)) {
                    return None;
                }
                break;
            }
            count = rank + 1;
            match word(token) {
                "(" => parentheses += 1,
                ")" => parentheses = parentheses.saturating_sub(1),
                // An initial value, not a block.
                "{" if parentheses > 0 => braces += 1,
                "}" if braces > 0 => braces -= 1,
                "{" => {
                    blocks.push(tokens.get(start..rank).unwrap_or_default());
                    start = rank + 1;
                }
                "}" => {
                    blocks.pop();
                    start = rank + 1;
                }
                ";" => {
                    (start, parentheses, braces) = (rank + 1, 0, 0);
                }
                _ if matches!(token.kind, TokenKind::Pragma(_)) => start = rank + 1,
                _ => {}
            }
        }
        let end = count.checked_sub(1).and_then(|last| tokens.get(last)).map_or(0, |t| t.span.end);
        let end = if count > 0 && tokens.get(count - 1)?.span.file != file { 0 } else { end };
        let between = text.get(end as usize..offset as usize).unwrap_or_default();
        let open = between
            .rfind("/*")
            .is_some_and(|at| !between.get(at..).unwrap_or_default().contains("*/"));
        let line = between.rsplit('\n').next().unwrap_or_default();
        if open || line.contains("//") || line.trim_start().starts_with('#') {
            return None;
        }
        Some(Context { blocks, statement: tokens.get(start..count).unwrap_or_default() })
    }

    /// The symbol of the innermost block that declares one.
    pub(super) fn scope_of(&self, context: &Context<'_>) -> usize {
        let mut scope = 0;
        for head in &context.blocks {
            let mut words = head.iter().map(word);
            let space = match words.next().unwrap_or_default() {
                "task" => Space::Task,
                "port" => Space::Port,
                "attribute" | "function" | "activity" | "service" => Space::Service,
                "ids" => continue,
                _ => Space::Scope,
            };
            let name = words.next().unwrap_or_default();
            if let Some(found) = self.table.local(scope, space, name) {
                scope = found;
            } else if space == Space::Service || space == Space::Task {
                // Its statement failed to parse because it is incomplete: use the component.
                scope = self.table.body_of(scope);
            }
        }
        scope
    }

    /// The service or task that a statement belongs to, 0 if there is none.
    pub(super) fn service_of(&self, scope: usize) -> usize {
        self.table.around(scope, |kind| kind.is_service() || kind == SymbolKind::Task)
    }
}
