//! A component that takes the place of another one between two ticks.

use std::collections::BTreeSet;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use genom_description::model::{Port, PortDirection, PortIx, ServiceIx};
use genom_host::Conversions;
use genom_ports::PortKey;
use genom_protocol::{FrozenComponent, Resumption};
use genom_runtime::body::Body;
use genom_runtime::{Frozen, FrozenPort, HeirIds, NoRest, Resume};
use genom_types::native::{self, Former, NotConverted, is_native};
use genom_types::{DataType, Record};

use super::frozen::{LastValues, native_in};
use super::hosted::Hosted;
use super::prepared::{Unfit, prepare};
use super::running::Components;
use super::tracked::resume;
use super::vacated::is_vacated;

/// What one component has does not go over to the other.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NotHandedOver {
    #[error(transparent)]
    Unfit(#[from] Unfit),
    #[error(transparent)]
    NotConverted(#[from] NotConverted),
}

impl Components {
    /// Hands the state of a component over to `heir`, which has its name from then on. The one before
    /// is left to be [closed](Self::retire). Returns what is not taken over as it was. What the one
    /// before does not have is taken of an `earlier` state, if there is one.
    ///
    /// # Errors
    /// There was no moment of rest within `limit`, or the state does not fit. Nothing was done.
    pub(crate) fn hand_over(
        &self,
        before: &Hosted,
        heir: &Arc<Hosted>,
        earlier: Option<&FrozenComponent>,
        (limit, timeout): (Duration, Duration),
    ) -> Result<Result<Vec<String>, NotHandedOver>, NoRest> {
        let mut notes = Vec::new();
        let conversions = heir.ids_type().map(|ids| heir.component.conversions(&ids));
        let convert = |frozen: Frozen, ids: &HeirIds<'_>| {
            let converted = match (&conversions, &frozen.ids) {
                (Some(all), Some(from)) => before.convert_natives(all, from, heir, ids)?,
                _ => Vec::new(),
            };
            let resume = before.for_heir(frozen, heir, earlier, &mut notes)?;
            notes.extend(converted);
            Ok::<_, NotHandedOver>(resume)
        };
        let exchange = |from: &dyn Body, to: &dyn Body| {
            before.give_ports(heir, to);
            if let Some(earlier) = earlier {
                let unknown = |name: &str| before.plan().service(name).is_none();
                heir.standing.remember(earlier, unknown);
            }
            before.release_ports(from);
            heir.watcher.inherit(&before.watcher);
            self.replace(&heir.name, Arc::clone(heir));
        };
        let done =
            before.instance.hand_over(&heir.instance, (limit, timeout), convert, exchange)?;
        Ok(done.map(|()| [notes, heir.instance.unresumed()].concat()))
    }
}

impl Hosted {
    fn ids_type(&self) -> Option<DataType> {
        DataType::new(&self.specification().types, self.model().ids?).ok()
    }

    /// Calls what the heir's library offers for the native data in these IDS. Returns what became of it.
    fn convert_natives(
        &self,
        conversions: &Conversions<'_>,
        from: &Record,
        heir: &Hosted,
        ids: &HeirIds<'_>,
    ) -> Result<Vec<String>, NotConverted> {
        let Some(to) = heir.ids_type() else { return Ok(Vec::new()) };
        let model = self.model();
        let former =
            Former { instance: &self.name, version: &model.version, digest: &model.digest };
        let mut done = Ok(BTreeSet::new());
        if conversions.offers(None) {
            // What a function stored before one failed stays, for the stop codels of its library.
            ids(&mut |to| done = conversions.convert(from, to, former));
        }
        let offers = |name: &str| conversions.offers(Some(name));
        let lines = native::lines(from.ty(), &to, &done?, offers).into_iter();
        Ok(lines.map(|line| format!("ids: {line}")).collect())
    }

