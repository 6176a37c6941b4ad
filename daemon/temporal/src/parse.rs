//! Formulas from text: the operators of Spin, and words for the past.

use super::term::{Join, Term};

/// Parts within each other, at most.
const DEPTH: usize = 40;
/// Characters of a formula.
const LENGTH: usize = 2_000;

/// Why a text is no formula.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FormulaError {
    /// Something else is wanted at this place.
    #[error("character {at}: {wanted}")]
    Syntax {
        /// The character, from 1.
        at: usize,
        /// What is wanted there.
        wanted: String,
    },
    /// It is too long, or its parts are in each other too deeply.
    #[error("the formula is too long")]
    Long,
}

/// What is wrong with words that are no fact.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NoFact(pub String);

/// Makes a fact of a word before brackets, if there is one, and of a name; or says what is wrong with them.
pub type Facts<'f, A> = dyn Fn(Option<&str>, &str) -> Result<A, NoFact> + 'f;

/// The formula that a text says. `facts` says in words which facts there are, and `fact` makes them.
///
/// # Errors
/// If the text is no formula, or names what is no fact.
pub fn parse<A>(text: &str, facts: &str, fact: &Facts<'_, A>) -> Result<Term<A>, FormulaError> {
    if text.len() > LENGTH {
        return Err(FormulaError::Long);
    }
    let mut parser = Parser { facts, fact, tokens: tokens(text)?, at: 0, end: text.len() + 1 };
    let term = parser.equal(0)?;
    if parser.at < parser.tokens.len() {
        return Err(parser.wanted("an operator, or the end"));
    }
    Ok(term)
}

/// An operator or a word, and where it begins, from 1.
type Token<'t> = (&'t str, usize);

const OPERATORS: [&str; 10] = ["<->", "->", "[]", "<>", "&&", "||", "!", "(", ")", ","];

fn tokens(text: &str) -> Result<Vec<Token<'_>>, FormulaError> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        let rest = &text[at..];
        if first.is_whitespace() {
            at += first.len_utf8();
        } else if let Some(operator) = OPERATORS.into_iter().find(|one| rest.starts_with(one)) {
            tokens.push((operator, at + 1));
            at += operator.len();
        } else {
            let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let length = rest.find(|c| !word(c)).unwrap_or(rest.len());
            if length == 0 {
                let wanted = "an operator or a name".to_owned();
                return Err(FormulaError::Syntax { at: at + 1, wanted });
            }
            tokens.push((&rest[..length], at + 1));
            at += length;
        }
    }
    Ok(tokens)
}

struct Parser<'t, A> {
    facts: &'t str,
    fact: &'t Facts<'t, A>,
    tokens: Vec<Token<'t>>,
    at: usize,
    end: usize,
}

