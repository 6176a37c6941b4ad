//! Words, numbers and signs of the language.

/// A token.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Token {
    Word(String),
    Number(i32),
    Sign(&'static str),
    /// There is no more.
    End,
}

/// The longest of those that begin in the same way come first.
const SIGNS: [&str; 27] = [
    "&&", "||", "==", "!=", "<=", ">=", "++", "--", "<", ">", "!", "=", "+", "-", "*", "(", ")",
    "[", "]", "{", "}", ",", ";", ":", ".", "?", "&",
];

pub(crate) fn tokens(text: &str) -> Vec<Token> {
    let (mut all, mut rest) = (Vec::new(), text.trim_start());
    while !rest.is_empty() {
        let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let length = rest.find(|c| !word(c)).unwrap_or(rest.len());
        if let Some(comment) = rest.strip_prefix("/*") {
            rest = comment.split_once("*/").expect("the end of a comment").1;
        } else if length > 0 {
            let (token, after) = rest.split_at(length);
            rest = after;
            all.push(if token.starts_with(|c: char| c.is_ascii_digit()) {
                Token::Number(token.parse().unwrap_or_else(|_| panic!("`{token}` is no number")))
            } else {
                Token::Word(token.to_owned())
            });
        } else {
            let sign = SIGNS.iter().find(|sign| rest.starts_with(**sign));
            let sign = sign.unwrap_or_else(|| panic!("unknown: {}", &rest[..rest.len().min(20)]));
            rest = &rest[sign.len()..];
            all.push(Token::Sign(sign));
        }
        rest = rest.trim_start();
    }
    all
}

/// Words that are no names (libutap, keywords).
const RESERVED: &str = "const select guard sync assign probability process state branchpoint init trans \
    urgent commit broadcast system true false and or xor not imply for while do if else default return \
    typedef struct import meta before_update after_update progress gantt assert IO forall exists sum \
    deadlock priority bool int double string chan clock void scalar hybrid dynamic spawn exit numOf \
    foreach query location break continue switch case abs fabs fmod fma fmax fmin exp ln log pow sqrt \
    ceil floor trunc round random control simulate inf sup bounds Pr X A U W R E M";

pub(crate) fn is_reserved(word: &str) -> bool {
    RESERVED.split_whitespace().any(|reserved| reserved == word)
}
