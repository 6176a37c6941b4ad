//! Reads the table that the Rust SDK exports, as owned values. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::collections::HashMap;
use std::ffi::{CStr, c_char};

use genom::abi;

use crate::library::Library;

/// Why a table is rejected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum TableError {
    /// Built with another major version of the SDK.
    #[error(
        "built with version {found} of the plugin interface, this daemon knows {}: rebuild the \
         component",
        abi::ABI_MAJOR
    )]
    Version {
        /// Version of the library.
        found: u16,
    },
    /// The table is smaller than its version requires.
    #[error("the table of codels has {found} bytes, {} needed", size_of::<abi::Component>())]
    Size {
        /// Size in the table.
        found: u32,
    },
}

/// The content of the table.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) codels: Vec<Codel>,
    /// Exceptions, by index in `types`.
    pub(super) exceptions: Vec<usize>,
    pub(super) types: Vec<Type>,
}

/// A codel of the table.
#[derive(Debug)]
pub(super) struct Codel {
    pub(super) name: String,
    pub(super) arguments: Vec<Argument>,
}

/// An argument of a codel; its type by index in [`Table::types`].
#[derive(Debug)]
pub(super) struct Argument {
    pub(super) name: String,
    pub(super) passing: abi::Passing,
    pub(super) ty: Option<usize>,
}

/// A type of the table; other types by index in [`Table::types`].
#[derive(Clone, Debug)]
pub(super) struct Type {
    pub(super) kind: abi::Kind,
    pub(super) name: Option<String>,
    pub(super) size: usize,
    pub(super) align: usize,
    pub(super) bound: usize,
    pub(super) element: Option<usize>,
    pub(super) members: Vec<Member>,
}

/// A member of a struct, or an enumerator.
#[derive(Clone, Debug)]
pub(super) struct Member {
    pub(super) name: String,
    pub(super) offset: usize,
    pub(super) ty: Option<usize>,
}

/// Reads the table of `library`, if it has one.
pub(super) fn read(library: &Library) -> Result<Option<Table>, TableError> {
    let symbol = abi::COMPONENT_SYMBOL.to_str().unwrap_or_default();
    let Some(at) = library.own_symbol(symbol) else { return Ok(None) };
    let at = at as *const abi::Component;
    // SAFETY: the symbol is the SDK's table, whose first fields are the same in all versions.
    let (found, size) = unsafe { ((*at).abi_major, (*at).size) };
    if found != abi::ABI_MAJOR {
        return Err(TableError::Version { found });
    }
    if (size as usize) < size_of::<abi::Component>() {
        return Err(TableError::Size { found: size });
    }
    // SAFETY: the version is known, and the table is at least as large as what is read; it is
    // constant data of the library, which is loaded.
    let table = unsafe { &*at };
    let mut reader = Reader { types: Vec::new(), known: HashMap::new() };
    // SAFETY: as above, for all lists and pointers in it.
    let (codels, exceptions) = unsafe {
        let codels = table.codels.as_slice().iter().map(|codel| reader.codel(codel)).collect();
        let exceptions = table.exceptions.as_slice().iter();
        (codels, exceptions.filter_map(|ty| reader.ty(*ty)).collect())
    };
    Ok(Some(Table { codels, exceptions, types: reader.types }))
}

/// Reads types, each once, since they may be recursive.
struct Reader {
    types: Vec<Type>,
    known: HashMap<usize, usize>,
}

impl Reader {
    /// # Safety
    /// The descriptor is part of a table of a loaded library.
    unsafe fn codel(&mut self, codel: &abi::CodelDescriptor) -> Codel {
        // SAFETY: the caller's promise.
        unsafe {
            let arguments = codel.arguments.as_slice().iter();
            let arguments = arguments.map(|argument| Argument {
                name: text(argument.name).unwrap_or_default(),
                passing: argument.passing,
                ty: self.ty(argument.ty),
            });
            Codel { arguments: arguments.collect(), name: text(codel.name).unwrap_or_default() }
        }
    }

    /// # Safety
    /// `ty` is null or a type of a table of a loaded library.
    unsafe fn ty(&mut self, ty: *const abi::TypeDescriptor) -> Option<usize> {
        if ty.is_null() {
            return None;
        }
        if let Some(&rank) = self.known.get(&(ty as usize)) {
            return Some(rank);
        }
        // SAFETY: the caller's promise.
        let descriptor = unsafe { &*ty };
        let rank = self.types.len();
        self.known.insert(ty as usize, rank);
        self.types.push(Type {
            kind: descriptor.kind,
            // SAFETY: the caller's promise.
            name: unsafe { text(descriptor.name) },
            size: descriptor.size,
            align: descriptor.align,
            bound: descriptor.bound,
            element: None,
            members: Vec::new(),
        });
        // SAFETY: the caller's promise, also for what the type points to.
        let (element, members) = unsafe {
            let members = descriptor.members.as_slice().iter().map(|member| Member {
                name: text(member.name).unwrap_or_default(),
                offset: member.offset,
                ty: self.ty(member.ty),
            });
            let members = members.collect();
            (self.ty(descriptor.element), members)
        };
        self.types[rank].element = element;
        self.types[rank].members = members;
        Some(rank)
    }
}

/// # Safety
/// `text` is null or a string of a table of a loaded library.
unsafe fn text(text: *const c_char) -> Option<String> {
    // SAFETY: the caller's promise.
    (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned())
}
