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
    /// One cannot be opened; nothing is changed then.
    pub fn need_elsewhere(
        &self,
        component: &str,
        ports: &BTreeMap<String, BackendNames>,
    ) -> Result<(), ConnectError> {
        let needs = &self.opening.needs;
        let wanted: BTreeMap<Address, BTreeSet<String>> = ports
            .iter()
            .map(|(port, over)| (Address::new(component, port), over.names().to_vec()))
            .map(|(outport, over)| (outport, over.into_iter().collect()))
            .collect();
        let _turn = needs.turn();
        let before = needs.put_far(component, wanted.clone());
        let opened = wanted.iter().try_for_each(|(outport, over)| {
            over.iter().try_for_each(|over| {
                self.open_end(&Need { outport: outport.clone(), over: over.clone() })
            })
        });
        let unneeded = match opened {
            Ok(()) => before,
            Err(_) => needs.put_far(component, before),
        };
        unneeded.keys().for_each(|outport| self.close_unneeded(outport));
        opened
    }

    /// Opens an out port of this process where a connection needs it.
    fn open_end(&self, need: &Need) -> Result<(), ConnectError> {
        let Need { outport, over } = need;
        let Some((hosted, key)) = self.written(outport) else { return Ok(()) };
        if hosted.backends_of(&key).has(over) {
            return Ok(());
        }
        let mut lent = hosted.ties.lent(&key);
        lent.push(over.clone());
        self.lend(&hosted, &key, &lent).map_err(|error| match error {
            BindError::Backend(error) => ConnectError::Backend(error),
            BindError::HeldUp(error) => ConnectError::HeldUp(error),
            source => ConnectError::End {
                outport: outport.to_string(),
                over: over.clone(),
                source: Box::new(source),
            },
        })?;
        tracing::info!("{outport} is on {over}, too, as long as a connection needs that");
        Ok(())
    }

    /// Closes an out port of this process where no connection needs it any more.
    fn close_unneeded(&self, outport: &Address) {
        let Some((hosted, key)) = self.written(outport) else { return };
        let (needed, lent) = (self.opening.needs.of(outport), hosted.ties.lent(&key));
        let (stay, leave): (Vec<_>, Vec<_>) =
            lent.into_iter().partition(|name| needed.contains(name));
        if leave.is_empty() {
            return;
        }
        let leave = leave.join(", ");
        match self.lend(&hosted, &key, &stay) {
            Ok(()) => tracing::info!("{outport} is no longer on {leave}: no connection needs that"),
            // Tried again by `keep_ends`.
            Err(error) => tracing::debug!("{outport} stays on {leave}: {error}"),
        }
    }

    /// Puts an out port on its own middlewares and on these, and on no others.
    fn lend(&self, hosted: &Hosted, key: &PortKey, lent: &[String]) -> Result<(), BindError> {
        let _turn = hosted.ties.bindings.turn();
        let Some(fan) = hosted.ties.fan(key) else { return Ok(()) };
        let own = hosted.own_backends_of(key);
        let to = own.clone().with(lent);
        let Some(new) = self.new_ends(hosted, key.clone(), fan, &to)? else { return Ok(()) };
        let old = hosted.excluded(|| new.exchange(hosted, &to))?;
        let lent = to.names().iter().filter(|name| !own.has(name));
        hosted.ties.lend(key, lent.cloned().collect());
        drop(old);
        Ok(())
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

    /// Closes what connections needed that went with their components. With `open`, also opens
    /// again what could not be opened when its component was loaded.
    pub(super) fn keep_ends(&self, open: bool) {
        let needs = &self.opening.needs;
        let _turn = needs.turn();
        for (reader, need) in needs.readers() {
            if !self.reads_over(&reader, &need) {
                needs.put(&reader, None);
            } else if open && let Err(error) = self.open_end(&need) {
                tracing::debug!("{reader}: {}", error.sentence());
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
