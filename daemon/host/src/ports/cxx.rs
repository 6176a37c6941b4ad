//! Methods of ports for codels in C++ (genom3.md 6): failures are thrown.

use genom_description::model::PortDirection;

use super::buffers::Buffers;
use super::element::Failure;
use super::methods::exception;
use super::multiple::{ENAMETOOLONG, LONGEST};
use crate::cxx::{Action, CxxPort};

/// A port of a component in C++.
pub(super) struct PortInCxx {
    pub(super) direction: PortDirection,
    pub(super) buffers: Buffers,
}

impl PortInCxx {
    /// The failure when there is no such element, or no value yet.
    fn absent(&self) -> Failure {
        match self.direction {
            PortDirection::In => Failure::NoSuchInport,
            PortDirection::Out => Failure::NoSuchOutport,
        }
    }

    fn element(
        &self,
        id: Option<&[u8]>,
    ) -> Result<std::sync::Arc<super::element::Element>, Failure> {
        match &self.buffers {
            Buffers::Simple(element) => Ok(std::sync::Arc::clone(element)),
            Buffers::Multiple(elements) => {
                id.and_then(|id| elements.get(id)).ok_or_else(|| self.absent())
            }
        }
    }

    fn try_act(&self, action: Action, id: Option<&[u8]>) -> Result<(), Failure> {
        match (action, &self.buffers) {
            (Action::Read, _) => self.element(id)?.read(),
            (Action::Write, _) => self.element(id)?.write(),
            (Action::Open, Buffers::Multiple(elements)) => match id {
                Some(name) if name.len() > LONGEST => Err(Failure::System(ENAMETOOLONG)),
                name => elements.open(name),
            },
            (Action::Close, Buffers::Multiple(elements)) => elements.close(id),
            (Action::Open | Action::Close, Buffers::Simple(_)) => Err(Failure::PortIo),
        }
    }
}

impl CxxPort for PortInCxx {
    fn data(&self, id: Option<&[u8]>) -> Result<usize, (&'static str, Vec<u8>)> {
        let data = self.element(id).map(|element| element.data());
        // Codels in C get NULL before the first value, but a reference cannot be null.
        let data = data.and_then(|at| if at == 0 { Err(self.absent()) } else { Ok(at) });
        data.map_err(|failure| exception(&failure))
    }

    fn act(&self, action: Action, id: Option<&[u8]>) -> Result<(), (&'static str, Vec<u8>)> {
        self.try_act(action, id).map_err(|failure| exception(&failure))
    }
}
