//! One run of a service or of a task's permanent activity: its records, and its codels with their
//! arguments bound. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::sync::Arc;

use genom_description::model::{CodelIx, Indexed, Owner, ServiceIx};
use genom_runtime::body::{Frame, Memory, Returned};
use genom_types::{Record, foreign};
use serde_json::{Value, json};

use super::call::{Call, Roots};
use super::codel::From;
use super::cxx::{CxxService, Objects};
use super::inner::Inner;
use super::last::Last;
use super::types::Copy;
use super::zones::{self, MemoryCheck, Watched};
use crate::crash_note;
use crate::cxx::Catcher;
use crate::detail::UNKEX;
use crate::events::EventCache;
use crate::last_words;
use crate::process;
use crate::running::{self, Doing};
use crate::what::WHAT;

/// Most bytes of the inputs of a service that the report of a crash has.
const INPUTS: usize = 4096;

/// In `ranks`: the codel belongs to another owner.
const ABSENT: u16 = u16::MAX;

/// The memory of one run, with codels bound to it.
pub(super) struct BoundFrame {
    pub(super) service: Option<ServiceIx>,
    pub(super) input: Record,
    pub(super) output: Record,
    pub(super) local: Record,
    /// Objects that codels in C++ use instead of the records.
    pub(super) objects: Option<Objects>,
    pub(super) calls: Box<[Call]>,
    /// For each codel of the component, its index in `calls`.
    pub(super) ranks: Indexed<CodelIx, u16>,
    pub(super) cache: EventCache,
    /// The code that it is of.
    pub(super) cached: u64,
    /// Guard zones of the memory that its codels may write to, and when to check them.
    pub(super) watched: Watched,
    pub(super) check: MemoryCheck,
    /// Message of the last C++ exception.
    pub(super) what: [u8; WHAT],
    /// Detail of the last exception.
    pub(super) detail: Box<[u64]>,
    pub(super) last: Last,
    /// What it is for, as the report of a crash tells it.
    pub(super) doing: Doing,
    // Declared, so dropped, after the records: code of the library may have to release their
    // buffers.
    pub(super) inner: Arc<Inner>,
}

// SAFETY: the pointers point into the frame's own records and into the component that it holds; one
// thread uses a frame at a time, as the runtime guarantees.
unsafe impl Send for BoundFrame {}

impl BoundFrame {
    /// Makes the memory and calls for one run of `owner`.
    pub(super) fn new(inner: &Arc<Inner>, owner: Owner) -> Self {
        let (service, codels) = match owner {
            Owner::Service(rank) => (Some(rank), inner.owned.services.get(rank)),
            Owner::Task(rank) => (None, inner.owned.tasks.get(rank)),
        };
        let types = service.and_then(|rank| inner.services.get(rank));
        let mut input = Record::new(types.map_or(&inner.nothing, |types| &types.input));
        let mut output = Record::new(types.map_or(&inner.nothing, |types| &types.output));
        let mut local = Record::new(types.map_or(&inner.nothing, |types| &types.local));
        let in_cxx = |service| inner.cxx.as_ref()?.services.get(service);
        let objects = service.and_then(in_cxx).map(Objects::new);
        let ids = inner.ids.as_ref().map_or(std::ptr::null_mut(), |ids| ids.at as *mut u8);
        let roots = match &objects {
            Some(objects) => Roots {
                ids,
                input: objects.input.at(),
                output: objects.output.at(),
                local: objects.local.at(),
            },
            None => Roots {
                ids,
                input: input.as_mut_ptr(),
                output: output.as_mut_ptr(),
                local: local.as_mut_ptr(),
            },
        };
        let mut watched = Watched::default();
        let around = match &objects {
            Some(objects) => [objects.input.zones(), objects.output.zones(), objects.local.zones()],
            None => [input.zones(), output.zones(), local.zones()],
        };
        let described = service.and_then(|rank| inner.described.services.get(rank));
        for (zones, described) in around.into_iter().zip(described.into_iter().flatten()) {
            // SAFETY: the frame owns the records and objects, and checks them only while it lives.
            unsafe { watched.add(zones, described) };
        }
        inner.watch(codels.map_or(&[], Vec::as_slice), &mut watched);
        let mut calls = Vec::new();
        let mut ranks = inner.codels.map(|_, _| ABSENT);
        for &codel in codels.into_iter().flatten() {
            let Some(Some(prepared)) = inner.codels.get(codel) else { continue };
            ranks[codel] = u16::try_from(calls.len()).unwrap_or(ABSENT);
            calls.push(Call::new(inner, codel, prepared, &roots));
        }
        Self {
            service,
            input,
            output,
            local,
            objects,
            calls: calls.into(),
            ranks,
            cache: EventCache::new(),
            cached: 0,
            watched,
            check: zones::mode(),
            what: [0; WHAT],
            detail: vec![0; inner.details.room().div_ceil(8)].into(),
            last: Last::Plain,
            doing: Doing {
                component: inner.instance.get().cloned().unwrap_or_default(),
                owner: owner_of(inner, codels.map_or(&[], Vec::as_slice)),
                ..Doing::default()
            },
            inner: Arc::clone(inner),
        }
    }

