//! Out ports on middlewares that only connections ask for: opened with the first connection over
//! it, closed with the last.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use genom_configuration::BackendNames;
use genom_description::model::PortDirection;
use genom_middleware::Address;
use genom_ports::{Need, PortKey};

use super::core::Connections;
use super::error::{ConnectError, Kind};
use super::find::{Inlet, split};
use super::opening::BindError;
use crate::components::Hosted;

impl Connections {
    /// Makes the connection of an in port, when what it needs is open. What the connection before
    /// needed, and nobody else, is closed.
    pub(super) fn with_end<T>(
        &self,
        reader: &Address,
        need: Option<Need>,
        make: impl FnOnce() -> Result<T, ConnectError>,
    ) -> Result<T, ConnectError> {
        let needs = &self.opening.needs;
        if need.is_none() && !needs.has(reader) {
            return make();
        }
        let _turn = needs.turn();
        let had = needs.put(reader, need.clone());
        let opened = need.as_ref().map_or(Ok(()), |need| self.open_end(need));
        let made = opened.and_then(|()| make());
        let unused = match &made {
            Ok(_) => had.filter(|had| Some(had) != need.as_ref()),
            Err(_) => {
                needs.put(reader, had);
                need
            }
        };
        if let Some(unused) = unused {
            self.close_unneeded(&unused.outport);
        }
        made
    }

    /// Removes the connection of an in port, and closes what only it needed.
    pub(super) fn without_end<E>(
        &self,
        reader: &Address,
        remove: impl FnOnce() -> Result<bool, E>,
    ) -> Result<bool, E> {
        let needs = &self.opening.needs;
        let _turn = needs.has(reader).then(|| needs.turn());
        let removed = remove()?;
        if let Some(had) = needs.put(reader, None) {
            self.close_unneeded(&had.outport);
        }
        Ok(removed)
    }

    /// Opens out ports of a component on the middlewares over which readers in other processes are
    /// to read them, and closes those that no connection needs any more. A port that is not open,
    /// or whose component is not loaded yet, is opened there when it is.
    ///
    /// # Errors
    /// Why the first one that is new cannot be opened. Those are not kept, the others are.
    pub fn need_elsewhere(
        &self,
        component: &str,
        ports: &BTreeMap<String, BackendNames>,
    ) -> Result<(), ConnectError> {
        let needs = &self.opening.needs;
        let wanted: BTreeMap<Address, BTreeSet<String>> = ports
            .iter()
            .map(|(port, over)| {
                (Address::new(component, port), over.names().iter().cloned().collect())
            })
            .collect();
        // Before others have to wait: a middleware may have to be started.
        let mut refused: Vec<(Need, ConnectError)> = self.unreachable(component, &wanted);
        let _turn = needs.turn();
        let before = needs.put_far(component, wanted.clone());
        refused.iter().for_each(|(need, _)| needs.refuse_far(need));
        for (outport, over) in wanted {
            let known = before.get(&outport);
            for over in over {
                let need = Need { outport: outport.clone(), over };
                if refused.iter().any(|(one, _)| *one == need) {
                    continue;
                }
                match self.open_end(&need) {
                    Ok(()) => {}
                    // Tried again by `keep_ends`.
                    Err(_) if known.is_some_and(|known| known.contains(&need.over)) => {}
                    Err(error) => {
                        needs.refuse_far(&need);
                        refused.push((need, error));
                    }
                }
            }
        }
        before.keys().for_each(|outport| self.close_unneeded(outport));
        match refused.into_iter().next() {
            None => Ok(()),
            Some((_, error)) => Err(error),
        }
    }

    /// What cannot be read in another process, because its middleware cannot be opened, or does not
    /// leave this one.
    fn unreachable(
        &self,
        component: &str,
        wanted: &BTreeMap<Address, BTreeSet<String>>,
    ) -> Vec<(Need, ConnectError)> {
        // One that is not here is opened when it is, if ever.
        if self.components.get(component).is_none() {
            return Vec::new();
        }
        let needs = wanted.iter().flat_map(|(outport, over)| {
            over.iter().map(|over| Need { outport: outport.clone(), over: over.clone() })
        });
        let refused = needs.filter_map(|need| match self.backends.get(&need.over) {
            Ok(middleware) if middleware.capabilities().cross_process => None,
            Ok(_) => {
                let (outport, over) = (need.outport.to_string(), need.over.clone());
                Some((need, ConnectError::Stays { outport, over }))
            }
            Err(error) => Some((need, ConnectError::Backend(error))),
        });
        refused.collect()
    }

