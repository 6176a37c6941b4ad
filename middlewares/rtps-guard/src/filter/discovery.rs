//! Announcements of participants, writers and readers (RTPS 2.5, 8.5).

use std::net::SocketAddrV4;
use std::time::Duration;

use super::limits::{LOCATORS, Limits, NAME, PARAMETERS, USER_DATA};
use super::message::{Entity, Fields, Prefix, parameters};
use super::tally::Reason;

/// Built-in entities, each a writer and its reader (9.3.1.5).
pub(crate) const PARTICIPANTS: (Entity, Entity) = ([0, 1, 0, 0xc2], [0, 1, 0, 0xc7]);
pub(crate) const WRITERS: (Entity, Entity) = ([0, 0, 3, 0xc2], [0, 0, 3, 0xc7]);
pub(crate) const READERS: (Entity, Entity) = ([0, 0, 4, 0xc2], [0, 0, 4, 0xc7]);
const TOPICS: (Entity, Entity) = ([0, 0, 2, 0xc2], [0, 0, 2, 0xc7]);
const LIVELINESS: (Entity, Entity) = ([0, 2, 0, 0xc2], [0, 2, 0, 0xc7]);

/// Built-in pairs that communicate only with each other.
pub(crate) const PAIRS: [(Entity, Entity); 5] =
    [PARTICIPANTS, WRITERS, READERS, TOPICS, LIVELINESS];

/// Ids of unicast locators for user data: of an end, and of all ends of a participant (9.6.4).
pub(crate) const UNICAST: [u16; 2] = [0x002f, 0x0031];

/// Kinds of locators (9.3.2).
pub(crate) const UDP_V4: u32 = 1;
pub(crate) const UDP_V6: u32 = 2;

/// Ids of parameters (9.6.4).
mod id {
    pub(super) const LEASE: u16 = 0x0002;
    pub(super) const TOPIC_NAME: u16 = 0x0005;
    pub(super) const TYPE_NAME: u16 = 0x0007;
    pub(super) const USER_DATA: u16 = 0x002c;
    pub(super) const TOPIC_DATA: u16 = 0x002e;
    pub(super) const GROUP_DATA: u16 = 0x002d;
    pub(super) const CONTENT_FILTER: u16 = 0x0035;
    pub(super) const PARTICIPANT: u16 = 0x0050;
    pub(super) const END: u16 = 0x005a;
    pub(super) const ENTITY_NAME: u16 = 0x0062;
    pub(super) const KEY_HASH: u16 = 0x0070;
    /// Unicast and multicast locators of participants and ends, for user data and discovery.
    pub(super) const LOCATORS: [u16; 6] = [0x002f, 0x0030, 0x0031, 0x0032, 0x0033, 0x0048];
}

/// Content of an announcement.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Announced {
    /// The announced end, or the participant's own entity.
    pub(crate) entity: Option<Entity>,
    /// The participant's lease, and its offset in the payload.
    pub(crate) lease: Option<(Duration, usize)>,
    /// Where user data is received.
    pub(crate) unicast: Vec<Locator>,
}

/// Where user data is received over UDP (9.3.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Locator {
    /// One of [`UNICAST`].
    pub(crate) id: u16,
    /// Its offset in the payload.
    pub(crate) at: usize,
    /// `None` if it is not one of IPv4.
    pub(crate) address: Option<SocketAddrV4>,
}

impl Locator {
    /// Where the IPv4 address is in a locator.
    pub(crate) const ADDRESS: usize = 20;

    /// `None` if it is of another kind, such as shared memory, which RustDDS does not know.
    fn read(id: u16, at: usize, value: &[u8], little: bool) -> Option<Self> {
        let value: &[u8; 24] = value.try_into().ok()?;
        let mut fields = Fields::new(value, little);
        let (kind, port) = (fields.u32().ok()?, fields.u32().ok()?);
        let (_, ip) = value.split_last_chunk::<4>()?;
        let port = u16::try_from(port).ok().filter(|_| kind == UDP_V4);
        let address = port.map(|port| SocketAddrV4::new((*ip).into(), port));
        [UDP_V4, UDP_V6].contains(&kind).then_some(Self { id, at, address })
    }
}

