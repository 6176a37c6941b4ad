//! Functions that a C or C++ source defines, found without a compiler: enough to know which codels
//! exist already and whether their parameters are still those of the description.

use std::ops::Range;

/// A function that is defined at the top level of a source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Its name, without namespace.
    pub name: String,
    /// Each parameter, as tokens without its name; none for `(void)`.
    pub parameters: Vec<Vec<String>>,
    /// Bytes of the declaration, from its first token to the closing parenthesis.
    pub declaration: Range<usize>,
    /// Byte behind the closing brace.
    pub end: usize,
}

#[derive(Clone, Debug)]
struct Token<'t> {
    text: &'t str,
    at: usize,
}

impl Token<'_> {
    fn end(&self) -> usize {
        self.at + self.text.len()
    }

    fn is_word(&self) -> bool {
        self.text.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
    }
}

/// The functions that `source` defines, in order. Bodies are skipped; `extern "C" { }` and
/// namespaces are looked into.
#[must_use]
pub fn functions(source: &str) -> Vec<Function> {
    let tokens = tokens(source);
    let mut found = Vec::new();
    let mut first = 0;
    let mut at = 0;
    while let Some(token) = tokens.get(at) {
        match token.text {
            ";" | "}" => first = at + 1,
            "{" => {
                let head = tokens.get(first..at).unwrap_or_default();
                if !is_transparent(head) {
                    let last = closing(&tokens, at);
                    let end = tokens.get(last).map_or(source.len(), Token::end);
                    found.extend(function(head, end));
                    at = last;
                }
                first = at + 1;
            }
            _ => {}
        }
        at += 1;
    }
    found
}

/// The parameters of a declaration such as `genom_event f(int a, const genom_context self)`.
#[must_use]
pub(crate) fn parameters(declaration: &str) -> Vec<Vec<String>> {
    let tokens = tokens(declaration);
    function(&tokens, 0).map(|function| function.parameters).unwrap_or_default()
}

