//! Which ports and services exist: what the name server lists, and what ports of genomd say of
//! themselves there.

use std::sync::PoisonError;

use genom_middleware::{Address, DiscoverError, Discovery, Endpoint, EndpointKind};

use crate::backend::Yarp;
use crate::core::Core;
use crate::desks::RPC;
use crate::error::{BACKEND, NameError};
use crate::mark::{self, Mark};
use crate::names::{Contact, is_name};

impl Core {
    /// What a listed port says of itself. Asked for once for each port of others, but for services,
    /// which change.
    fn said_of(&self, contact: &Contact) -> Result<Option<Mark>, NameError> {
        if let Some(own) = self.own(&contact.name) {
            return Ok(Some(own));
        }
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(mark) = known.get(contact) {
            return Ok(mark.clone());
        }
        drop(known);
        let mark = Mark::parse(&self.names.get(&contact.name, mark::PROPERTY)?);
        if matches!(mark, Some(Mark::In(_) | Mark::Out(_))) {
            let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
            known.insert(contact.clone(), mark.clone());
        }
        Ok(mark)
    }

    fn list(&self) -> Result<Vec<Endpoint>, NameError> {
        let listed = self.names.list("")?;
        let there: std::collections::HashSet<&Contact> = listed.iter().collect();
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.retain(|contact, _| there.contains(contact));
        drop(known);
        let mut ends = Vec::new();
        for contact in &listed {
            let is_port = is_name(&contact.name) && contact.carrier == "tcp";
            if !is_port || contact.name == self.settings.namespace {
                continue;
            }
            let mark = self.said_of(contact)?;
            self.append(contact, mark, &mut ends);
        }
        Ok(ends)
    }

    /// Whether a port is there that serves an address, as far as is known: a server that is no
    /// genomd's does not say what it serves.
    fn may_serve(&self, at: &Address) -> Result<bool, NameError> {
        let (port, word) = self.server_of(at);
        if word.is_empty() || !is_name(&port) || port == self.settings.namespace {
            return Ok(false);
        }
        let Some(contact) = self.names.query(&port)? else { return Ok(false) };
        Ok(match self.said_of(&contact)? {
            None => true,
            Some(Mark::Rpc(names)) => names.contains(&word),
            Some(Mark::In(_) | Mark::Out(_)) => false,
        })
    }

    /// The ends that a port stands for. One that is no genomd's may be read, as far as is known.
    fn append(&self, contact: &Contact, mark: Option<Mark>, ends: &mut Vec<Endpoint>) {
        let address = contact.name.trim_start_matches('/').to_owned();
        let mut add = |kind, address, ty| ends.push(Endpoint { kind, address, ty });
        match mark {
            None => add(EndpointKind::Publisher, address, String::new()),
            Some(Mark::Out(ty)) => add(EndpointKind::Publisher, address, ty.name),
            Some(Mark::In(ty)) => {
                let read = address.rsplit_once(":i/").map(|(read, _)| read.to_owned());
                add(EndpointKind::Subscription, read.unwrap_or(address), ty.name);
            }
            Some(Mark::Rpc(names)) => {
                let component = address.strip_suffix(RPC).unwrap_or(&address);
                for name in names {
                    add(EndpointKind::Service, format!("{component}{name}"), String::new());
                }
            }
        }
    }
}

fn failed(error: NameError) -> DiscoverError {
    DiscoverError { backend: BACKEND.to_owned(), why: error.to_string() }
}

impl Discovery for Yarp {
    fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError> {
        self.core.list().map_err(failed)
    }

    fn ends_at(&self, at: &Address) -> Result<Vec<Endpoint>, DiscoverError> {
        let address = self.spelled(at);
        let mut ends = self.discover()?;
        ends.retain(|end| end.address == address);
        let listed = ends.iter().any(|end| end.kind == EndpointKind::Service);
        if !listed && self.core.may_serve(at).map_err(failed)? {
            ends.push(Endpoint { kind: EndpointKind::Service, address, ty: String::new() });
        }
        Ok(ends)
    }

    fn spelled(&self, at: &Address) -> String {
        self.core.name_of(at).trim_start_matches('/').to_owned()
    }
}
