//! An out port as the sending thread sees it.

use std::sync::Arc;

use genom_kit::outlet::Outlet;
use genom_kit::sender;

use crate::bottle::encode;
use crate::out_port::OutPort;
use crate::wire::{self, Purpose};

/// An out port as the sending thread sees it.
pub(crate) struct Line {
    pub(crate) outlet: Arc<Outlet>,
    pub(crate) out: Arc<OutPort>,
}

impl sender::Line for Line {
    fn send(&mut self) -> bool {
        let Some(sample) = self.outlet.take() else { return false };
        let mut message = Vec::with_capacity(wire::HEADER + sample.as_ref().len() * 2 + 64);
        wire::begin(Purpose::Data { reply: false }, &mut message);
        match encode::append(&self.out.ty, sample.as_ref(), &mut message) {
            Ok(()) => {
                wire::close(&mut message);
                self.out.send(Arc::new(message));
            }
            Err(_) => self.outlet.refuse(),
        }
        true
    }
}