/// `extern "C" {` or `namespace x {`.
fn is_transparent(head: &[Token<'_>]) -> bool {
    let linkage =
        matches!(head, [word, name] if word.text == "extern" && name.text.starts_with('"'));
    linkage || head.iter().any(|token| token.text == "namespace")
}

/// Index of the brace that closes the one at `open`, or one past the end.
fn closing(tokens: &[Token<'_>], open: usize) -> usize {
    let mut depth = 0_usize;
    for (at, token) in tokens.iter().enumerate().skip(open) {
        match token.text {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 {
            return at;
        }
    }
    tokens.len()
}

/// The function that a declaration before a body declares.
fn function(head: &[Token<'_>], end: usize) -> Option<Function> {
    let open = head.iter().position(|token| token.text == "(")?;
    let name = head.get(open.checked_sub(1)?).filter(|token| token.is_word())?;
    let mut depth = 0_usize;
    let mut close = None;
    let mut list = vec![Vec::new()];
    for (at, token) in head.iter().enumerate().skip(open) {
        match token.text {
            "(" | "[" | "<" => depth += 1,
            ")" | "]" | ">" => depth = depth.saturating_sub(1),
            _ => {}
        }
        match token.text {
            "(" if depth == 1 => {}
            ")" if depth == 0 => {
                close = Some(at);
                break;
            }
            "," if depth == 1 => list.push(Vec::new()),
            _ => list.last_mut()?.push(token),
        }
    }
    // `f = { ... }` and `struct s { }` have no parenthesis, or end differently.
    if head.iter().any(|token| token.text == "=") {
        return None;
    }
    let declaration = head.first()?.at..head.get(close?)?.end();
    let parameters = list
        .iter()
        .map(|tokens| typed(tokens))
        .filter(|tokens| !tokens.is_empty() && tokens != &["void"])
        .collect();
    Some(Function { name: name.text.to_owned(), parameters, declaration, end })
}

/// Words that are part of a type's name, and so never the name of a parameter.
const TYPE_WORDS: &[&str] = &[
    "bool", "char", "const", "double", "float", "int", "long", "short", "signed", "unsigned",
    "void",
];

/// A parameter without its name. `const` counts only where the function could otherwise change what
/// the caller has: `const int x` and `int x` are the same to a caller.
fn typed(tokens: &[&Token<'_>]) -> Vec<String> {
    let words = tokens.iter().take_while(|token| !matches!(token.text, "[" | "=")).count();
    let named = tokens.get(words.wrapping_sub(1)).is_some_and(|last| {
        let alone = tokens.iter().take(words - 1).all(|token| token.text == "const");
        // In C++ `a::b` alone is a type.
        let scoped = words > 1 && tokens.get(words - 2).is_some_and(|token| token.text == "::");
        last.is_word() && !alone && !scoped && !TYPE_WORDS.contains(&last.text)
    });
    let indirect = tokens.iter().any(|token| matches!(token.text, "*" | "&" | "["));
    tokens
        .iter()
        .enumerate()
        .filter(|(at, token)| !(named && at + 1 == words) && (indirect || token.text != "const"))
        .map(|(_, token)| token.text.to_owned())
        .collect()
}

/// Words, numbers, strings and punctuation; comments and preprocessor lines are left out.
fn tokens(source: &str) -> Vec<Token<'_>> {
    let bytes = source.as_bytes();
    let byte = |at: usize| bytes.get(at).copied().unwrap_or(0);
    let mut list = Vec::new();
    let mut at = 0;
    let mut line_start = true;
    while at < bytes.len() {
        let begin = at;
        match (byte(at), byte(at + 1)) {
            (b'\n', _) => {
                line_start = true;
                at += 1;
                continue;
            }
            (blank, _) if blank.is_ascii_whitespace() => {
                at += 1;
                continue;
            }
            (b'/', b'/') => {
                at = line_end(bytes, at);
                continue;
            }
            (b'/', b'*') => {
                let rest = source.get(at + 2..).unwrap_or_default();
                at = rest.find("*/").map_or(bytes.len(), |length| at + 2 + length + 2);
                continue;
            }
            (b'#', _) if line_start => {
                at = line_end(bytes, at);
                continue;
            }
            (quote @ (b'"' | b'\''), _) => {
                at += 1;
                while at < bytes.len() && byte(at) != quote && byte(at) != b'\n' {
                    at += if byte(at) == b'\\' { 2 } else { 1 };
                }
                at = (at + 1).min(bytes.len());
            }
            (b':', b':') => at += 2,
            (first, _) if first.is_ascii_alphanumeric() || first == b'_' || first >= 0x80 => {
                while byte(at).is_ascii_alphanumeric() || byte(at) == b'_' || byte(at) >= 0x80 {
                    at += 1;
                }
            }
            _ => at += 1,
        }
        line_start = false;
        if let Some(text) = source.get(begin..at) {
            list.push(Token { text, at: begin });
        }
    }
    list
}

/// The end of a line, with those that a backslash joins to it.
fn line_end(bytes: &[u8], from: usize) -> usize {
    let mut at = from;
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'\\' => at += 1,
            b'\n' => break,
            _ => {}
        }
        at += 1;
    }
    at.min(bytes.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(source: &str) -> Vec<String> {
        functions(source).into_iter().map(|function| function.name).collect()
    }

    #[test]
    fn definitions_are_found_and_everything_else_is_not() {
        let source = r#"
            #define BODY(x) { x } \
                void fake() { }
            // void commented() { }
            /* void also() { } */
            static int counts[] = { 1, 2 };
            struct point { int (*read)(void); };
            int declared(int a);
            extern "C" { void first(void) { if (1) { g("}"); } } }
            namespace a { void second() { char c = '{'; (void)c; } }
            genom_event
            third(int32_t n, const char name[8], const genom_context self)
            {
              return main_;
            }
            void last() {"#;
        assert_eq!(names(source), ["first", "second", "third", "last"]);
    }

    #[test]
    fn parameters_are_compared_without_their_names() {
        let one = parameters(
            "genom_event f(const or_pose *p, int32_t n, double a[3], const genom_context self)",
        );
        let other = parameters(
            "genom_event f(const or_pose *pose, const int32_t count, double v[3], genom_context c)",
        );
        assert_eq!(one, other);
        let changed =
            parameters("genom_event f(or_pose *p, int32_t n, double a[4], genom_context c)");
        assert_ne!(one[0], changed[0], "a pointer to const is another type");
        assert_ne!(one[2], changed[2]);
        assert_eq!(
            parameters("f(unsigned int, demo::port)"),
            parameters("f(unsigned int a, demo::port b)")
        );
        assert!(parameters("f(void)").is_empty());
    }

    #[test]
    fn a_definition_says_where_it_is() {
        let source = "int a;\nstatic int f(int x) { return x; } int g(void) { }";
        let found = functions(source);
        assert_eq!(&source[found[0].declaration.clone()], "static int f(int x)");
        assert_eq!(&source[found[0].end..found[0].end + 4], " int");
    }

    #[test]
    fn no_text_is_too_strange() {
        for text in
            ["{", "}", "}}{(", "f(", "f(a{", "\"", "'\\", "/*", "#\\", "f(,){", "(){}", "ä(é){}"]
        {
            let _ = functions(text);
        }
    }
}
