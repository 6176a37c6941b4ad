//! The sources of this crate, within it.

use proc_macro2::TokenStream;
use quote::quote;

macro_rules! sources {
    ($($name:literal)*) => {
        /// Each file of `src` and its text.
        const SOURCES: &[(&str, &str)] = &[$(($name, include_str!($name))),*];
    };
}

sources! {
    "codel.rs"
    "data.rs"
    "lib.rs"
    "name.rs"
    "parameter.rs"
    "remote.rs"
    "sources.rs"
}

/// An array of pairs of texts.
pub(crate) fn expand() -> TokenStream {
    let files = SOURCES.iter().map(|(name, text)| quote! { (#name, #text) });
    quote! { &[#(#files),*] }
}