    /// Keeps the inputs in words, if a crash would be reported; large ones would cost too much.
    fn keep_inputs(&mut self, input: &Record) {
        self.doing.activity = 0;
        self.doing.inputs.clear();
        if !crash_note::is_kept() {
            return;
        }
        self.doing.inputs = match input.message_size() {
            size if size <= INPUTS => input.to_json().to_string(),
            size => format!("\"{size} bytes: not kept\""),
        };
    }

    /// Copies values between records and the IDS.
    fn copy(&self, copies: &[Copy], from: *const u8, to: *mut u8) {
        for Copy { from: source, to: target } in copies {
            // SAFETY: the roots hold values of the paths' root types; the runtime excludes every
            // codel that may change them meanwhile (genom3.md 4.5).
            let ends = unsafe { (source.locate(from.cast_mut()), target.locate(to)) };
            match ends {
                // SAFETY: as above; the input, the output and the IDS are different memory.
                (Some(from), Some(to)) => unsafe { foreign::copy_value(target.target(), from, to) },
                _ => tracing::error!("an attribute's element of a sequence in the ids is missing"),
            }
        }
    }

    /// The service's C++ types, and its objects.
    fn in_cxx(&mut self) -> Option<(&CxxService, &mut Objects, &Record)> {
        let types = self.inner.cxx.as_ref()?.services.get(self.service?)?;
        Some((types, self.objects.as_mut()?, &self.input))
    }

    fn ids(&self) -> *mut u8 {
        self.inner.ids.as_ref().map_or(std::ptr::null_mut(), |ids| ids.at as *mut u8)
    }
}

/// What these codels belong to.
fn owner_of(inner: &Inner, codels: &[CodelIx]) -> String {
    let mut prepared = codels.iter().filter_map(|codel| inner.codels.get(*codel)?.as_ref());
    prepared.next().map_or_else(String::new, |codel| codel.owner.clone())
}

impl Frame for BoundFrame {
    fn begin(&mut self, input: &Record) {
        self.last = Last::Plain;
        self.keep_inputs(input);
        if let Err(why) = self.input.copy_from(input) {
            tracing::error!("inputs of another service: {why}");
            self.input.clear();
        }
        if let Some((types, objects, input)) = self.in_cxx() {
            objects.begin(types, input);
            return;
        }
        self.output.clear();
        self.local.clear();
        let Some(types) = self.service.and_then(|rank| self.inner.services.get(rank)) else {
            return;
        };
        let (from, to) = (self.input.as_ptr(), self.output.as_mut_ptr());
        self.copy(&types.copies.inout, from, to);
    }

    fn number(&mut self, activity: u32) {
        // The number of a task's own codels means nothing outside.
        self.doing.activity = self.service.map_or(0, |_| activity);
    }

    fn store(&mut self) {
        let ids = self.ids();
        if let Some((types, objects, input)) = self.in_cxx() {
            let output = objects.output.at();
            objects.transfer(&types.copies.store, input, output, ids);
            objects.transfer(&types.copies.store_validated, input, output, ids);
            return;
        }
        let types = self.service.and_then(|rank| self.inner.services.get(rank));
        if let Some(types) = types {
            self.copy(&types.copies.store, self.input.as_ptr(), self.ids());
            self.copy(&types.copies.store_validated, self.output.as_ptr(), self.ids());
        }
    }

    fn fetch(&mut self) {
        let ids = self.ids();
        if let Some((types, objects, input)) = self.in_cxx() {
            objects.changed();
            objects.transfer(&types.copies.fetch, input, ids, objects.output.at());
            return;
        }
        let to = self.output.as_mut_ptr();
        let types = self.service.and_then(|rank| self.inner.services.get(rank));
        if let Some(types) = types {
            self.copy(&types.copies.fetch, self.ids(), to);
        }
    }