impl<A> Parser<'_, A> {
    fn wanted(&self, wanted: impl Into<String>) -> FormulaError {
        let at = self.tokens.get(self.at).map_or(self.end, |(_, at)| *at);
        FormulaError::Syntax { at, wanted: wanted.into() }
    }

    fn peek(&self) -> &str {
        self.tokens.get(self.at).map_or("", |(token, _)| *token)
    }

    fn take(&mut self, any: &[&str]) -> bool {
        let found = any.contains(&self.peek());
        self.at += usize::from(found);
        found
    }

    fn expect(&mut self, token: &str) -> Result<(), FormulaError> {
        if self.take(&[token]) { Ok(()) } else { Err(self.wanted(format!("`{token}` is wanted"))) }
    }

    /// Parts with a sign between them, of which the first two are joined first.
    fn chain(
        &mut self,
        sign: &str,
        join: Join,
        part: fn(&mut Self, usize) -> Result<Term<A>, FormulaError>,
        depth: usize,
    ) -> Result<Term<A>, FormulaError> {
        let mut left = part(self, depth)?;
        while self.take(&[sign]) {
            left = two(join, left, part(self, depth)?);
        }
        Ok(left)
    }

    fn equal(&mut self, depth: usize) -> Result<Term<A>, FormulaError> {
        self.chain("<->", Join::Equal, Self::implies, depth)
    }

    fn implies(&mut self, depth: usize) -> Result<Term<A>, FormulaError> {
        if depth > DEPTH {
            return Err(FormulaError::Long);
        }
        let left = self.or(depth)?;
        if self.take(&["->"]) {
            return Ok(two(Join::Implies, left, self.implies(depth + 1)?));
        }
        Ok(left)
    }

    fn or(&mut self, depth: usize) -> Result<Term<A>, FormulaError> {
        self.chain("||", Join::Or, Self::and, depth)
    }

    fn and(&mut self, depth: usize) -> Result<Term<A>, FormulaError> {
        self.chain("&&", Join::And, Self::until, depth)
    }

    fn until(&mut self, depth: usize) -> Result<Term<A>, FormulaError> {
        let left = self.unary(depth)?;
        if self.take(&["U", "until"]) {
            return Ok(Term::Until(Box::new(left), Box::new(self.unary(depth)?)));
        }
        if self.take(&["since"]) {
            return Ok(Term::Since(Box::new(left), Box::new(self.unary(depth)?)));
        }
        Ok(left)
    }

    fn unary(&mut self, depth: usize) -> Result<Term<A>, FormulaError> {
        if depth > DEPTH {
            return Err(FormulaError::Long);
        }
        let of: fn(Box<Term<A>>) -> Term<A> = match self.peek() {
            "!" => Term::Not,
            "[]" | "always" => Term::Always,
            "<>" | "eventually" => Term::Eventually,
            "once" => Term::Once,
            "historically" => Term::Historically,
            "previous" => Term::Previous,
            _ => return self.atom(depth),
        };
        self.at += 1;
        Ok(of(Box::new(self.unary(depth + 1)?)))
    }

    fn atom(&mut self, depth: usize) -> Result<Term<A>, FormulaError> {
        if self.take(&["("]) {
            let term = self.equal(depth + 1)?;
            self.expect(")")?;
            return Ok(term);
        }
        let word = self.peek().to_owned();
        match word.as_str() {
            "true" | "false" => {
                self.at += 1;
                return Ok(Term::Const(word == "true"));
            }
            _ if word.is_empty()
                || !word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') =>
            {
                return Err(self.wanted(format!("{} is wanted", self.facts)));
            }
            _ => {}
        }
        let called = self.tokens.get(self.at + 1).is_some_and(|(token, _)| *token == "(");
        let found = if called {
            let name = self.tokens.get(self.at + 2).map_or("", |(token, _)| *token);
            (self.fact)(Some(&word), name)
        } else {
            (self.fact)(None, &word)
        };
        let atom = found.map_err(|why| self.wanted(why.0))?;
        self.at += if called { 3 } else { 1 };
        if called {
            self.expect(")")?;
        }
        Ok(Term::Atom(atom))
    }
}

fn two<A>(join: Join, a: Term<A>, b: Term<A>) -> Term<A> {
    Term::Two(join, Box::new(a), Box::new(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Formulas about letters, alone or in brackets behind `is`.
    fn letters(text: &str) -> Result<Term<String>, FormulaError> {
        parse(text, "a letter", &|word, name| match (word, name.len()) {
            (None | Some("is"), 1) => Ok(name.to_owned()),
            _ => Err(NoFact(format!("`{name}` is no letter"))),
        })
    }

    #[test]
    fn signs_bind_from_not_to_equal_and_what_follows_is_read_from_the_right() {
        let same = |one: &str, other: &str| assert_eq!(letters(one), letters(other), "{one}");
        same("a -> b -> c", "a -> (b -> c)");
        same("!a && b || c -> d <-> e", "(((((!a) && b) || c) -> d) <-> e)");
        same("[] a && <> b", "(always is(a)) && (eventually is(b))");
        same("a U b && c since d", "(a until b) && (c since d)");
        assert_ne!(letters("a -> b -> c"), letters("(a -> b) -> c"));
    }

    #[test]
    fn what_is_no_formula_is_said_with_its_place() {
        let wrong = |text: &str, at: usize, wanted: &str| {
            let wanted = FormulaError::Syntax { at, wanted: wanted.to_owned() };
            assert_eq!(letters(text), Err(wanted), "{text}");
        };
        wrong("a &&", 5, "a letter is wanted");
        wrong("a b", 3, "an operator, or the end");
        wrong("[] (a", 6, "`)` is wanted");
        wrong("a && abc", 6, "`abc` is no letter");
        wrong("a # b", 3, "an operator or a name");
        assert_eq!(letters(&"!".repeat(100)), Err(FormulaError::Long));
        assert_eq!(letters(&"a".repeat(3_000)), Err(FormulaError::Long));
    }
}