    /// What its heir takes of it: what has the same type as a copy, the rest by names.
    fn for_heir(
        &self,
        frozen: Frozen,
        heir: &Hosted,
        earlier: Option<&FrozenComponent>,
        notes: &mut Vec<String>,
    ) -> Result<Resume, Unfit> {
        let same_ids = |ids: &Record| {
            heir.ids_type().is_some_and(|own| own.same_as(ids.ty()))
                && native_in(ids.ty()).is_none()
        };
        let ids = frozen.ids.clone().filter(same_ids);
        let (mut as_is, mut by_name) = (Vec::new(), LastValues::new());
        for (name, key, value) in self.last_values() {
            match (self.port_of(heir, &key), value) {
                (Some(own), Some(value)) => {
                    as_is.push(FrozenPort { port: own.port, element: own.element, value });
                }
                (_, value) => by_name.push((name, value)),
            }
        }
        let by_names = Frozen { ids: frozen.ids.filter(|_| ids.is_none()), ..frozen };
        let mut state = self.state_of(by_names, by_name);
        // Native data has lines of its own.
        if let (Some(ids), Some(ty)) = (&mut state.ids, self.ids_type()) {
            ids.left_out.retain(|path| !is_native(&ty, path));
        }
        let earlier = earlier.and_then(|earlier| earlier.ids.clone());
        let over = earlier.and_then(|earlier| Some((earlier.value, state.ids.take()?.value)));
        let resumption = Resumption { state, activities: true, hold: true, copy: None };
        let mut prepared = prepare(heir.plan(), &resumption)?;
        prepared.ports.extend(as_is);
        notes.append(&mut prepared.notes);
        let same = |service| self.answers_for(heir, service);
        let mut all = resume(prepared, &heir.name, &heir.activities, &heir.standing, &same);
        if let Some((earlier, now)) = over {
            all.ids = Some(Box::new(move |record| {
                drop(record.take_over(&earlier));
                drop(record.take_over(&now));
            }));
        }
        if let Some(ids) = ids {
            all.ids = Some(Box::new(move |record| {
                if let Err(why) = record.copy_from(&ids) {
                    tracing::error!("the ids are not taken over: {why}");
                }
            }));
        }
        Ok(all)
    }

    /// Whether who called this service of the heir's when it was this one's reads its outcome.
    fn answers_for(&self, heir: &Hosted, service: ServiceIx) -> bool {
        let name = &heir.model().services[service].name;
        self.plan().service(name).is_some_and(|own| {
            let theirs = &heir.plan().services()[service].output;
            self.plan().services()[own].output.same_as(theirs)
        })
    }

    /// The same port of another description: that name, direction, kind and type.
    pub(crate) fn port_of(&self, other: &Hosted, key: &PortKey) -> Option<PortKey> {
        let own = &self.model().ports[key.port];
        let found: PortIx = other.model().ports.find(|port| {
            port.name == own.name
                && port.direction == own.direction
                && port.multiple == own.multiple
        })?;
        let (ours, theirs) = self.port_type(key.port).zip(other.port_type(found))?;
        ours.same_as(theirs).then(|| PortKey { port: found, element: key.element.clone() })
    }

    /// Binds what its ports are connected to, at those of the heir that are the same.
    fn give_ports(&self, heir: &Hosted, body: &dyn Body) {
        for (key, fan) in self.ties.fans() {
            let Some(own) = self.port_of(heir, &key) else { continue };
            body.bind_out(own.port, own.element(), Some(fan.publisher()));
            heir.ties.opened(own, fan, self.ties.lent(&key));
        }
        for (key, made, tap) in self.ties.taps() {
            let Some(own) = self.port_of(heir, &key) else { continue };
            body.bind_in(own.port, own.element(), Some(tap.subscription()));
            drop(heir.ties.connected(own, made, tap));
        }
        heir.ties.is_handed_over();
        let known = |name: &str| heir.plan().service(name).is_some();
        heir.standing.keep(known);
    }

    /// Names of its open out ports and of their elements.
    pub(crate) fn open_ports(&self) -> BTreeSet<String> {
        let name = |key: &PortKey| {
            let port = &self.model().ports[key.port].name;
            key.element().map_or_else(|| port.clone(), |element| format!("{port}/{element}"))
        };
        self.ties.fans().iter().map(|(key, _)| name(key)).collect()
    }

    /// Ports of the heir that are open here with another type, and out ports that are open here.
    pub(crate) fn closed_for(&self, heir: &Hosted) -> Vec<PortIx> {
        let mut again = Vec::new();
        for (key, _) in self.ties.fans() {
            if self.port_of(heir, &key).is_some() {
                continue;
            }
            self.ties.closed(&key);
            let name = &self.model().ports[key.port].name;
            let is_it = |port: &Port| {
                port.name == *name && port.direction == PortDirection::Out && !port.multiple
            };
            again.extend(heir.model().ports.find(is_it));
        }
        again
    }

    /// Withdraws its services.
    pub(crate) fn withdraw(&self) {
        let served =
            std::mem::take(&mut *self.served.lock().unwrap_or_else(PoisonError::into_inner));
        drop(served);
    }
}

impl Components {
    /// Waits until one whose place was taken has ended, with its stop codels, and closes its library.
    /// Returns whether nothing is in that any more.
    pub(crate) fn retire(&self, before: Arc<Hosted>, timeout: Duration) -> bool {
        if let Err(why) = before.finish_stop(Instant::now() + timeout) {
            tracing::error!("{why}");
            self.leave_behind(before);
            return false;
        }
        let free = is_vacated(&before.component);
        drop(before);
        free
    }
}