    fn save(&self) -> Option<Memory> {
        Some(self.saved())
    }

    fn restore(&mut self, memory: &Memory) {
        self.last = Last::Plain;
        self.keep_inputs(&memory.input);
        self.put_back(memory);
    }

    fn current(&mut self, inputs: &mut Record) {
        let ids = self.ids();
        if let Some((types, objects, input)) = self.in_cxx() {
            objects.transfer(&types.copies.current, input, ids, objects.input.at());
            objects.input.get(inputs);
            return;
        }
        let types = self.service.and_then(|rank| self.inner.services.get(rank));
        if let Some(types) = types {
            self.copy(&types.copies.current, self.ids(), inputs.as_mut_ptr());
        }
    }

    fn call(&mut self, codel: CodelIx, context: usize) -> Returned {
        let rank = self.ranks.get(codel).copied().unwrap_or(ABSENT);
        let inner = Arc::as_ptr(&self.inner);
        // SAFETY: the frame holds the component, and nothing drops it during this call.
        let inner = unsafe { &*inner };
        let code = inner.code.get();
        let (Some(call), Some(Some(prepared)), Some(Some(function)), Some(context)) = (
            self.calls.get_mut(usize::from(rank)),
            inner.codels.get(codel),
            code.functions.get(codel),
            inner.shared.contexts.get(context),
        ) else {
            return self.fail(format!("codel {codel} is none of this service"));
        };
        debug_assert_eq!(call.codel, codel);
        if self.cached != code.number {
            (self.cache, self.cached) = (EventCache::new(), code.number);
        }
        for i in 0..call.dynamic.len() {
            let (rank, root) = call.dynamic[i];
            let argument = &prepared.arguments[rank];
            let (From::Ids(way) | From::Input(way) | From::Output(way) | From::Local(way)) =
                &argument.from
            else {
                continue;
            };
            // SAFETY: the root holds a value of the path's root type; the runtime excludes those
            // who may change it (genom3.md 4.5).
            match unsafe { way.locate(root) } {
                Some(at) => call.set(rank, argument.class, at),
                None => {
                    let name = &argument.name;
                    return self.fail(format!(
                        "argument `{name}` of codel {}: the sequence has no such element",
                        prepared.name
                    ));
                }
            }
        }
        if let Some(last) = call.pointers.last_mut().filter(|_| prepared.context) {
            *last = context.pointer().cast_mut();
        }
        if let Some(objects) = &mut self.objects {
            objects.changed();
        }
        let mut catcher =
            inner.cxx.as_ref().map(|cxx| Catcher::new(&cxx.exceptions, &inner.details));
        context.enter();
        let codel = running::serving(&function.words, &self.doing);
        // SAFETY: the function was found under this name in the library, which stays loaded at least
        // until a moment at which no codel runs; the arguments point to data of the interface's classes, which the
        // runtime keeps from being changed.
        let returned = unsafe {
            let arguments = &mut call.arguments;
            prepared.interface.call(function.at, arguments, &mut self.what, catcher.as_mut())
        };
        if process::is_child() {
            last_words::child_came_back();
        }
        drop(codel);
        context.leave();
        match returned {
            Ok(event) => self.understand(event, prepared, context),
            Err(how) => match catcher.as_mut().and_then(Catcher::take) {
                Some((name, detail)) => self.thrown(name, detail),
                None => self.escaped(&prepared.name, how),
            },
        }
    }

    fn returned(&self) -> String {
        match &self.last {
            Last::Unknown(name, _) => name.clone(),
            Last::Failed(_) => UNKEX.to_owned(),
            Last::Plain | Last::Detailed(..) | Last::Told(_) => String::new(),
        }
    }

    fn detail(&self) -> Option<Value> {
        match &self.last {
            Last::Plain => None,
            Last::Unknown(_, detail) => detail.clone(),
            Last::Detailed(id, size) => {
                let name = self.inner.events.get(usize::from(id.0))?;
                self.inner.details.to_json(name, &self.detail, *size)
            }
            Last::Told(detail) => Some(detail.clone()),
            Last::Failed(what) => Some(json!({ "what": what })),
        }
    }

    fn output(&self) -> &Record {
        self.objects.as_ref().map_or(&self.output, Objects::output_in_c)
    }
}
