//! What clients are told that there is: channels and services, by their numbers.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use foxglove::ws_protocol::schema::Schema;
use foxglove::ws_protocol::server::advertise::Channel as Advertised;
use foxglove::ws_protocol::server::advertise_services::Service as AdvertisedService;
use foxglove::ws_protocol::server::{
    Advertise, AdvertiseServices, Unadvertise, UnadvertiseServices,
};
use genom_doors::Holder;
use genom_protocol::frames::Channel;
use genom_protocol::routes::right_of_standard_service;
use genom_protocol::{Right, Service, ServiceKind};
use serde_json::{Value, json};
use tokio_tungstenite::tungstenite::Message;

use crate::reply;

/// Channels in one announcement.
const TOGETHER: usize = 100;

/// A service of a component.
#[derive(Clone, Debug)]
pub(crate) struct Offered {
    pub(crate) component: String,
    pub(crate) service: Arc<Service>,
}

impl Offered {
    fn name(&self) -> String {
        format!("/{}/{}", self.component, self.service.name)
    }

    /// Whether a client may call it.
    fn is_for(&self, holder: &Holder) -> bool {
        let may = |right| holder.may(right, "").is_ok();
        may(Right::Call)
            && (!self.service.standard || may(right_of_standard_service(&self.service.name)))
    }
}

/// All channels and services; the number of one is never used again for another.
#[derive(Debug, Default)]
pub(crate) struct Catalogue {
    channels: BTreeMap<String, (u64, Channel)>,
    services: BTreeMap<String, (u32, Offered)>,
    last_channel: u64,
    last_service: u32,
}

/// How a list changed.
#[derive(Debug)]
pub(crate) struct Difference<I> {
    pub(crate) new: BTreeSet<I>,
    pub(crate) gone: BTreeSet<I>,
}

impl Catalogue {
    /// Takes the channels there are now.
    pub(crate) fn set_channels(&mut self, now: Vec<Channel>) -> Difference<u64> {
        let now = now.into_iter().map(|one| (one.topic.clone(), Channel { channel: 0, ..one }));
        let now: BTreeMap<_, _> = now.collect();
        let mut changed = Difference { new: BTreeSet::new(), gone: BTreeSet::new() };
        self.channels.retain(|topic, (id, known)| {
            let stays = now.get(topic) == Some(&*known);
            if !stays {
                changed.gone.insert(*id);
            }
            stays
        });
        for (topic, channel) in now {
            self.channels.entry(topic).or_insert_with(|| {
                self.last_channel += 1;
                changed.new.insert(self.last_channel);
                (self.last_channel, channel)
            });
        }
        changed
    }

    /// Takes the services there are now.
    pub(crate) fn set_services(&mut self, now: Vec<Offered>) -> Difference<u32> {
        let now: BTreeMap<_, _> = now.into_iter().map(|one| (one.name(), one)).collect();
        let mut changed = Difference { new: BTreeSet::new(), gone: BTreeSet::new() };
        self.services.retain(|name, (id, known)| {
            let same = |now: &Offered| now.service.digest == known.service.digest;
            let stays = now.get(name).is_some_and(same);
            if !stays {
                changed.gone.insert(*id);
            }
            stays
        });
        for (name, offered) in now {
            self.services.entry(name).or_insert_with(|| {
                self.last_service += 1;
                changed.new.insert(self.last_service);
                (self.last_service, offered)
            });
        }
        changed
    }

    /// The topic of a channel.
    pub(crate) fn topic(&self, id: u64) -> Option<&str> {
        let mut all = self.channels.iter();
        all.find(|(_, (known, _))| *known == id).map(|(topic, _)| topic.as_str())
    }

    /// The channel of a topic.
    pub(crate) fn channel(&self, topic: &str) -> Option<u64> {
        self.channels.get(topic).map(|(id, _)| *id)
    }

    /// A service.
    pub(crate) fn service(&self, id: u32) -> Option<&Offered> {
        self.services.values().find(|(known, _)| *known == id).map(|(_, offered)| offered)
    }

    /// The services with these names, of all components.
    pub(crate) fn offered(&self) -> impl Iterator<Item = &Offered> {
        self.services.values().map(|(_, offered)| offered)
    }

