//! A port of ours on YARP: a name, an address at which it listens, and what it does.

use std::net::SocketAddr;
use std::sync::Arc;

use crate::desk::Desk;
use crate::in_port::InPort;
use crate::out_port::OutPort;

/// A port. Shared by the thread of connections and by who opened it.
pub(crate) struct Port {
    /// Differs between all ports of a middleware.
    pub(crate) id: u64,
    pub(crate) name: String,
    pub(crate) at: SocketAddr,
    pub(crate) role: Role,
}

/// What a port does.
pub(crate) enum Role {
    /// Sends samples.
    Out(Arc<OutPort>),
    /// Receives samples.
    In(Arc<InPort>),
    /// Answers requests.
    Rpc(Arc<Desk>),
}

impl Port {
    /// Name of the type of its messages; empty if there is no single one.
    pub(crate) fn type_name(&self) -> &str {
        match &self.role {
            Role::Out(port) => port.ty.name(),
            Role::In(port) => port.ty.name(),
            Role::Rpc(_) => "",
        }
    }

    /// Greatest size of a message that it takes, which is at most `most`.
    pub(crate) fn largest(&self, most: usize) -> usize {
        match &self.role {
            // All that it takes is administration.
            Role::Out(_) => 1 << 16,
            Role::In(port) => crate::bottle::decode::most(&port.ty).unwrap_or(most).min(most),
            Role::Rpc(_) => most,
        }
    }
}
