//! Memory of a component and of its activities, copied and put back. One of the few unsafe modules.
#![allow(unsafe_code)]

use genom_runtime::body::Memory as Saved;
use genom_types::{Record, foreign};

use super::frame::BoundFrame;
use super::inner::{Inner, Memory};
use crate::cxx::{Object, to_cxx};

impl Inner {
    /// A copy of the IDS in C layout.
    pub(super) fn ids_in_c(&self) -> Option<Record> {
        let ids = self.ids.as_ref()?;
        Some(match &ids.memory {
            Memory::C(record) => record.clone(),
            Memory::Cxx(object) => in_c(object),
        })
    }

    /// Sets the IDS, which no codel uses meanwhile.
    pub(super) fn set_ids(&self, from: &Record) {
        let Some(ids) = &self.ids else { return };
        let ty = match &ids.memory {
            Memory::C(record) => record.ty(),
            Memory::Cxx(object) => object.ty().c(),
        };
        if !ty.same_as(from.ty()) {
            tracing::error!("ids of another type: {} for {ty}", from.ty());
            return;
        }
        let at = ids.at as *mut u8;
        // SAFETY: the IDS live at this address as long as the component, and hold a value of this
        // type; the runtime excludes every codel (genom3.md 4.5).
        unsafe {
            match &ids.memory {
                Memory::C(_) => foreign::copy_value(ty, from.as_ptr(), at),
                Memory::Cxx(object) => to_cxx(object.ty(), from.as_ptr(), at),
            }
        }
    }
}

fn in_c(object: &Object) -> Record {
    let mut record = Record::new(object.ty().c());
    object.get(&mut record);
    record
}

impl BoundFrame {
    /// Copies of its records.
    pub(super) fn saved(&self) -> Saved {
        let (input, output, local) = match &self.objects {
            Some(all) => (in_c(&all.input), in_c(&all.output), in_c(&all.local)),
            None => (self.input.clone(), self.output.clone(), self.local.clone()),
        };
        Saved { input, output, local }
    }

    /// Sets its records.
    pub(super) fn put_back(&mut self, saved: &Saved) {
        let all = [&mut self.input, &mut self.output, &mut self.local];
        for (record, saved) in all.into_iter().zip([&saved.input, &saved.output, &saved.local]) {
            if let Err(why) = record.copy_from(saved) {
                tracing::error!("values of another service: {why}");
            }
        }
        if let Some(objects) = &mut self.objects {
            objects.changed();
            objects.input.set(&self.input);
            objects.output.set(&self.output);
            objects.local.set(&self.local);
        }
    }
}
