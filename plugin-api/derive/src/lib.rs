//! Macros of the codel SDK; crate `genom` re-exports and documents them.
//!
//! Their expansions call only unsafe functions of `genom`, under the contract between host and
//! codels, so that crates of codels may forbid unsafe code.

#![forbid(unsafe_code)]

mod codel;
mod data;
mod name;
mod parameter;
mod remote;
mod sources;

use proc_macro::TokenStream;
use remote::Remote;
use syn::{DeriveInput, ItemFn, parse_macro_input};

/// Makes a function a codel: exports it under its own name with the C calling convention.
///
/// Parameters are written in the order of the `.gen` file:
///
/// | `.gen` | Rust |
/// |---|---|
/// | `in` number, boolean, enum | `f64`, `bool`, `Enum<E>` |
/// | `in` struct, array, sequence, optional, `string<N>` | `&T` |
/// | `in string` | `&CStr` |
/// | `in` native | `&Native<T>` |
/// | `out`, `inout` anything | `&mut T` |
/// | ports | `&mut InPort<T>`, `&mut OutPort<T>`, `&mut MultipleInPort<T>`, ... |
/// | remotes | `&mut R`, a type made by `remote!` |
///
/// A last parameter of type `&Context` receives the context. The function returns an `Event`,
/// nothing, or a `Result` of these whose error is `Thrown`. A panic becomes the exception
/// `::genom::unkex`. `component!` must list the codel.
#[proc_macro_attribute]
pub fn codel(attribute: TokenStream, item: TokenStream) -> TokenStream {
    let function = parse_macro_input!(item as ItemFn);
    codel::expand(&attribute.into(), &function)
        .unwrap_or_else(|error| {
            let error = error.to_compile_error();
            quote::quote! { #function #error }
        })
        .into()
}

/// Gives a `#[repr(C)]` struct or a fieldless enum its IDL type.
///
/// The name is that of the `.gen` file: `#[genom(name = "::demo::state")]`. Members keep their
/// order and names; `r#type` stands for `type`. An enum is stored as `Enum<E>`.
#[proc_macro_derive(Data, attributes(genom))]
pub fn derive_data(input: TokenStream) -> TokenStream {
    finish(data::derive_data(&parse_macro_input!(input as DeriveInput)))
}

/// Makes an exception of a `#[repr(C)]` struct of its detail, or of a unit struct.
///
/// The name is that of the `.gen` file: `#[genom(name = "::demo::OUT_OF_RANGE")]`.
#[proc_macro_derive(Exception, attributes(genom))]
pub fn derive_exception(input: TokenStream) -> TokenStream {
    finish(data::derive_exception(&parse_macro_input!(input as DeriveInput)))
}

/// Makes a type the contents of a `native`, named `#[genom(name = "::demo::driver")]`.
#[proc_macro_derive(NativeType, attributes(genom))]
pub fn derive_native(input: TokenStream) -> TokenStream {
    finish(data::derive_native(&parse_macro_input!(input as DeriveInput)))
}

/// Makes the type of a remote: a service of another component, called by codels.
///
/// The parameters are those of the service, written as for a codel:
///
/// ```text
/// genom::remote! {
///     /// Service `plan` of interface `planner`.
///     pub struct Plan(distance: f64, from: &Point, path: &mut Sequence<Point>);
/// }
/// ```
///
/// A codel takes a `&mut Plan` and calls `plan.call(1.0, &from, &mut path, context)`, which
/// waits for the service; its error is the exception of the service, for the codel to return or
/// to handle.
#[proc_macro]
pub fn remote(input: TokenStream) -> TokenStream {
    finish(remote::expand(&parse_macro_input!(input as Remote)))
}

/// The sources of this crate, as an array of names and texts: for `genom::sources`, since a crate
/// of macros can export nothing else.
#[doc(hidden)]
#[proc_macro]
pub fn sources(_: TokenStream) -> TokenStream {
    sources::expand().into()
}

fn finish(expansion: syn::Result<proc_macro2::TokenStream>) -> TokenStream {
    expansion.unwrap_or_else(|error| error.to_compile_error()).into()
}
