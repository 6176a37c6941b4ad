//! The text of formulas, and of the steps of orders.

use std::time::Duration;

use genom_nearest::suggest;

use super::tree::{Formula, Within};
use super::word::{Atom, What};

/// Limit on the text of a formula, in bytes.
pub const MOST_TEXT: usize = 1000;
/// Limit on the parts of a formula: operators, names and constants.
pub const MOST_PARTS: usize = 64;
/// Limit on parentheses and operators within each other.
const MOST_DEPTH: usize = 64;
/// Limit on bounds, in seconds.
const MOST_SECONDS: f64 = 1e6;

/// Why a text is no formula or order.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoFormula {
    /// Something else should stand there.
    #[error("column {column}: {what}")]
    At {
        /// Where, from 1, in characters.
        column: usize,
        /// What is wrong.
        what: String,
    },
    /// Too long.
    #[error("it has {0} bytes, and {MOST_TEXT} are the most")]
    Long(usize),
    /// Too many parts.
    #[error("it has {0} parts, and {MOST_PARTS} are the most: operators, names and constants")]
    Parts(usize),
}

impl Formula {
    /// Reads a formula.
    ///
    /// # Errors
    /// The text is none; with the column where that is seen.
    pub fn read(text: &str) -> Result<Self, NoFormula> {
        Parser::new(text)?.formula()
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Token {
    Word(String),
    Number(f64),
    Sign(&'static str),
    End,
}

/// Signs, longer ones first; each with what it means.
const SIGNS: [(&str, &str); 14] = [
    ("[]", "[]"),
    ("->", "->"),
    ("=>", "->"),
    ("&&", "and"),
    ("||", "or"),
    ("&", "and"),
    ("|", "or"),
    ("!", "not"),
    ("(", "("),
    (")", ")"),
    ("[", "["),
    ("]", "]"),
    (",", ","),
    (":", ":"),
];

/// Words of formulas.
const WORDS: [&str; 9] =
    ["not", "and", "or", "implies", "previous", "once", "historically", "since", "always"];

/// Reads a text from left to right.
pub(in super::super) struct Parser {
    /// Tokens with their columns, the last one first.
    left: Vec<(Token, usize)>,
    depth: usize,
    parts: usize,
}

type Read<T> = Result<T, NoFormula>;

impl Parser {
    pub(in super::super) fn new(text: &str) -> Read<Self> {
        if text.len() > MOST_TEXT {
            return Err(NoFormula::Long(text.len()));
        }
        let mut left = tokens(text)?;
        left.reverse();
        Ok(Self { left, depth: 0, parts: 0 })
    }

    /// The whole text as a formula.
    pub(super) fn formula(mut self) -> Read<Formula> {
        // It is to hold at each event, whether the text says so or not.
        let _ = self.takes("[]") || self.takes("always");
        let formula = self.implies()?;
        match self.next() {
            (Token::End, _) if self.parts <= MOST_PARTS => Ok(formula),
            (Token::End, _) => Err(NoFormula::Parts(self.parts)),
            (token, column) => {
                let what = format!("{} stands after the end of the formula", told(&token));
                Err(NoFormula::At { column, what })
            }
        }
    }

    fn implies(&mut self) -> Read<Formula> {
        self.deeper(|me| {
            let first = me.or()?;
            if me.takes("->") || me.takes("implies") {
                me.parts += 1;
                return Ok(Formula::Implies(Box::new(first), Box::new(me.implies()?)));
            }
            Ok(first)
        })
    }

    fn or(&mut self) -> Read<Formula> {
        let mut all = self.and()?;
        while self.takes("or") {
            self.parts += 1;
            all = Formula::Or(Box::new(all), Box::new(self.and()?));
        }
        Ok(all)
    }

    fn and(&mut self) -> Read<Formula> {
        let mut all = self.since()?;
        while self.takes("and") {
            self.parts += 1;
            all = Formula::And(Box::new(all), Box::new(self.since()?));
        }
        Ok(all)
    }

    fn since(&mut self) -> Read<Formula> {
        let mut all = self.one()?;
        while self.takes("since") {
            self.parts += 1;
            let within = self.within()?;
            all = Formula::Since(within, Box::new(all), Box::new(self.one()?));
        }
        Ok(all)
    }

    fn one(&mut self) -> Read<Formula> {
        self.deeper(|me| {
            me.parts += 1;
            let (token, column) = me.next();
            let word = match &token {
                Token::Word(word) => word.as_str(),
                Token::Sign(sign) => *sign,
                _ => "",
            };
            Ok(match word {
                "(" => {
                    me.parts -= 1;
                    let all = me.implies()?;
                    me.wants(")")?;
                    all
                }
                "not" => Formula::Not(Box::new(me.one()?)),
                "previous" => {
                    if let Some((Token::Sign("["), column)) = me.left.last() {
                        let what = "`previous` takes no bounds: it is about the event before";
                        return Err(NoFormula::At { column: *column, what: what.to_owned() });
                    }
                    Formula::Previous(Box::new(me.one()?))
                }
                "once" => Formula::Once(me.within()?, Box::new(me.one()?)),
                "historically" => Formula::Historically(me.within()?, Box::new(me.one()?)),
                "true" => Formula::Constant(true),
                "false" => Formula::Constant(false),
                "[]" | "always" => {
                    let what = format!(
                        "`{word}` stands at the beginning only: for all events so far say \
                         `historically`"
                    );
                    return Err(NoFormula::At { column, what });
                }
                word if matches!(token, Token::Word(_)) && !WORDS.contains(&word) => {
                    Formula::Atom(me.named(word.to_owned(), column)?)
                }
                _ => {
                    let what = format!("{} stands where a formula is wanted", told(&token));
                    return Err(NoFormula::At { column, what });
                }
            })
        })
    }

    /// What happens: a name, or `WHAT(NAME)`.
    pub(in super::super) fn atom(&mut self) -> Read<Atom> {
        match self.next() {
            (Token::Word(word), column) => self.named(word, column),
            (token, column) => {
                let what = format!("{} stands where a name is wanted", told(&token));
                Err(NoFormula::At { column, what })
            }
        }
    }

    fn named(&mut self, word: String, column: usize) -> Read<Atom> {
        if !self.takes("(") {
            return Ok(Atom { what: None, name: word, column });
        }
        let Some((_, what)) = What::ALL.iter().find(|(name, _)| *name == word) else {
            let help = suggest(&word, What::ALL.iter().map(|(name, _)| *name));
            let what = format!("there is nothing `{word}(...)`; {help}");
            return Err(NoFormula::At { column, what });
        };
        let (name, column) = self.word("a name")?;
        self.wants(")")?;
        Ok(Atom { what: Some(*what), name, column })
    }

    /// `[LEAST, MOST]`, or nothing.
    fn within(&mut self) -> Read<Within> {
        let Some((_, column)) = self.left.last().map(|(token, at)| (token.clone(), *at)) else {
            return Ok(Within::EVER);
        };
        if !self.takes("[") {
            return Ok(Within::EVER);
        }
        let least = self.time()?;
        self.wants(",")?;
        let most = self.time()?;
        self.wants("]")?;
        let wrong = |what: &str| Err(NoFormula::At { column, what: what.to_owned() });
        match (least, most) {
            (None, _) => wrong("the first bound is a time, not `inf`"),
            (Some(least), Some(most)) if least > most => {
                wrong("the first bound is greater than the second: nothing lies between them")
            }
            (Some(least), most) => Ok(Within { least, most }),
        }
    }

    /// `0`, `2s`, `2.5 ms`; `None` for `inf`.
    fn time(&mut self) -> Read<Option<Duration>> {
        let (number, column) = match self.next() {
            (Token::Word(word), _) if word == "inf" => return Ok(None),
            (Token::Number(number), column) => (number, column),
            (token, column) => {
                let what = format!("{} stands where a time is wanted, as `2s`", told(&token));
                return Err(NoFormula::At { column, what });
            }
        };
        let unit = match self.left.last() {
            Some((Token::Word(word), _)) => word.clone(),
            _ if number == 0.0 => return Ok(Some(Duration::ZERO)),
            _ => {
                let what = format!("{number} has no unit: `{number} ms`, `{number} s`");
                return Err(NoFormula::At { column, what });
            }
        };
        self.left.pop();
        let scale = match unit.as_str() {
            "us" => 1e-6,
            "ms" => 1e-3,
            "s" => 1.0,
            "min" => 60.0,
            unit => {
                let what = format!("`{unit}` is no unit of time: they are us, ms, s and min");
                return Err(NoFormula::At { column, what });
            }
        };
        let seconds = number * scale;
        if seconds > MOST_SECONDS {
            let what = format!("{number} {unit} is more than {MOST_SECONDS} s");
            return Err(NoFormula::At { column, what });
        }
        Ok(Some(Duration::from_secs_f64(seconds)))
    }

    /// A name, with its column.
    pub(in super::super) fn word(&mut self, wanted: &str) -> Read<(String, usize)> {
        match self.next() {
            (Token::Word(word), column) => Ok((word, column)),
            (token, column) => {
                let what = format!("{} stands where {wanted} is wanted", told(&token));
                Err(NoFormula::At { column, what })
            }
        }
    }

    pub(in super::super) fn wants(&mut self, sign: &'static str) -> Read<()> {
        if self.takes(sign) {
            return Ok(());
        }
        let (token, column) = self.next();
        let what = format!("{} stands where `{sign}` is wanted", told(&token));
        Err(NoFormula::At { column, what })
    }

    /// Nothing more follows.
    pub(in super::super) fn ends(&mut self) -> Read<()> {
        match self.next() {
            (Token::End, _) => Ok(()),
            (token, column) => Err(NoFormula::At {
                column,
                what: format!("{} stands after the end", told(&token)),
            }),
        }
    }

    fn takes(&mut self, wanted: &str) -> bool {
        let found = match self.left.last() {
            Some((Token::Sign(sign), _)) => *sign == wanted,
            Some((Token::Word(word), _)) => word == wanted,
            _ => false,
        };
        if found {
            self.left.pop();
        }
        found
    }

    /// The end stays the last token.
    fn next(&mut self) -> (Token, usize) {
        match self.left.len() {
            0 => (Token::End, 1),
            1 => self.left[0].clone(),
            _ => self.left.pop().unwrap_or((Token::End, 1)),
        }
    }

    fn deeper<T>(&mut self, read: impl FnOnce(&mut Self) -> Read<T>) -> Read<T> {
        self.depth += 1;
        if self.depth > MOST_DEPTH {
            let column = self.left.last().map_or(1, |(_, column)| *column);
            let what = format!("more than {MOST_DEPTH} formulas stand within each other");
            return Err(NoFormula::At { column, what });
        }
        let read = read(self);
        self.depth -= 1;
        read
    }
}

fn told(token: &Token) -> String {
    match token {
        Token::Word(word) => format!("`{word}`"),
        Token::Number(number) => format!("`{number}`"),
        Token::Sign(sign) => format!("`{sign}`"),
        Token::End => "the end of the text".to_owned(),
    }
}

fn tokens(text: &str) -> Read<Vec<(Token, usize)>> {
    let mut tokens = Vec::new();
    let (mut rest, mut column) = (text, 1);
    while let Some(first) = rest.chars().next() {
        let run = |of: fn(char) -> bool| rest.find(|c: char| !of(c)).unwrap_or(rest.len());
        let (token, length) = if first.is_whitespace() {
            (None, first.len_utf8())
        } else if first.is_ascii_alphabetic() || first == '_' {
            let length = run(|c| c.is_ascii_alphanumeric() || c == '_');
            (Some(Token::Word(rest[..length].to_owned())), length)
        } else if first.is_ascii_digit() {
            let length = run(|c| c.is_ascii_digit() || c == '.');
            let number = rest[..length].parse().map_err(|_| NoFormula::At {
                column,
                what: format!("`{}` is no number", &rest[..length]),
            })?;
            (Some(Token::Number(number)), length)
        } else if let Some((sign, means)) = SIGNS.iter().find(|(sign, _)| rest.starts_with(*sign)) {
            (Some(Token::Sign(means)), sign.len())
        } else {
            return Err(NoFormula::At { column, what: format!("`{first}` means nothing here") });
        };
        tokens.extend(token.map(|token| (token, column)));
        column += rest[..length].chars().count();
        rest = &rest[length..];
    }
    tokens.push((Token::End, column));
    Ok(tokens)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> String {
        Formula::read(text).map_or_else(|why| why.to_string(), |formula| formula.to_string())
    }

    #[test]
    fn a_formula_is_written_as_it_is_read() {
        for (text, written) in [
            ("[] (main -> once[0,2s] pose)", "main -> once[0, 2 s] pose"),
            ("!a && b || c", "not a and b or c"),
            ("a -> b -> c", "a -> b -> c"),
            ("(a -> b) -> c", "(a -> b) -> c"),
            ("a since[10ms,inf] b since c", "a since[10 ms, inf] b since c"),
            ("not (a or b) and previous c", "not (a or b) and previous c"),
            ("historically [0, 1 min] run(goto)", "historically[0, 60 s] run(goto)"),
            ("start(reset) -> not run(goto)", "start(reset) -> not run(goto)"),
            ("always codel(once)", "codel(once)"),
            ("a and (b and c)", "a and (b and c)"),
        ] {
            assert_eq!(read(text), written);
            // And means the same.
            let again = Formula::read(written).unwrap().to_string();
            assert_eq!(again, written);
        }
    }

    #[test]
    fn what_is_no_formula_is_refused_with_its_column() {
        for (text, why) in [
            ("", "column 1: the end of the text stands where a formula is wanted"),
            ("a ->", "column 5: the end of the text stands where"),
            ("a b", "column 3: `b` stands after the end of the formula"),
            ("(a", "column 3: the end of the text stands where `)` is wanted"),
            ("once[2s,1s] a", "column 5: the first bound is greater"),
            ("once[0,2] a", "column 8: 2 has no unit"),
            ("once[0,2h] a", "column 8: `h` is no unit of time"),
            ("once[inf,inf] a", "column 5: the first bound is a time"),
            ("once[0,1000000min] a", "column 8: 1000000 min is more than"),
            ("once[0,1.2.3s] a", "column 8: `1.2.3` is no number"),
            ("previous[0,2s] a", "column 9: `previous` takes no bounds"),
            ("a -> [] b", "column 6: `[]` stands at the beginning only"),
            ("codl(a)", "column 1: there is nothing `codl(...)`; did you mean `codel`?"),
            ("a # b", "column 3: `#` means nothing here"),
            ("é", "column 1: `é` means nothing here"),
            ("and b", "column 1: `and` stands where a formula is wanted"),
        ] {
            assert!(read(text).contains(why), "{text}: {}", read(text));
        }
        assert!(read(&"a or ".repeat(250)).contains("bytes, and 1000 are the most"));
        assert!(read(&format!("a{}", " or a".repeat(100))).contains("201 parts, and 64"));
        assert!(read(&"(".repeat(900)).contains("column 33: more than 64 formulas"));
        assert!(read(&"not ".repeat(200)).contains("more than 64 formulas"));
    }
}
