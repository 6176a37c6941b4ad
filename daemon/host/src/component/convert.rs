//! `native` data of a library, made from that of another one by a function which it exports
//! (`genom/reload.h`). One of the few unsafe modules.
#![allow(unsafe_code)]

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{CString, c_char, c_int, c_void};

use genom_types::native::{self, Former, NotConverted, Pair, declared, symbol};
use genom_types::{DataType, Record};

use super::Component;

/// `genom_conversion` in C.
#[repr(C)]
struct About {
    size: u32,
    instance: *const c_char,
    member: *const c_char,
    old_type: *const c_char,
    old_version: *const c_char,
    old_digest: *const c_char,
}

type Function = unsafe extern "C" fn(*const c_void, *mut *mut c_void, *const About) -> c_int;

/// The functions of a library that convert native data of its IDS.
pub struct Conversions<'a> {
    /// By the name of the native type in C. They stay where they are as long as the component.
    functions: BTreeMap<String, usize>,
    /// Keeps the library open.
    _component: &'a Component,
}

impl Component {
    /// Finds the functions that convert native data in the IDS of this type, which are its own.
    #[must_use]
    pub fn conversions(&self, ids: &DataType) -> Conversions<'_> {
        let code = self.inner.code.get();
        let mut functions = BTreeMap::new();
        for member in declared(ids).into_values() {
            if let Some(at) = code.library.own_symbol(&symbol(&member.name)) {
                functions.insert(member.name, at);
            }
        }
        Conversions { functions, _component: self }
    }
}

impl Conversions<'_> {
    /// Whether there is one for a native type of this name in C; for any, without a name.
    #[must_use]
    pub fn offers(&self, native: Option<&str>) -> bool {
        native.map_or(!self.functions.is_empty(), |native| self.functions.contains_key(native))
    }

    /// Calls them for native data in `to`, the IDS of this component, with what stands in `from`, those
    /// of the one before; no codel of either runs. Returns the members that were converted.
    ///
    /// # Errors
    /// A function refused; `to` holds what it and those before it made.
    pub fn convert(
        &self,
        from: &Record,
        to: &mut Record,
        former: Former<'_>,
    ) -> Result<BTreeSet<String>, NotConverted> {
        let (old, new) = (from.ty().clone(), to.ty().clone());
        let mut done = BTreeSet::new();
        native::for_each_pair(&old, &new, &mut |pair| {
            if let Some(function) = self.functions.get(pair.new.0) {
                self.call(*function, pair, from, to, former)?;
                done.insert(pair.plain.to_owned());
            }
            Ok(())
        })?;
        Ok(done)
    }

    fn call(
        &self,
        function: usize,
        pair: Pair<'_>,
        from: &Record,
        to: &mut Record,
        former: Former<'_>,
    ) -> Result<(), NotConverted> {
        let text = |text: &str| CString::new(text).unwrap_or_default();
        let instance = text(former.instance);
        let (member, old_type) = (text(pair.path), text(pair.old.0));
        let (version, digest) = (text(former.version), text(former.digest));
        let about = About {
            size: size_of::<About>() as u32,
            instance: instance.as_ptr(),
            member: member.as_ptr(),
            old_type: old_type.as_ptr(),
            old_version: version.as_ptr(),
            old_digest: digest.as_ptr(),
        };
        // SAFETY: at these offsets of values of their types are native members, which are pointers. By
        // its name the function has this signature (genom/reload.h); its library stays open.
        let status = unsafe {
            let before = from.as_ptr().add(pair.old.1).cast::<*const c_void>().read();
            let data = to.as_mut_ptr().add(pair.new.1).cast::<*mut c_void>();
            std::mem::transmute::<usize, Function>(function)(before, data, &about)
        };
        if status != 0 {
            let (function, member) = (symbol(pair.new.0), pair.path.to_owned());
            return Err(NotConverted { function, member, status });
        }
        Ok(())
    }
}
