//! Reserved words, word operators and the spellings of punctuation (genom3.md 2.1, 2.2).

/// The reserved keyword with this spelling.
pub(super) fn keyword(text: &str) -> Option<&'static str> {
    Some(match text {
        "module" => "module",
        "FALSE" => "FALSE",
        "TRUE" => "TRUE",
        "unsigned" => "unsigned",
        "short" => "short",
        "long" => "long",
        "fixed" => "fixed",
        "float" => "float",
        "double" => "double",
        "char" => "char",
        "wchar" => "wchar",
        "string" => "string",
        "wstring" => "wstring",
        "boolean" => "boolean",
        "octet" => "octet",
        "object" => "object",
        "any" => "any",
        "const" => "const",
        "enum" => "enum",
        "union" => "union",
        "switch" => "switch",
        "case" => "case",
        "default" => "default",
        "struct" => "struct",
        "sequence" => "sequence",
        "optional" => "optional",
        "typedef" => "typedef",
        _ => return None,
    })
}

/// The operator that a word stands for.
pub(super) fn word_operator(text: &str) -> Option<&'static str> {
    Some(match text {
        "xor" => "^",
        "bitand" => "&",
        "bitor" => "|",
        "compl" => "~",
        "not" => "!",
        _ => return None,
    })
}

/// Whether `first-second` is one name.
pub(super) fn is_dashed(first: &str, second: &str) -> bool {
    matches!(
        (first, second),
        ("clock", "rate") | ("codels", "require" | "requires") | ("real", "time")
    )
}

/// The main spelling of a punctuation token; `None` for one that the language does not use.
pub(super) fn punctuation(text: &str) -> Option<&'static str> {
    Some(match text {
        "{" | "<%" => "{",
        "}" | "%>" => "}",
        "[" | "<:" => "[",
        "]" | ":>" => "]",
        "(" => "(",
        ")" => ")",
        ";" => ";",
        ":" => ":",
        "?" => "?",
        "." => ".",
        "+" => "+",
        "-" => "-",
        "*" => "*",
        "/" => "/",
        "%" => "%",
        "^" => "^",
        "&" => "&",
        "|" => "|",
        "~" => "~",
        "!" => "!",
        "=" => "=",
        "<" => "<",
        ">" => ">",
        "," => ",",
        "::" => "::",
        "<<" => "<<",
        ">>" => ">>",
        _ => return None,
    })
}