/// Reads the payload of an announcement of participant `of`; the payload starts with its
/// encapsulation header.
pub(crate) fn read(payload: &[u8], of: &Prefix) -> Result<Announced, Reason> {
    // 10.5: a parameter list, little or big endian.
    let little = match payload {
        [0, 2, ..] => false,
        [0, 3, ..] => true,
        _ => return Err(Reason::Malformed),
    };
    let mut fields = Fields::new(payload, little);
    fields.skip(4)?;
    let mut announced = Announced::default();
    let mut locators = 0;
    parameters(&mut fields, PARAMETERS, |id, at, value| {
        match id {
            id::PARTICIPANT | id::END => {
                let guid: &[u8; 16] = value.first_chunk().ok_or(Reason::Malformed)?;
                // A writer's announcement may also contain the GUID of its participant.
                let (prefix, entity) = guid.split_at(12);
                if prefix != of {
                    return Err(Reason::Name);
                }
                let entity: Entity = entity.try_into().map_err(|_| Reason::Malformed)?;
                // The first one counts.
                if id == id::END || announced.entity.is_none() {
                    if id == id::END
                        && announced.entity.is_some_and(|had| had != entity && had[3] != 0xc1)
                    {
                        return Err(Reason::Name);
                    }
                    announced.entity = Some(entity);
                }
            }
            id::LEASE if announced.lease.is_none() => {
                let mut value = Fields::new(value, little);
                let (seconds, fraction) = (value.u32()?, value.u32()?);
                // 9.3.2: fractions in units of 2^-32 s; negative durations count as zero.
                let whole = u64::from(seconds & 0x7fff_ffff);
                let lease = if seconds >> 31 == 1 {
                    Duration::ZERO
                } else {
                    let nanos = (u64::from(fraction) * 1_000_000_000) >> 32;
                    Duration::from_secs(whole) + Duration::from_nanos(nanos)
                };
                announced.lease = Some((lease, at));
            }
            id::TOPIC_NAME | id::TYPE_NAME | id::ENTITY_NAME if value.len() > NAME => {
                return Err(Reason::Announcement);
            }
            id::USER_DATA | id::TOPIC_DATA | id::GROUP_DATA | id::CONTENT_FILTER
                if value.len() > USER_DATA =>
            {
                return Err(Reason::Announcement);
            }
            id if id::LOCATORS.contains(&id) => {
                locators += 1;
                if locators > LOCATORS {
                    return Err(Reason::Announcement);
                }
                if UNICAST.contains(&id) {
                    announced.unicast.extend(Locator::read(id, at, value, little));
                }
            }
            _ => {}
        }
        Ok(())
    })?;
    Ok(announced)
}

/// The end that a fragmented announcement is about, from its first fragment.
pub(crate) fn first_piece(payload: &[u8], of: &Prefix) -> Result<Entity, Reason> {
    let little = payload.get(1) == Some(&3);
    let mut fields = Fields::new(payload, little);
    fields.skip(4)?;
    let mut end = None;
    // The fragment ends somewhere in the list; what was read before counts.
    let _ = parameters(&mut fields, PARAMETERS, |id, _, value| {
        let guid = value.split_first_chunk().filter(|_| id == id::END);
        end = end.or(guid.and_then(|(prefix, rest)| Some((*prefix, *rest.first_chunk()?))));
        Ok(())
    });
    match end {
        Some((prefix, end)) if prefix == *of => Ok(end),
        Some(_) => Err(Reason::Name),
        None => Err(Reason::Announcement),
    }
}

/// Writes a lease of whole seconds at an offset.
pub(crate) fn put_lease(payload: &mut [u8], at: usize, lease: Duration) {
    let little = payload.get(1) == Some(&3);
    let seconds = u32::try_from(lease.as_secs()).unwrap_or(i32::MAX.cast_unsigned());
    let seconds = if little { seconds.to_le_bytes() } else { seconds.to_be_bytes() };
    if let Some(place) = payload.get_mut(at..at + 8) {
        place.copy_from_slice(&[seconds, [0; 4]].concat());
    }
}

/// The subject of a message that contains no announcement: from the key hash in its inline
/// parameters, or from a payload that is only a key (9.6.4.8).
pub(crate) fn key_hash(id: u16, value: &[u8]) -> Option<(&Prefix, Entity)> {
    let (prefix, entity) = value.split_first_chunk()?;
    (id == id::KEY_HASH).then_some(())?;
    Some((prefix, *entity.first_chunk()?))
}

/// The lease that a participant is granted.
pub(crate) fn lease(announced: &Announced, limits: &Limits) -> Duration {
    // Default of DDS if the announcement contains no lease.
    let said = announced.lease.map_or(Duration::from_secs(100), |(lease, _)| lease);
    said.min(limits.silence)
}
