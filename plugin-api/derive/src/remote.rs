//! Expands `remote!`: generates a type that calls a service of another component.

use proc_macro2::TokenStream;
use quote::quote;
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Attribute, FnArg, Ident, Result, Token, Visibility, parenthesized};

use crate::name::c_string;
use crate::parameter::{Form, form, name_and_type};

/// `pub struct Plan(distance: f64, path: &mut Path);`
pub(crate) struct Remote {
    attributes: Vec<Attribute>,
    visibility: Visibility,
    ident: Ident,
    parameters: Punctuated<FnArg, Token![,]>,
}

impl Parse for Remote {
    fn parse(input: ParseStream<'_>) -> Result<Self> {
        let attributes = input.call(Attribute::parse_outer)?;
        let visibility = input.parse()?;
        input.parse::<Token![struct]>()?;
        let ident = input.parse()?;
        let parameters;
        parenthesized!(parameters in input);
        let parameters = parameters.parse_terminated(FnArg::parse, Token![,])?;
        input.parse::<Token![;]>()?;
        Ok(Self { attributes, visibility, ident, parameters })
    }
}

pub(crate) fn expand(remote: &Remote) -> Result<TokenStream> {
    let Remote { attributes, visibility, ident, parameters } = remote;
    let mut abis = Vec::new();
    let mut values = Vec::new();
    let mut members = Vec::new();
    for parameter in parameters {
        let (name, ty) = name_and_type(parameter)?;
        let FnArg::Typed(typed) = parameter else { continue };
        let variable = &typed.pat;
        let (abi, value, passing, described) = match form(ty) {
            Form::Value(ty) => (
                quote! { <#ty as ::genom::ByValue>::Abi },
                quote! { <#ty as ::genom::ByValue>::into_abi(#variable) },
                quote! { ::genom::abi::Passing::VALUE },
                quote! { <#ty as ::genom::ByValue>::TYPE },
            ),
            Form::Shared(ty) => (
                quote! { <#ty as ::genom::ByRef>::Abi },
                quote! { <#ty as ::genom::ByRef>::to_abi(#variable) },
                quote! { <#ty as ::genom::ByRef>::PASSING },
                quote! { <#ty as ::genom::ByRef>::TYPE },
            ),
            Form::Exclusive(ty) => (
                quote! { *mut #ty },
                quote! { ::core::ptr::from_mut::<#ty>(#variable) },
                quote! { ::genom::abi::Passing::EXCLUSIVE },
                quote! { <#ty as ::genom::Data>::TYPE },
            ),
        };
        let name = c_string(&name);
        abis.push(abi);
        values.push(value);
        members.push(quote! {
            ::genom::abi::MemberDescriptor {
                name: #name.as_ptr(),
                offset: #passing.0 as usize,
                ty: #described,
            }
        });
    }
    let parameters = parameters.iter();
    Ok(quote! {
        #(#attributes)*
        #visibility struct #ident(::genom::rt::Handle);

        impl #ident {
            /// Calls the service and waits for its end.
            ///
            /// # Errors
            /// The exception the service ended with, or one that says why it was not reached.
            #visibility fn call(
                &mut self,
                #(#parameters,)*
                context: &::genom::Context,
            ) -> ::core::result::Result<(), ::genom::Thrown> {
                type Call = unsafe extern "C" fn(
                    #(#abis,)*
                    *const ::genom::ContextInterface,
                ) -> *const ::core::ffi::c_char;
                // SAFETY: the method of this remote has these parameters: the host compared
                // them with the `.gen` file. What they point to stays borrowed meanwhile.
                ::genom::rt::call(context, |context| unsafe {
                    (self.0.method::<Call>())(#(#values,)* context)
                })
            }
        }

        impl ::genom::ByMut for #ident {
            type Abi = ::genom::rt::Handle;
            type Held = Self;
            const PASSING: ::genom::abi::Passing = ::genom::abi::Passing::REMOTE;
            const TYPE: *const ::genom::abi::TypeDescriptor = {
                static MEMBERS: &[::genom::abi::MemberDescriptor] = &[#(#members),*];
                static DESCRIPTOR: ::genom::abi::TypeDescriptor = ::genom::abi::TypeDescriptor {
                    kind: ::genom::abi::Kind::REMOTE,
                    reserved: 0,
                    name: ::core::ptr::null(),
                    size: 0,
                    align: 1,
                    bound: 0,
                    element: ::core::ptr::null(),
                    members: ::genom::abi::List::new(MEMBERS),
                };
                &raw const DESCRIPTOR
            };

            unsafe fn hold(abi: ::genom::rt::Handle) -> Self {
                Self(abi)
            }

            fn lend(held: &mut Self) -> &mut Self {
                held
            }
        }
    })
}
