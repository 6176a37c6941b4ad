//! Names: `#[genom(name = "::demo::state")]`, and identifiers as C strings.

use proc_macro2::TokenStream;
use quote::quote;
use syn::ext::IdentExt;
use syn::{Attribute, DeriveInput, Error, Ident, LitStr, Result};

/// The full IDL name that the attribute gives to `input`.
pub(crate) fn full_name(input: &DeriveInput) -> Result<TokenStream> {
    let mut name: Option<LitStr> = None;
    for attribute in input.attrs.iter().filter(|attribute| attribute.path().is_ident("genom")) {
        attribute.parse_nested_meta(|meta| {
            if !meta.path.is_ident("name") {
                return Err(meta.error("unknown key: the only one is `name`"));
            }
            name = Some(meta.value()?.parse()?);
            Ok(())
        })?;
    }
    let name = name.ok_or_else(|| {
        Error::new_spanned(&input.ident, "say its name: `#[genom(name = \"::component::type\")]`")
    })?;
    if !is_full_name(&name.value()) {
        return Err(Error::new_spanned(&name, "not a full name such as `::demo::state`"));
    }
    Ok(c_string(&name.value()))
}

/// Whether the text consists of one or more parts, each `::` and an identifier.
fn is_full_name(text: &str) -> bool {
    text.strip_prefix("::").is_some_and(|segments| {
        segments.split("::").all(|segment| {
            segment.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
                && segment.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        })
    })
}

/// The identifier in IDL: `type` for `r#type`.
pub(crate) fn plain(ident: &Ident) -> String {
    ident.unraw().to_string()
}

/// An expression of type `&'static CStr`.
pub(crate) fn c_string(text: &str) -> TokenStream {
    let text = format!("{text}\0");
    quote! { const { ::genom::rt::c_str(#text) } }
}

/// Whether the item has an attribute `#[repr(...)]` that lists `wanted`.
pub(crate) fn has_repr(attributes: &[Attribute], wanted: &str) -> bool {
    attributes.iter().filter(|attribute| attribute.path().is_ident("repr")).any(|attribute| {
        let mut found = false;
        let parsed = attribute.parse_nested_meta(|meta| {
            found |= meta.path.is_ident(wanted);
            // `align(8)` and `packed(2)` have an argument.
            if meta.input.peek(syn::token::Paren) {
                meta.input.parse::<proc_macro2::TokenTree>()?;
            }
            Ok(())
        });
        parsed.is_ok() && found
    })
}