    /// Announces these channels, or all.
    pub(crate) fn announce(&self, only: Option<&BTreeSet<u64>>) -> Vec<Message> {
        let wanted = |(id, _): &&(u64, Channel)| only.is_none_or(|only| only.contains(id));
        let advertised = self.channels.values().filter(wanted).filter_map(|(id, channel)| {
            let language = if channel.encoding == "cdr" { "ros2msg" } else { "jsonschema" };
            let schema =
                Schema::new(channel.schema.as_str(), language, channel.definition.as_bytes());
            let made = Advertised::builder(*id, channel.topic.as_str(), channel.encoding.as_str());
            made.with_schema(schema).with_metadata(channel.metadata.clone()).build().ok()
        });
        let advertised: Vec<_> = advertised.collect();
        let together = advertised.chunks(TOGETHER);
        together.map(|some| reply::json(&Advertise::new(some.iter().cloned()))).collect()
    }

    /// Announces these services, or all, as far as a client may call them.
    pub(crate) fn announce_services(
        &self,
        only: Option<&BTreeSet<u32>>,
        to: &Holder,
    ) -> Option<Message> {
        let wanted = |(id, offered): &&(u32, Offered)| {
            only.is_none_or(|only| only.contains(id)) && offered.is_for(to)
        };
        let all = self.services.values().filter(wanted);
        let all: Vec<_> = all.filter_map(|(id, offered)| advertised(*id, offered)).collect();
        (!all.is_empty()).then(|| reply::json(&AdvertiseServices::new(all)))
    }
}

/// That channels are gone.
pub(crate) fn no_more(gone: &BTreeSet<u64>) -> Option<Message> {
    (!gone.is_empty()).then(|| reply::json(&Unadvertise::new(gone.iter().copied())))
}

/// That services are gone.
pub(crate) fn no_more_services(gone: &BTreeSet<u32>) -> Option<Message> {
    (!gone.is_empty()).then(|| reply::json(&UnadvertiseServices::new(gone.iter().copied())))
}

fn advertised(id: u32, offered: &Offered) -> Option<AdvertisedService<'static>> {
    let service = &offered.service;
    let name = |part: &str| format!("{}.{}.{part}", offered.component, service.name);
    let schema = |part: &str, schema: Option<&Value>| {
        let schema = schema.map_or_else(|| "{}".to_owned(), Value::to_string);
        Schema::new(name(part), "jsonschema", schema.into_bytes())
    };
    let outputs = match service.kind {
        ServiceKind::Activity => {
            Some(json!({"type": "object", "properties": {"activity": {"type": "integer"}}}))
        }
        ServiceKind::Attribute | ServiceKind::Function => service.output_schema.clone(),
    };
    let made = AdvertisedService::new(id, offered.name(), name("service"))
        .with_request("json", schema("inputs", service.input_schema.as_ref()))
        .and_then(|made| made.with_response("json", schema("outputs", outputs.as_ref())));
    made.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(topic: &str, definition: &str) -> Channel {
        Channel {
            channel: 7,
            topic: topic.to_owned(),
            encoding: "cdr".to_owned(),
            schema: "demo/msg/State".to_owned(),
            definition: definition.to_owned(),
            metadata: BTreeMap::new(),
        }
    }

    #[test]
    fn a_channel_keeps_its_number_until_its_type_changes() {
        let mut catalogue = Catalogue::default();
        let first = catalogue.set_channels(vec![channel("/a", "x"), channel("/b", "x")]);
        assert_eq!((first.new.len(), first.gone.len()), (2, 0));
        let a = catalogue.channel("/a").unwrap();
        let same = catalogue.set_channels(vec![channel("/b", "x"), channel("/a", "x")]);
        assert!(same.new.is_empty() && same.gone.is_empty());
        let other = catalogue.set_channels(vec![channel("/a", "y")]);
        assert_eq!((other.new.len(), other.gone.len()), (1, 2));
        assert_ne!(catalogue.channel("/a"), Some(a));
        assert_eq!((catalogue.topic(a), catalogue.channel("/b")), (None, None));
    }

    #[test]
    fn announcements_are_in_pieces() {
        let mut catalogue = Catalogue::default();
        let all = (0..TOGETHER + 1).map(|number| channel(&format!("/a/{number}"), "x"));
        let all = catalogue.set_channels(all.collect());
        assert_eq!(catalogue.announce(None).len(), 2);
        let one = all.new.first().copied().into_iter().collect();
        let told = catalogue.announce(Some(&one)).pop().unwrap().into_text().unwrap();
        let told: Value = serde_json::from_str(&told).unwrap();
        assert_eq!(told["channels"].as_array().unwrap().len(), 1);
        assert_eq!(told["channels"][0]["schemaEncoding"], "ros2msg");
    }
}
