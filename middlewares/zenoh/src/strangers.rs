//! Programs that are not genomd, as far as zenoh reports them.
//!
//! Only zenoh's admin space would list their subscriptions, and it is not queried: its handlers
//! hold the routing tables while they reply, and both sessions hang if somebody declares something
//! at that moment (eclipse-zenoh/zenoh#2619).

use genom_middleware::{Address, Stranger};
use zenoh::Wait;
use zenoh::sample::Locality;

use crate::core::Core;

impl Core {
    pub(crate) fn strangers(&self) -> Vec<Stranger> {
        let known = self.graph().sessions();
        let sessions = self.session().info().transports().wait();
        let sessions = sessions.map(|other| (other.zid().to_string(), other.whatami().to_str()));
        let strange = |(name, _): &(String, _)| !known.contains(name) && !self.daemons().has(name);
        let sessions = sessions
            .filter(strange)
            .map(|(name, role)| Stranger::Session { name, role: role.into() });
        let readers = self.graph().unread(self.name()).into_iter();
        let readers = readers.filter(|address| self.is_read(address));
        sessions.chain(readers.map(|address| Stranger::Reader { address })).collect()
    }

    /// Whether another session subscribes to the key of an address.
    fn is_read(&self, address: &str) -> bool {
        let key = Address::parse(address).and_then(|at| self.keys().of(&at).ok());
        let Some(key) = key else { return false };
        let writer = self.session().declare_publisher(key).allowed_destination(Locality::Remote);
        // This publisher writes nothing and is dropped at once.
        let status = writer.wait().and_then(|writer| writer.matching_status().wait());
        status.is_ok_and(|status| status.matching())
    }
}
