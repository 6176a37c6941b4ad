//! Semantic tokens: the kind of each word, as numbers of the protocol.

use genom_description::source::SourceFile;
use genom_description_tools::navigate::{Navigator, Paint, SymbolKind};
use lsp_types::{
    SemanticToken, SemanticTokenModifier, SemanticTokenType, SemanticTokens, SemanticTokensLegend,
};

use crate::place;

/// Larger texts get no semantic tokens, because computing their positions takes long. In bytes.
const LARGEST: usize = 1 << 20;

const KINDS: [SemanticTokenType; 14] = [
    SemanticTokenType::KEYWORD,
    SemanticTokenType::NUMBER,
    SemanticTokenType::STRING,
    SemanticTokenType::NAMESPACE,
    SemanticTokenType::CLASS,
    SemanticTokenType::INTERFACE,
    SemanticTokenType::TYPE,
    SemanticTokenType::ENUM,
    SemanticTokenType::ENUM_MEMBER,
    SemanticTokenType::VARIABLE,
    SemanticTokenType::PROPERTY,
    SemanticTokenType::METHOD,
    SemanticTokenType::FUNCTION,
    SemanticTokenType::EVENT,
];

/// The kinds that the numbers stand for.
pub(super) fn legend() -> SemanticTokensLegend {
    SemanticTokensLegend {
        token_types: KINDS.to_vec(),
        token_modifiers: vec![SemanticTokenModifier::DECLARATION],
    }
}

fn kind(paint: Paint) -> SemanticTokenType {
    use SymbolKind as K;
    match paint {
        Paint::Keyword => SemanticTokenType::KEYWORD,
        Paint::Number => SemanticTokenType::NUMBER,
        Paint::Text => SemanticTokenType::STRING,
        Paint::Name { kind, .. } => match kind {
            K::Root | K::Module | K::Task => SemanticTokenType::NAMESPACE,
            K::Component => SemanticTokenType::CLASS,
            K::Interface => SemanticTokenType::INTERFACE,
            K::Struct | K::Union | K::Typedef | K::Native | K::Exception => SemanticTokenType::TYPE,
            K::Enum => SemanticTokenType::ENUM,
            K::Enumerator | K::Constant => SemanticTokenType::ENUM_MEMBER,
            K::Parameter | K::Local => SemanticTokenType::VARIABLE,
            K::Member | K::Ids | K::Port => SemanticTokenType::PROPERTY,
            K::Attribute | K::Function | K::Activity | K::Service => SemanticTokenType::METHOD,
            K::Codel => SemanticTokenType::FUNCTION,
            K::State | K::Event => SemanticTokenType::EVENT,
        },
    }
}

/// The tokens of a file; each position is relative to the previous token.
pub(super) fn tokens(read: &Navigator, rank: u32, file: &SourceFile) -> SemanticTokens {
    let mut data = Vec::new();
    let (mut line, mut column) = (0, 0);
    let paints = if file.text().len() > LARGEST { Vec::new() } else { read.paints(rank) };
    for (span, paint) in paints {
        let range = place::range(file, span);
        // Tokens that span lines are left to the editor's own highlighting.
        if range.start.line != range.end.line {
            continue;
        }
        let token_type = KINDS.iter().position(|known| *known == kind(paint)).unwrap_or(0);
        let declared = matches!(paint, Paint::Name { declaration: true, .. });
        let start = range.start;
        data.push(SemanticToken {
            delta_line: start.line - line,
            delta_start: if start.line == line {
                start.character - column
            } else {
                start.character
            },
            length: range.end.character - start.character,
            token_type: u32::try_from(token_type).unwrap_or_default(),
            token_modifiers_bitset: u32::from(declared),
        });
        (line, column) = (start.line, start.character);
    }
    SemanticTokens { result_id: None, data }
}