    /// Opens an out port of this process where a connection needs it.
    fn open_end(&self, need: &Need) -> Result<(), ConnectError> {
        let Need { outport, over } = need;
        let Some((hosted, key)) = self.written(outport) else { return Ok(()) };
        if hosted.backends_of(&key).has(over) {
            return Ok(());
        }
        let opened = self.lend(&hosted, &key, |mut lent| {
            lent.push(over.clone());
            lent
        });
        let opened = opened.map_err(|error| match error {
            BindError::Backend(error) => ConnectError::Backend(error),
            BindError::HeldUp(error) => ConnectError::HeldUp(error),
            source => ConnectError::End {
                outport: outport.to_string(),
                over: over.clone(),
                source: Box::new(source),
            },
        })?;
        if opened {
            tracing::info!("{outport} is on {over}, too, as long as a connection needs that");
        }
        Ok(())
    }

    /// Closes an out port of this process where no connection needs it any more.
    fn close_unneeded(&self, outport: &Address) {
        let Some((hosted, key)) = self.written(outport) else { return };
        let needed = self.opening.needs.of(outport);
        let mut leave = hosted.ties.lent(&key);
        leave.retain(|name| !needed.contains(name));
        if leave.is_empty() {
            return;
        }
        let closed = self.lend(&hosted, &key, |mut lent| {
            lent.retain(|name| needed.contains(name));
            lent
        });
        let leave = leave.join(", ");
        match closed {
            Ok(_) => tracing::info!("{outport} is no longer on {leave}: no connection needs that"),
            // Tried again by `keep_ends`.
            Err(error) => tracing::debug!("{outport} stays on {leave}: {error}"),
        }
    }

    /// Puts an out port on its own middlewares and on others, which are chosen of those it is on
    /// beyond its own now. Returns whether it is open.
    fn lend(
        &self,
        hosted: &Hosted,
        key: &PortKey,
        choose: impl FnOnce(Vec<String>) -> Vec<String>,
    ) -> Result<bool, BindError> {
        let _turn = hosted.ties.bindings.turn();
        let Some(fan) = hosted.ties.fan(key) else { return Ok(false) };
        let own = hosted.own_backends_of(key);
        let mut lent = choose(hosted.ties.lent(key));
        lent.retain(|name| !own.has(name));
        let Some(new) = self.new_ends(hosted, key.clone(), fan, &own, lent)? else {
            return Ok(false);
        };
        let old = hosted.excluded(|| new.exchange(hosted))?;
        drop(old);
        Ok(true)
    }

    /// The out port of this process at an address.
    fn written(&self, outport: &Address) -> Option<(Arc<Hosted>, PortKey)> {
        let hosted = self.components.get(&outport.instance)?;
        let (name, element) = split(outport);
        let ports = &hosted.model().ports;
        let port = ports.find(|port| port.name == name && port.direction == PortDirection::Out)?;
        (ports[port].multiple == element.is_some())
            .then(|| (Arc::clone(&hosted), PortKey::new(port, element)))
    }

    /// Closes what connections needed that went with their components, and opens again what could
    /// not be opened when its component was loaded. Unless a connection is being made: that may take
    /// longer than others should wait.
    pub(super) fn keep_ends(&self) {
        let needs = &self.opening.needs;
        let Some(_turn) = needs.try_turn() else { return };
        for (reader, need) in needs.readers() {
            if !self.reads_over(&reader, &need) {
                needs.put(&reader, None);
            }
        }
        for need in needs.all() {
            if let Err(error) = self.open_end(&need) {
                tracing::debug!("{}", error.sentence());
            }
        }
        for hosted in self.components.all() {
            for key in hosted.ties.all_lent() {
                self.close_unneeded(&hosted.port_address(&key));
            }
        }
    }

    /// Whether an in port is connected so.
    fn reads_over(&self, reader: &Address, need: &Need) -> bool {
        let Ok(Inlet::Port(hosted, key)) = self.inlet(&reader.to_string(), Some(Kind::Port)) else {
            return false;
        };
        let made = hosted.ties.connection(&key);
        made.is_some_and(|made| {
            made.fixed && made.outport == need.outport && made.backend == need.over
        })
    }
}
