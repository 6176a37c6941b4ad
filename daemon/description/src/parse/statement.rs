//! Statements at top level, in modules and in components.

use genom_nearest::meant;

use super::{Parsed, Parser};
use crate::syntax::{
    Body, Const, Exception, Export, Idl, IdsDeclaration, Name, Path, Statement, Struct, TypeSpec,
    Typedef, words,
};
use crate::token::TokenKind;

/// Words that may start a statement of a component.
fn exports() -> impl Iterator<Item = &'static str> {
    [words::PARTS, words::PROPERTIES, words::IDL, &["codel"]].into_iter().flatten().copied()
}

impl Parser<'_> {
    pub(super) fn specification(&mut self) -> Vec<Statement> {
        let mut statements = Vec::new();
        loop {
            let pragmas = std::mem::take(&mut self.pragmas);
            statements.extend(pragmas.into_iter().map(|(p, span)| Statement::Pragma(p, span)));
            if self.at_end() {
                return statements;
            }
            let from = self.at;
            match self.statement() {
                Ok(statement) => statements.push(statement),
                Err(_) => {
                    if self.is("}") && self.at == from {
                        self.bump();
                    }
                    self.recover(0, from);
                }
            }
        }
    }

    /// Whether the current token can only be the start of a statement.
    pub(super) fn starts_statement(&self) -> bool {
        match self.kind() {
            TokenKind::Keyword(k) => {
                matches!(*k, "module" | "const" | "struct" | "union" | "enum" | "typedef")
            }
            TokenKind::Identifier(word) => {
                matches!(&**word, "component" | "interface" | "async")
                    || exports().any(|export| export == &**word)
            }
            _ => false,
        }
    }

    fn statement(&mut self) -> Parsed<Statement> {
        let start = self.span();
        match self.word() {
            Some("component") => Ok(Statement::Component(self.body()?)),
            Some("interface") => Ok(Statement::Interface(self.body()?)),
            // dialects.md A: these stand outside the component in the papers' dialects.
            Some(
                "inport" | "outport" | "event" | "service" | "ids" | "task" | "port" | "attribute"
                | "function" | "activity",
            ) if matches!(self.second(), TokenKind::Identifier(_) | TokenKind::Keyword(_))
                || self.is_word("ids") =>
            {
                Ok(Statement::Outside(self.export()?))
            }
            _ => match self.idl()? {
                Some(idl) => Ok(Statement::Idl(idl)),
                None => {
                    let help = self
                        .word()
                        .and_then(|word| meant(word, exports().chain(["component", "interface"])));
                    let _ = start;
                    self.refuse("E0104", "`component`, `interface` or an IDL definition", help)
                }
            },
        }
    }

    fn body(&mut self) -> Parsed<Body> {
        let start = self.span();
        let what = if self.is_word("component") { "component" } else { "interface" };
        self.bump();
        let name = self.name(&format!("the name of the {what}"))?;
        let mut exports = Vec::new();
        if self.eat("{") {
            let level = self.braces;
            loop {
                let pragmas = std::mem::take(&mut self.pragmas);
                exports.extend(pragmas.into_iter().map(|(p, span)| Export::Pragma(p, span)));
                if self.eat("}") {
                    break;
                }
                if self.at_end() {
                    let _ = self.unclosed::<()>(&name);
                    return Ok(Body { name, exports });
                }
                let from = self.at;
                match self.export() {
                    Ok(export) => exports.push(export),
                    Err(_) => self.recover(level, from),
                }
            }
        }
        // Although what follows is lost, the body itself is complete.
        let from = self.at;
        if self.semicolon(start).is_err() {
            self.recover(0, from);
        }
        Ok(Body { name, exports })
    }

    pub(super) fn unclosed<T>(&mut self, name: &Name) -> Parsed<T> {
        let message = format!("expected `}}` to close `{}`, found end of file", name.text);
        let error = crate::diagnostic::Diagnostic::error("E0105", self.span(), message)
            .note(name.span, "opened here");
        self.report(error);
        Err(super::Recover)
    }

    fn export(&mut self) -> Parsed<Export> {
        let second_colon = self.second_is(":");
        match self.word() {
            Some("ids") if !second_colon => Ok(Export::Ids(self.ids()?)),
            Some("task") if !second_colon => Ok(Export::Task(self.task()?)),
            Some("port" | "inport" | "outport") => Ok(Export::Port(self.port()?)),
            Some("attribute" | "function" | "activity" | "service") => {
                Ok(Export::Service(self.service()?))
            }
            Some("event") => {
                let start = self.span();
                self.bump();
                let names = self.list(|p| p.name("the name of an event"))?;
                self.semicolon(start)?;
                Ok(Export::Events(names))
            }
            _ => {
                if let Some(idl) = self.idl()? {
                    return Ok(Export::Idl(idl));
                }
                if let Some(property) = self.property()? {
                    return Ok(Export::Property(property));
                }
                let help = match self.word() {
                    Some("remote") => Some("remotes come from `uses INTERFACE;`".to_owned()),
                    Some("template") => Some("templates are gone since GenoM 3".to_owned()),
                    Some(word) => meant(word, exports()),
                    None if self.is(";") => Some("remove this `;`".to_owned()),
                    None => None,
                };
                self.refuse("E0103", "a declaration or a property", help)
            }
        }
    }

    fn ids(&mut self) -> Parsed<IdsDeclaration> {
        let span = self.span();
        self.bump();
        let name = if self.is("{") { None } else { Some(self.name("`{`")?) };
        let members = self.member_block("E0111")?;
        self.semicolon(span)?;
        Ok(IdsDeclaration { name, members, span })
    }

    /// An IDL statement; `None` if the current token begins none.
    fn idl(&mut self) -> Parsed<Option<Idl>> {
        let start = self.span();
        let idl = match self.kind() {
            TokenKind::Keyword("module") => self.nested(Self::module)?,
            TokenKind::Keyword("const") => {
                self.bump();
                let ty = self.constant_type()?;
                let name = self.name("the name of the constant")?;
                if !self.eat("=") {
                    return self.unexpected("`=`");
                }
                let value = self.expression()?;
                self.semicolon(start)?;
                Idl::Const(Const { ty, name, value })
            }
            TokenKind::Keyword("typedef") => {
                self.bump();
                let ty = self.type_spec()?;
                let declarators = self.list(Self::declarator)?;
                self.semicolon(start)?;
                Idl::Typedef(Typedef { ty, declarators })
            }
            TokenKind::Keyword("struct" | "union" | "enum") => {
                let union = self.is_keyword("union");
                let enumeration = self.is_keyword("enum");
                if !enumeration && self.third_is_semicolon() {
                    self.bump();
                    let name = self.name("a name")?;
                    self.bump();
                    Idl::Forward { union, name }
                } else {
                    let constructed = self.nested(Self::constructed)?;
                    self.semicolon(start)?;
                    Idl::Constructed(constructed)
                }
            }
            TokenKind::Identifier(word) if &**word == "native" => {
                self.bump();
                let name = self.name("the name of the native type")?;
                self.semicolon(start)?;
                Idl::Native(name)
            }
            TokenKind::Identifier(word) if &**word == "exception" => {
                self.bump();
                let exceptions = self.list(Self::exception)?;
                self.semicolon(start)?;
                Idl::Exceptions(exceptions)
            }
            _ => return Ok(None),
        };
        Ok(Some(idl))
    }

    fn third_is_semicolon(&self) -> bool {
        let mut rest = self.tokens.get(self.at + 1..).unwrap_or_default().iter();
        let mut next =
            || rest.by_ref().map(|t| &t.kind).find(|kind| !matches!(kind, TokenKind::Pragma(_)));
        matches!(next(), Some(TokenKind::Identifier(_)))
            && matches!(next(), Some(TokenKind::Punctuation(";")))
    }

    fn module(&mut self) -> Parsed<Idl> {
        let start = self.span();
        self.bump();
        let name = self.name("the name of the module")?;
        self.expect("{")?;
        let level = self.braces;
        let mut statements = Vec::new();
        loop {
            let pragmas = std::mem::take(&mut self.pragmas);
            statements.extend(pragmas.into_iter().map(|(p, span)| Idl::Pragma(p, span)));
            if self.eat("}") {
                break;
            }
            if self.at_end() {
                let _ = self.unclosed::<()>(&name);
                return Ok(Idl::Module { name, statements });
            }
            let from = self.at;
            match self.idl() {
                Ok(Some(idl)) => statements.push(idl),
                Ok(None) => {
                    let help = self
                        .starts_statement()
                        .then(|| "a module holds only types, constants and modules".to_owned());
                    let _ = self.refuse::<()>("E0103", "an IDL definition", help);
                    self.recover(level, from);
                }
                Err(_) => self.recover(level, from),
            }
        }
        self.semicolon(start)?;
        Ok(Idl::Module { name, statements })
    }

    fn exception(&mut self) -> Parsed<Exception> {
        let name = self.name("the name of the exception")?;
        let members = if self.is("{") && self.second_is("}") {
            self.bump();
            self.bump();
            Vec::new()
        } else if self.is("{") {
            self.member_block("E0110")?
        } else {
            Vec::new()
        };
        Ok(Exception { name, members })
    }

    pub(super) fn struct_body(&mut self) -> Parsed<Struct> {
        let name = self.name("the name of the struct")?;
        let members = self.member_block("E0110")?;
        Ok(Struct { name, members })
    }

    /// `a::b`, `::a`.
    pub(super) fn path(&mut self, what: &str) -> Parsed<Path> {
        let start = self.span();
        let absolute = self.eat("::");
        let mut segments = vec![self.name(what)?];
        while self.is("::") {
            self.bump();
            segments.push(self.name("a name")?);
        }
        segments.shrink_to_fit();
        Ok(Path { absolute, segments, span: self.since(start) })
    }

    fn constant_type(&mut self) -> Parsed<TypeSpec> {
        match self.kind() {
            TokenKind::Keyword("struct" | "union" | "enum" | "sequence" | "optional") => {
                self.unexpected("a type of constant: boolean, a number, char, string or a name")
            }
            _ => self.type_spec(),
        }
    }
}
