//! Expands `#[codel]`: generates the C function around a Rust function, and its descriptor.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use syn::{Error, ItemFn, Result, ReturnType, Type};

use crate::name::{c_string, plain};
use crate::parameter::{Form, form, is_context, name_and_type};

/// The parts of the expansion that belong to one parameter.
struct Argument {
    /// `name: CType`, in the signature of the C function.
    declaration: TokenStream,
    /// The statement that stores the C value.
    hold: TokenStream,
    /// The expression that is passed to the Rust function.
    lend: TokenStream,
    /// The expression of its descriptor in the exported table.
    descriptor: TokenStream,
}

pub(crate) fn expand(attribute: &TokenStream, function: &ItemFn) -> Result<TokenStream> {
    let signature = &function.sig;
    if !attribute.is_empty() {
        return Err(Error::new_spanned(attribute, "`codel` takes no argument"));
    }
    for (refused, what) in [
        (!signature.generics.params.is_empty(), "generic"),
        (signature.asyncness.is_some(), "async"),
        (signature.unsafety.is_some(), "unsafe"),
        (signature.abi.is_some(), "extern"),
        (signature.variadic.is_some(), "variadic"),
    ] {
        if refused {
            return Err(Error::new_spanned(signature, format!("a codel may not be {what}")));
        }
    }
    if let ReturnType::Type(_, ty) = &signature.output
        && matches!(**ty, Type::Never(_))
    {
        return Err(Error::new_spanned(ty, "a codel returns"));
    }

    let ident = &signature.ident;
    let symbol = plain(ident);
    let name = c_string(&symbol);
    let visibility = &function.vis;
    let count = signature.inputs.len();
    let mut context = quote! {};
    let mut arguments = Vec::new();
    for (rank, input) in signature.inputs.iter().enumerate() {
        let (parameter, ty) = name_and_type(input)?;
        if !is_context(ty) {
            arguments.push(argument(rank, &parameter, &form(ty)));
        } else if rank + 1 == count {
            context = quote! { &context };
        } else {
            return Err(Error::new_spanned(input, "the context is the last parameter"));
        }
    }
    let declarations = arguments.iter().map(|argument| &argument.declaration);
    let holds = arguments.iter().map(|argument| &argument.hold);
    let lends = arguments.iter().map(|argument| &argument.lend);
    let descriptors = arguments.iter().map(|argument| &argument.descriptor);

    Ok(quote! {
        #function

        #[doc(hidden)]
        #[allow(non_camel_case_types, unreachable_pub, missing_docs)]
        #visibility struct #ident {}

        const _: () = {
            #[unsafe(export_name = #symbol)]
            unsafe extern "C" fn codel(
                #(#declarations,)*
                context: *const ::genom::ContextInterface,
            ) -> *const ::core::ffi::c_char {
                // SAFETY: the host calls a codel with its context (genom3.md 5.6).
                let context = unsafe { ::genom::Context::from_raw(context) };
                ::genom::rt::guard(&context, || {
                    #(#holds)*
                    #ident(#(#lends,)* #context)
                })
            }

            impl ::genom::Codel for #ident {
                const DESCRIPTOR: ::genom::abi::CodelDescriptor =
                    ::genom::abi::CodelDescriptor {
                        name: #name.as_ptr(),
                        function: codel as *const ::core::ffi::c_void,
                        arguments: ::genom::abi::List::new(const { &[#(#descriptors),*] }),
                    };
            }
        };
    })
}

fn argument(rank: usize, name: &str, form: &Form<'_>) -> Argument {
    let held = format_ident!("argument_{rank}");
    let (path, hold, lend, passing) = match form {
        Form::Value(ty) => {
            let path = quote! { <#ty as ::genom::ByValue> };
            let lend = quote! { #path::from_abi(#held) };
            (path, quote! {}, lend, quote! { ::genom::abi::Passing::VALUE })
        }
        Form::Shared(ty) => {
            let path = quote! { <#ty as ::genom::ByRef> };
            let hold = quote! { let #held = unsafe { #path::hold(#held) }; };
            let lend = quote! { #path::lend(&#held) };
            let passing = quote! { #path::PASSING };
            (path, hold, lend, passing)
        }
        Form::Exclusive(ty) => {
            let path = quote! { <#ty as ::genom::ByMut> };
            let hold = quote! { let mut #held = unsafe { #path::hold(#held) }; };
            let lend = quote! { #path::lend(&mut #held) };
            let passing = quote! { #path::PASSING };
            (path, hold, lend, passing)
        }
    };
    let name = c_string(name);
    Argument {
        declaration: quote! { #held: #path::Abi },
        hold,
        lend,
        descriptor: quote! {
            ::genom::abi::ArgumentDescriptor {
                name: #name.as_ptr(),
                passing: #passing,
                reserved: 0,
                ty: #path::TYPE,
            }
        },
    }
}
