//! Expands the derives: layouts of structs, enums, exceptions and natives as constant descriptors.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Data, DataEnum, DeriveInput, Error, Fields, Result};

use crate::name::{c_string, full_name, has_repr, plain};

/// Expands `#[derive(Data)]`.
pub(crate) fn derive_data(input: &DeriveInput) -> Result<TokenStream> {
    match &input.data {
        Data::Struct(data) => {
            let ident = &input.ident;
            let descriptor = struct_descriptor(input, &data.fields, quote! { STRUCT })?;
            if data.fields.is_empty() {
                return Err(Error::new_spanned(ident, "an IDL struct has at least one member"));
            }
            Ok(quote! {
                // SAFETY: a struct of the C mapping is its members in order, as `#[repr(C)]`
                // lays them out, and each of them is `Data`.
                unsafe impl ::genom::Data for #ident {
                    const TYPE: *const ::genom::abi::TypeDescriptor = #descriptor;
                }

                impl ::genom::Aggregate for #ident {}
            })
        }
        Data::Enum(data) => derive_enum(input, data),
        Data::Union(_) => Err(Error::new_spanned(input, "IDL unions have no mapping yet")),
    }
}

/// Expands `#[derive(Exception)]`.
pub(crate) fn derive_exception(input: &DeriveInput) -> Result<TokenStream> {
    let Data::Struct(data) = &input.data else {
        return Err(Error::new_spanned(input, "an exception is a struct"));
    };
    let ident = &input.ident;
    let name = full_name(input)?;
    let descriptor = struct_descriptor(input, &data.fields, quote! { EXCEPTION })?;
    Ok(quote! {
        impl ::genom::Exception for #ident {
            const ID: &'static ::core::ffi::CStr = #name;
            const TYPE: *const ::genom::abi::TypeDescriptor = #descriptor;
        }
    })
}

/// Expands `#[derive(NativeType)]`.
pub(crate) fn derive_native(input: &DeriveInput) -> Result<TokenStream> {
    let ident = &input.ident;
    let name = full_name(input)?;
    Ok(quote! {
        impl ::genom::NativeType for #ident {
            const NAME: &'static ::core::ffi::CStr = #name;
        }
    })
}

/// The address of a struct's descriptor. The address of a static is known before its value is
/// computed, so that a struct may contain a sequence of itself.
fn struct_descriptor(
    input: &DeriveInput,
    fields: &Fields,
    kind: TokenStream,
) -> Result<TokenStream> {
    let ident = &input.ident;
    if !input.generics.params.is_empty() {
        return Err(Error::new_spanned(&input.generics, "IDL types are not generic"));
    }
    let packed = has_repr(&input.attrs, "packed") || has_repr(&input.attrs, "align");
    if !fields.is_empty() && (!has_repr(&input.attrs, "C") || packed) {
        return Err(Error::new_spanned(ident, "its layout must be that of C: add `#[repr(C)]`"));
    }
    let name = full_name(input)?;
    let mut members = Vec::new();
    for field in fields {
        let member = field.ident.as_ref().ok_or_else(|| {
            Error::new_spanned(field, "members have names: write `struct X { name: T }`")
        })?;
        let ty = &field.ty;
        let text = c_string(&plain(member));
        members.push(quote! {
            ::genom::abi::MemberDescriptor {
                name: #text.as_ptr(),
                offset: ::core::mem::offset_of!(#ident, #member),
                ty: <#ty as ::genom::Data>::TYPE,
            }
        });
    }
    Ok(quote! {{
        static MEMBERS: &[::genom::abi::MemberDescriptor] = &[#(#members),*];
        static DESCRIPTOR: ::genom::abi::TypeDescriptor = ::genom::abi::TypeDescriptor {
            kind: ::genom::abi::Kind::#kind,
            reserved: 0,
            name: #name.as_ptr(),
            size: ::core::mem::size_of::<#ident>(),
            align: ::core::mem::align_of::<#ident>(),
            bound: 0,
            element: ::core::ptr::null(),
            members: ::genom::abi::List::new(MEMBERS),
        };
        &raw const DESCRIPTOR
    }})
}

fn derive_enum(input: &DeriveInput, data: &DataEnum) -> Result<TokenStream> {
    let ident = &input.ident;
    let name = full_name(input)?;
    if data.variants.is_empty() {
        return Err(Error::new_spanned(ident, "an IDL enum has at least one value"));
    }
    let mut names = Vec::new();
    let mut variants = Vec::new();
    for variant in &data.variants {
        if !variant.fields.is_empty() || variant.discriminant.is_some() {
            let message = "values of an IDL enum count from 0 and carry no data";
            return Err(Error::new_spanned(variant, message));
        }
        names.push(c_string(&plain(&variant.ident)));
        variants.push(&variant.ident);
    }
    Ok(quote! {
        impl ::genom::Enumeration for #ident {
            const TYPE: *const ::genom::abi::TypeDescriptor = {
                static DESCRIPTOR: ::genom::abi::TypeDescriptor = ::genom::abi::TypeDescriptor {
                    kind: ::genom::abi::Kind::ENUM,
                    reserved: 0,
                    name: #name.as_ptr(),
                    size: 4,
                    align: 4,
                    bound: 0,
                    element: ::core::ptr::null(),
                    members: ::genom::abi::List::new(&[#(
                        ::genom::abi::MemberDescriptor {
                            name: #names.as_ptr(),
                            offset: 0,
                            ty: ::core::ptr::null(),
                        }
                    ),*]),
                };
                &raw const DESCRIPTOR
            };

            fn from_rank(rank: u32) -> ::core::option::Option<Self> {
                const VARIANTS: &[#ident] = &[#(#ident::#variants),*];
                VARIANTS.get(rank as usize).copied()
            }

            fn rank(self) -> u32 {
                self as u32
            }
        }
    })
}
