//! Types, their members and declarators (genom3.md 2.5).

use super::{Parsed, Parser};
use crate::diagnostic::Diagnostic;
use crate::syntax::{
    Case, CaseLabel, Constructed, Declarator, Enum, Expression, Member, TypeSpec, TypeSpecKind,
    Union,
};
use crate::token::TokenKind;

impl Parser<'_> {
    pub(super) fn type_spec(&mut self) -> Parsed<TypeSpec> {
        let start = self.span();
        let kind = match self.kind() {
            TokenKind::Keyword("struct" | "union" | "enum") => {
                TypeSpecKind::Constructed(Box::new(self.nested(Self::constructed)?))
            }
            _ => return self.simple_type(),
        };
        Ok(TypeSpec { kind, span: self.since(start) })
    }

    fn simple_type(&mut self) -> Parsed<TypeSpec> {
        use TypeSpecKind as K;
        let start = self.span();
        let basic = |kind| (kind, 1);
        let (kind, tokens) = match self.kind() {
            TokenKind::Identifier(_) | TokenKind::Punctuation("::") => {
                (K::Named(self.path("a type")?), 0)
            }
            TokenKind::Keyword("boolean") => basic(K::Boolean),
            TokenKind::Keyword("char") => basic(K::Char),
            TokenKind::Keyword("octet") => basic(K::Octet),
            TokenKind::Keyword("float") => basic(K::Float),
            TokenKind::Keyword("double") => basic(K::Double),
            TokenKind::Keyword("any") => basic(K::Any),
            TokenKind::Keyword("short" | "long" | "unsigned") => (self.integer_type()?, 0),
            TokenKind::Keyword("string") => {
                self.bump();
                let bound = if self.eat("<") {
                    let bound = self.expression()?;
                    self.close_angle(Some(&bound))?;
                    Some(Box::new(bound))
                } else {
                    None
                };
                (K::String(bound), 0)
            }
            TokenKind::Keyword("sequence") => {
                self.bump();
                self.expect("<")?;
                let element = self.nested(Self::simple_type)?;
                let bound = if self.eat(",") { Some(self.expression()?) } else { None };
                self.close_angle(bound.as_ref())?;
                (K::Sequence(Box::new(element), bound.map(Box::new)), 0)
            }
            TokenKind::Keyword("optional") => {
                self.bump();
                self.expect("<")?;
                let element = self.nested(Self::simple_type)?;
                self.close_angle(None)?;
                (K::Optional(Box::new(element)), 0)
            }
            // genom3.md 3.1 L9.
            TokenKind::Keyword("fixed") => {
                let error = Diagnostic::error("E0109", start, "fixed point types do not exist")
                    .help("use `double`, or an integer counting fractions");
                self.report(error);
                self.bump();
                if self.eat("<") {
                    self.list(Self::expression)?;
                    self.close_angle(None)?;
                }
                (K::Error, 0)
            }
            TokenKind::Keyword(word @ ("wchar" | "wstring" | "object")) => {
                let help = format!("`{word}` is reserved, and names no type of GenoM");
                return self.refuse("E0103", "a type", Some(help));
            }
            _ => return self.unexpected("a type"),
        };
        for _ in 0..tokens {
            self.bump();
        }
        Ok(TypeSpec { kind, span: self.since(start) })
    }

    fn integer_type(&mut self) -> Parsed<TypeSpecKind> {
        use TypeSpecKind as K;
        let unsigned = self.eat_keyword("unsigned");
        if self.eat_keyword("short") {
            return Ok(if unsigned { K::UnsignedShort } else { K::Short });
        }
        if !self.eat_keyword("long") {
            return self.unexpected("`short` or `long`");
        }
        Ok(match (unsigned, self.eat_keyword("long")) {
            (false, false) => K::Long,
            (true, false) => K::UnsignedLong,
            (false, true) => K::LongLong,
            (true, true) => K::UnsignedLongLong,
        })
    }

    fn close_angle(&mut self, bound: Option<&Expression>) -> Parsed<()> {
        if self.half_closed {
            self.half_closed = false;
            return Ok(());
        }
        if self.eat(">") {
            return Ok(());
        }
        if self.is(">>") {
            let error = Diagnostic::error("E0103", self.span(), "expected `>`, found `>>`")
                .help("`>>` is one token: write `> >`");
            self.report(error);
            self.bump();
            self.half_closed = self.depth > 0;
            return Ok(());
        }
        let help = bound
            .is_some_and(Expression::ends_in_right_shift)
            .then(|| "`>>` was read as a shift: write `> >`".to_owned());
        self.refuse("E0103", "`>`", help)
    }

    pub(super) fn constructed(&mut self) -> Parsed<Constructed> {
        if self.eat_keyword("struct") {
            return Ok(Constructed::Struct(self.struct_body()?));
        }
        if self.eat_keyword("union") {
            return Ok(Constructed::Union(self.union_body()?));
        }
        self.bump();
        let name = self.name("the name of the enum")?;
        self.expect("{")?;
        let enumerators = self.list(|p| p.name("an enumerator"))?;
        if !self.eat("}") {
            let help =
                self.is("=").then(|| "enumerators count from 0, values cannot be set".into());
            return self.refuse("E0103", "`,` or `}`", help);
        }
        Ok(Constructed::Enum(Enum { name, enumerators }))
    }

    fn union_body(&mut self) -> Parsed<Union> {
        let name = self.name("the name of the union")?;
        if !self.eat_keyword("switch") {
            return self.unexpected("`switch`");
        }
        self.expect("(")?;
        let switch = match self.kind() {
            TokenKind::Keyword("enum") => self.type_spec()?,
            _ => self.simple_type()?,
        };
        self.expect(")")?;
        self.expect("{")?;
        let level = self.braces;
        let mut cases = Vec::new();
        while !self.eat("}") {
            if self.at_end() {
                return self.unclosed(&name);
            }
            let from = self.at;
            match self.with_code("E0110", Self::case) {
                Ok(case) => cases.push(case),
                Err(_) => self.recover(level, from),
            }
        }
        if cases.is_empty() && self.last_error.is_none() {
            return self.unexpected("`case` or `default` before the end of the union");
        }
        Ok(Union { name, switch, cases })
    }

    fn case(&mut self) -> Parsed<Case> {
        let start = self.span();
        let mut labels = Vec::new();
        loop {
            let span = self.span();
            let value = if self.eat_keyword("case") {
                Some(self.expression()?)
            } else if self.eat_keyword("default") {
                None
            } else {
                break;
            };
            labels.push(CaseLabel { value, span: self.since(span) });
            self.expect(":")?;
        }
        if labels.is_empty() {
            return self.unexpected("`case` or `default`");
        }
        let ty = self.type_spec()?;
        let declarator = self.declarator()?;
        self.semicolon(start)?;
        Ok(Case { labels, ty, declarator })
    }

    /// `{ member; member; }`, not empty.
    pub(super) fn member_block(&mut self, code: &'static str) -> Parsed<Vec<Member>> {
        self.expect("{")?;
        let level = self.braces;
        let mut members = Vec::new();
        let mut lost = false;
        while !(self.is("}") && (lost || !members.is_empty())) {
            if self.at_end() {
                return self.unexpected("`}`");
            }
            if self.is("}") {
                return self.with_code(code, |p| p.unexpected("a member"));
            }
            let from = self.at;
            match self.with_code(code, Self::member) {
                Ok(member) => members.push(member),
                Err(_) => {
                    lost = true;
                    self.recover(level, from);
                }
            }
        }
        self.bump();
        members.shrink_to_fit();
        Ok(members)
    }

    fn member(&mut self) -> Parsed<Member> {
        let start = self.span();
        let ty = self.type_spec()?;
        let declarators = self.list(Self::declarator)?;
        self.semicolon(start)?;
        Ok(Member { ty, declarators })
    }

    pub(super) fn declarator(&mut self) -> Parsed<Declarator> {
        let name = self.name("a name")?;
        let mut dimensions = Vec::new();
        while self.eat("[") {
            dimensions.push(self.expression()?);
            self.expect("]")?;
        }
        dimensions.shrink_to_fit();
        Ok(Declarator { name, dimensions })
    }
}
