//! The steps that do something.

use genom_nearest::suggest;
use genom_protocol::{
    Activity, Address, Cell, CellState, Inputs, LookParameters, Outcome, ValueParameters, routes,
};
use serde_json::Value;

use super::daemon::{Daemon, Trouble};
use super::history::Life;
use super::player::{Player, Started};
use super::why::{Why, outcome};
use crate::compare::{differences, told};
use crate::duration::short;
use crate::model::{Action, Ended};

/// The exception of what ends with the process of its cell.
const GONE: &str = "::genom::gone";

/// The query of a port's element.
pub(super) fn element(port: &Address) -> ValueParameters {
    ValueParameters { element: port.element.clone() }
}

impl<D: Daemon> Player<'_, D> {
    /// Does a step.
    pub(super) async fn act(&mut self, action: &Action) -> Result<(), Why> {
        let daemon = self.daemon;
        match action {
            Action::Load(request) => {
                daemon.send(routes::load(), request.as_ref()).await?;
                self.pace = None;
            }
            Action::Unload(component) => {
                daemon.ask(routes::unload(component)).await?;
                self.pace = None;
            }
            Action::Connect(request) => drop(daemon.send(routes::connect(), request).await?),
            Action::Disconnect(port) => self.disconnect(port).await?,
            Action::Advance(span) => self.advance(*span).await?,
            Action::Publish { port, value } => self.publish(port, value).await?,
            Action::Call { service, inputs, ended } => self.call(service, inputs, ended).await?,
            Action::Start { service, inputs, label } => {
                let (number, ended) = self.request(service, inputs).await?;
                if let Some(end) = ended {
                    return Err(Why::unmet("that it is accepted", outcome(&end)));
                }
                self.started(label, service, number);
            }
            Action::Abort(of) => {
                let Started { component, number, .. } = self.activity(of).await?;
                daemon.ask(routes::abort(&component, &number.to_string())).await?;
            }
            Action::Wait { of, ended } => {
                let activity = self.activity(of).await?;
                self.until_ended(&activity, ended).await?;
            }
            Action::Fire { component, event } => {
                daemon.ask(routes::fire(component, event)).await?;
            }
            Action::Expect(expected) => self.expect(expected).await?,
            Action::Fault(fault) => self.fault(fault).await?,
            Action::Repair(port) => self.repair(port).await?,
            Action::Kill(cell) => self.kill(cell).await?,
        }
        Ok(())
    }

    pub(super) async fn publish(&self, port: &Address, value: &Value) -> Result<(), Why> {
        let route = routes::publish(&port.component, &port.port).with(&element(port));
        self.daemon.send(route, value).await?;
        Ok(())
    }

    pub(super) async fn disconnect(&self, port: &Address) -> Result<(), Why> {
        let Address { component, port, element } = port;
        match element {
            Some(element) => {
                let route = routes::disconnect_element(component, port, element);
                drop(self.daemon.ask(route).await?);
            }
            None => drop(self.daemon.ask(routes::disconnect(component, port)).await?),
        }
        Ok(())
    }

    /// Calls a service: the number of the activity, or how it ended at once.
    async fn request(
        &self,
        service: &Address,
        inputs: &Value,
    ) -> Result<(Option<u64>, Option<Outcome>), Why> {
        let route = routes::call(&service.component, &service.port);
        let reply = self.daemon.send(route, &Inputs(inputs.clone())).await?;
        Ok((reply.activity(), reply.outcome().cloned()))
    }

    fn started(&mut self, label: &str, service: &Address, number: Option<u64>) {
        let Some(number) = number else { return };
        let started =
            Started { component: service.component.clone(), number, at: self.now, gone: false };
        self.started.insert(service.to_string(), started.clone());
        self.started.insert(label.to_owned(), started);
    }

    async fn call(&mut self, service: &Address, inputs: &Value, ended: &Ended) -> Result<(), Why> {
        match self.request(service, inputs).await? {
            (Some(number), None) => {
                self.started(&service.to_string(), service, Some(number));
                let activity = self.activity(&service.to_string()).await?;
                self.until_ended(&activity, ended).await
            }
            (_, end) => check(&end.unwrap_or_default(), 0, ended),
        }
    }

    /// An activity that a step started, or the latest of a service.
    pub(super) async fn activity(&self, of: &str) -> Result<Started, Why> {
        if let Some(started) = self.started.get(of) {
            return Ok(started.clone());
        }
        let Some((component, service)) = of.split_once('/') else {
            return Err(Why::unmet(format!("an activity `{of}`"), "none was started"));
        };
        let found: Activity = self.daemon.ask(routes::activity(component, service)).await?;
        let (component, number) = (component.to_owned(), found.activity);
        let life = self.life(&component, number).await?;
        Ok(Started { component, number, at: life.started.unwrap_or_default(), gone: false })
    }

    /// What an activity did so far.
    pub(super) async fn life(&self, component: &str, number: u64) -> Result<Life, Why> {
        let bytes = self.daemon.bytes(routes::blackbox_frames()).await?;
        let life = Life::read(&bytes, component, number);
        Ok(life.map_err(|error| Trouble::Gone(format!("the black box: {error}")))?)
    }

    /// Steps the clock until an activity has ended.
    async fn until_ended(&mut self, activity: &Started, ended: &Ended) -> Result<(), Why> {
        let target = self.now.saturating_add(ended.within);
        let period = self.pace().await?.period;
        // What is due now is done first.
        let mut span = 0;
        loop {
            self.advance(span).await?;
            if let Some(end) = self.end(activity).await? {
                let life = self.life(&activity.component, activity.number).await?;
                // A cell that was started later has a clock that is behind: both times are of one.
                let begun = life.started.unwrap_or(activity.at);
                let took = life.ended.unwrap_or(self.now).saturating_sub(begun);
                return check(&end, took, ended);
            }
            if self.now >= target {
                let expected = format!("an end within {}", short(ended.within));
                return Err(Why::unmet(expected, "it still runs"));
            }
            span = self.slice(period, target);
        }
    }

    /// How an activity ended, if it did.
    pub(super) async fn end(&self, activity: &Started) -> Result<Option<Outcome>, Why> {
        let Started { component, number, gone, .. } = activity;
        if *gone {
            return Ok(Some(Outcome::of_exception(GONE, Value::Null)));
        }
        let route = routes::activity(component, &number.to_string());
        let looked = self.daemon.ask(route.with(&LookParameters::default())).await?;
        Ok(Some(looked.outcome).filter(Outcome::ended))
    }

    /// Kills the process of a cell, and waits until it is back, or is to stay down.
    async fn kill(&mut self, name: &str) -> Result<(), Why> {
        let before = self.cell(name).await?;
        let Some(pid) = before.pid else {
            return Err(Why::unmet("a process", format!("the cell is {}", before.state)));
        };
        let mut gone = Vec::new();
        for (label, started) in &self.started {
            if before.components.contains(&started.component) && self.end(started).await?.is_none()
            {
                gone.push(label.clone());
            }
        }
        self.daemon.kill(pid)?;
        for (_, started) in self.started.iter_mut().filter(|(label, _)| gone.contains(label)) {
            started.gone = true;
        }
        loop {
            let cell = self.cell(name).await?;
            let back = cell.state == CellState::Running && cell.starts > before.starts;
            if back || cell.state == CellState::Failed {
                break;
            }
            self.daemon.moment().await;
        }
        self.pace = None;
        Ok(())
    }

    async fn cell(&self, name: &str) -> Result<Cell, Why> {
        let mut cells = self.daemon.ask(routes::cells()).await?.cells;
        match cells.iter().position(|cell| cell.name == name) {
            Some(at) => Ok(cells.swap_remove(at)),
            None => {
                let help = suggest(name, cells.iter().map(|cell| cell.name.as_str()));
                Err(Why::unmet(format!("a cell `{name}`"), help))
            }
        }
    }
}

/// Compares how a service ended, after so many nanoseconds, with how it has to end.
fn check(end: &Outcome, took: u64, wanted: &Ended) -> Result<(), Why> {
    let Ended { result, throws, detail, tolerance, takes, .. } = wanted;
    if end.exception != *throws {
        let expected = throws.clone().unwrap_or_else(|| "done".to_owned());
        return Err(Why::unmet(expected, outcome(end)));
    }
    for (wanted, found) in [(result, &end.result), (detail, &end.detail)] {
        let Some(wanted) = wanted else { continue };
        let all = differences(wanted, found.as_ref().unwrap_or(&Value::Null), *tolerance);
        if !all.is_empty() {
            let (expected, came) = told(&all, *tolerance);
            return Err(Why::unmet(expected, came));
        }
    }
    match takes {
        Some(takes) if !(takes.least..=takes.most).contains(&took) => {
            let expected = match (takes.least, takes.most) {
                (least, most) if least == most => short(least),
                (0, most) => format!("at most {}", short(most)),
                (least, u64::MAX) => format!("at least {}", short(least)),
                (least, most) => format!("{} to {}", short(least), short(most)),
            };
            Err(Why::unmet(format!("that it takes {expected}"), short(took)))
        }
        _ => Ok(()),
    }
}
