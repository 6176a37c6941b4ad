//! Parameters of codels and remotes: how a type is written determines how it is passed.

use syn::{Error, FnArg, Pat, Result, Type};

use crate::name::plain;

/// How the type of a parameter is written, which determines how it is passed.
pub(crate) enum Form<'a> {
    Value(&'a Type),
    Shared(&'a Type),
    Exclusive(&'a Type),
}

/// Name and type of a parameter.
pub(crate) fn name_and_type(input: &FnArg) -> Result<(String, &Type)> {
    let FnArg::Typed(input) = input else {
        return Err(Error::new_spanned(input, "a codel is a free function"));
    };
    let mut pattern = &*input.pat;
    if let Pat::Type(inner) = pattern {
        pattern = &inner.pat;
    }
    let Pat::Ident(pattern) = pattern else {
        return Err(Error::new_spanned(pattern, "give the parameter a name"));
    };
    Ok((plain(&pattern.ident), &input.ty))
}

/// Whether the type is `&Context`, under any path.
pub(crate) fn is_context(ty: &Type) -> bool {
    matches!(form(ty), Form::Shared(Type::Path(path))
        if path.path.segments.last().is_some_and(|segment| segment.ident == "Context"))
}

/// How `ty` is written.
pub(crate) fn form(ty: &Type) -> Form<'_> {
    match ty {
        Type::Paren(inner) => form(&inner.elem),
        Type::Group(inner) => form(&inner.elem),
        Type::Reference(reference) if reference.mutability.is_some() => {
            Form::Exclusive(&reference.elem)
        }
        Type::Reference(reference) => Form::Shared(&reference.elem),
        ty => Form::Value(ty),
    }
}
