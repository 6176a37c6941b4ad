//! Faults of connections. The in port is disconnected, and what its out port writes is published to
//! it after each period: dropped, later, or changed.

use std::collections::VecDeque;

use genom_protocol::{Address, ConnectionRequest, Place, routes};
use serde_json::Value;

use super::act::element;
use super::daemon::Daemon;
use super::player::Player;
use super::relay::Relay;
use super::why::Why;
use crate::model::Fault;

impl<D: Daemon> Player<'_, D> {
    /// From now on samples of a connection pass through here.
    pub(super) async fn fault(&mut self, fault: &Fault) -> Result<(), Why> {
        if let Some(relay) = self.relays.iter_mut().find(|relay| relay.fault.port == fault.port) {
            // Another fault of the same connection.
            (relay.fault, relay.came, relay.hit) = (fault.clone(), 0, 0);
            return Ok(());
        }
        let port = fault.port.to_string();
        let all = self.daemon.ask(routes::connections()).await?.connections;
        let Some(found) = all.into_iter().find(|one| one.inport == port) else {
            return Err(Why::unmet(format!("a connection of {port}"), "it is not connected"));
        };
        // The out port may be of another daemon, which cannot be asked.
        let place = found.outport.parse::<Place>().ok().map(|place| place.address);
        let Some(from) = place.filter(|from| !from.component.is_empty()) else {
            let came = format!("it reads {}", found.outport);
            return Err(Why::unmet("an out port of this scenario", came));
        };
        let (_, seen) = self.sample(&from).await?;
        let (last, _) = self.sample(&fault.port).await?;
        let was = ConnectionRequest {
            inport: found.inport,
            outport: found.outport,
            policy: found.policy,
            over: found.backend.filter(|_| found.fixed),
            wait: false,
        };
        self.disconnect(&fault.port).await?;
        // A reader keeps what it read last.
        if let Some(last) = last {
            self.publish(&fault.port, &last).await?;
        }
        let waiting = VecDeque::new();
        self.relays.push(Relay { fault: fault.clone(), was, from, seen, came: 0, hit: 0, waiting });
        Ok(())
    }

    /// The connection is again as it was; what was on its way is lost.
    pub(super) async fn repair(&mut self, port: &Address) -> Result<(), Why> {
        let Some(at) = self.relays.iter().position(|relay| relay.fault.port == *port) else {
            return Err(Why::unmet(format!("a fault of {port}"), "it has none"));
        };
        let relay = self.relays.remove(at);
        self.daemon.send(routes::connect(), &relay.was).await?;
        Ok(())
    }

    /// Passes on what was written since the last time.
    pub(super) async fn relay(&mut self) -> Result<(), Why> {
        let mut relays = std::mem::take(&mut self.relays);
        for relay in &mut relays {
            let (value, samples) = self.sample(&relay.from).await?;
            let new = samples.saturating_sub(relay.seen);
            relay.seen = samples;
            if new > 1 {
                let came = format!("{new} samples of {} within one period", relay.from);
                return Err(Why::unmet("at most one sample in a period, to pass on", came));
            }
            if let Some(value) = value.filter(|_| new == 1) {
                relay.take(self.now, value);
            }
            while let Some(value) = relay.arrived(self.now) {
                self.publish(&relay.fault.port, &value).await?;
            }
        }
        self.relays = relays;
        Ok(())
    }

    /// The last sample of a port, and how many there were.
    async fn sample(&self, of: &Address) -> Result<(Option<Value>, u64), Why> {
        let route = routes::port(&of.component, &of.port).with(&element(of));
        let port = self.daemon.ask(route).await?;
        Ok((port.value, port.traffic.unwrap_or_default().samples))
    }
}
