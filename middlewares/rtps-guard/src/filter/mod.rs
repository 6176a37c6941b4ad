//! Filters every datagram between the network and RustDDS.
//!
//! RustDDS 0.15 does not check what it receives. One heartbeat that announces 2^62 samples, one
//! fragment of a sample of 4 GiB, or one gap of 2^40 numbers uses up all memory or occupies a
//! processor for ever, and anybody on the network can send it. So each datagram passes through here
//! first (`hook`), on the thread that receives it. Submessages that no peer has a reason to send
//! are turned into padding in place; everything else passes unchanged or with smaller values:
//! heartbeats and gaps may be narrowed, since both are repeated, and a lease may be shortened.
//!
//! Nothing here depends on the magnitude of sequence numbers: writers that have been running for
//! weeks are heard from their first message on. Whoever forges messages in the name of an existing
//! participant can still end its flows, for example by announcing that it leaves. Only DDS Security
//! prevents that, which RustDDS is not built with here, or a network without strangers.

mod answer;
mod discovery;
mod flows;
mod limits;
mod locals;
mod message;
mod outgoing;
mod peers;
mod pieces;
mod repairs;
mod same_machine;
mod tally;
#[cfg(test)]
mod tests;

use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;

use answer::Answer;
pub use limits::Limits;
pub(crate) use outgoing::{Lack, Outgoing, Target, Wire, mended};
pub use tally::{Reason, Tally};

use discovery::{PAIRS, PARTICIPANTS, READERS, WRITERS};
use flows::{Flows, Heard};
use message::{Entity, Fields, HEADER, Head, Prefix, is_builtin, kind, put_number};
use peers::Peers;
use pieces::{Piece, Pieces};
use repairs::Repairs;
use same_machine::SameMachine;

/// The entity id that stands for no particular entity (9.3.1.5).
const UNKNOWN: Entity = [0; 4];

/// Filters what one participant of ours receives.
#[derive(Debug)]
pub(crate) struct Guard {
    limits: Limits,
    peers: Peers,
    flows: Flows,
    pieces: Pieces,
    repairs: Repairs,
    same: SameMachine,
    /// The participant that leaves with the current datagram.
    leaving: Option<Prefix>,
    tally: Arc<Tally>,
}

/// Sends again what a reader at this address lacks, and returns whether it did.
pub(crate) type Repair<'a> = &'a mut dyn FnMut(Option<IpAddr>, &Lack) -> bool;

/// Sender of a submessage, and when it arrived.
#[derive(Clone, Copy, Debug)]
struct From {
    participant: Prefix,
    address: Option<IpAddr>,
    now: Duration,
}

impl Guard {
    pub(crate) fn new(limits: Limits, tally: Arc<Tally>) -> Self {
        Self {
            limits,
            peers: Peers::new(&limits),
            flows: Flows::new(),
            pieces: Pieces::new(&limits),
            repairs: Repairs::default(),
            same: SameMachine::default(),
            leaving: None,
            tally,
        }
    }

    /// Whether RustDDS has to see the datagram that was screened last come from the loopback address.
    pub(crate) fn needs_loopback(&self) -> bool {
        self.same.needs_loopback()
    }

    /// Modifies a datagram so that RustDDS may receive it. Returns false if nothing is left of it.
    ///
    /// `now` is the time since boot including suspend, because writers continue while this machine
    /// sleeps.
    pub(crate) fn screen(
        &mut self,
        datagram: &mut [u8],
        address: Option<IpAddr>,
        now: Duration,
        repair: Repair<'_>,
    ) -> bool {
        self.same.begin();
        let passed = self.look(datagram, address, now, repair);
        if let Err(reason) = passed {
            self.tally.add(reason, address);
        }
        passed.is_ok()
    }

    fn look(
        &mut self,
        datagram: &mut [u8],
        address: Option<IpAddr>,
        now: Duration,
        repair: Repair<'_>,
    ) -> Result<(), Reason> {
        // 9.4.4: protocol, version, vendor, participant.
        let (Some(b"RTPS"), Some(sender)) = (
            datagram.first_chunk(),
            datagram.get(8..HEADER).and_then(|prefix| prefix.first_chunk().copied()),
        ) else {
            return Err(Reason::Malformed);
        };
        let mut from = From { participant: sender, address, now };
        let mut at = HEADER;
        // A datagram that is partly malformed is dropped as a whole, as RustDDS does.
        while let Some(head) = Head::read(datagram, at)? {
            at = head.body.end;
            if head.kind == kind::INFO_SRC {
                from.participant = source(datagram.get(head.body.clone()).unwrap_or_default())?;
                continue;
            }
            match self.submessage(datagram, &head, &from, repair) {
                Ok(Answer::Pass) => {}
                Ok(Answer::Drop) => head.silence(datagram),
                Ok(Answer::Whole { base, number }) => {
                    let _ = repairs::ask_for_whole(datagram, head.start, base, number);
                }
                Err(reason) => {
                    self.tally.add(reason, address);
                    head.silence(datagram);
                }
            }
        }
        // RustDDS stores the reply address of every sender, even of unknown ones.
        let known = self.peers.knows(&sender, now);
        if let Some(gone) = self.leaving.take() {
            self.peers.leave(&gone);
            self.flows.forget(&gone);
            self.pieces.forget(&gone);
            self.repairs.forget(&gone);
        }
        if known { Ok(()) } else { Err(Reason::Stranger) }
    }

    fn submessage(
        &mut self,
        datagram: &mut [u8],
        head: &Head,
        from: &From,
        repair: Repair<'_>,
    ) -> Result<Answer, Reason> {
        let body = datagram.get_mut(head.body.clone()).unwrap_or_default();
        let passed = match head.kind {
            kind::DATA => self.data(body, head, from),
            kind::DATA_FRAG => return self.fragment(body, head, from),
            kind::HEARTBEAT => self.heartbeat(body, head, from),
            kind::GAP => self.gap(body, head, from),
            kind::HEARTBEAT_FRAG => {
                let mut fields = Fields::new(body, head.little());
                self.ends(&mut fields, from).map(drop)
            }
            kind::ACKNACK => return self.acknack(body, head, from),
            kind::NACK_FRAG => return self.nack_frag(body, head, from, repair),
            kind::INFO_REPLY => reply(body, head),
            _ => Ok(()),
        };
        passed.map(|()| Answer::Pass)
    }

    fn acknack(&mut self, body: &[u8], head: &Head, from: &From) -> Result<Answer, Reason> {
        let mut fields = Fields::new(body, head.little());
        let (reader, writer) = self.ends(&mut fields, from)?;
        // Some implementations send 0 while they have received nothing.
        if !(0..=limits::LAST_NUMBER).contains(&fields.clone().number()?) {
            return Err(Reason::Range);
        }
        self.repairs.read_acknack((from.participant, reader, writer), &mut fields)
    }

    fn nack_frag(
        &mut self,
        body: &[u8],
        head: &Head,
        from: &From,
        repair: Repair<'_>,
    ) -> Result<Answer, Reason> {
        let mut fields = Fields::new(body, head.little());
        let (reader, writer) = self.ends(&mut fields, from)?;
        let (number, base) = (fields.number()?, fields.u32()?);
        if !(1..=limits::LAST_NUMBER).contains(&number) || !self.pieces.can_ask(base) {
            return Err(Reason::Range);
        }
        let missing = fields.bitmap()?;
        fields.u32()?;
        if repair(from.address, &Lack { writer, number, base, missing }) {
            return Ok(Answer::Drop);
        }
        let pair = (from.participant, reader, writer);
        Ok(self.repairs.nack_frag(pair, number, missing.count(), from.now))
    }

    /// Reads the reader and the writer, which come first in submessages between ends; checks that
    /// they may communicate.
    fn ends(&self, fields: &mut Fields<'_>, from: &From) -> Result<(Entity, Entity), Reason> {
        let (reader, writer): (Entity, Entity) = (fields.bytes()?, fields.bytes()?);
        pair(reader, writer)?;
        // A participant that announces itself is not known yet.
        if writer != PARTICIPANTS.0 && !self.peers.knows(&from.participant, from.now) {
            return Err(Reason::Stranger);
        }
        Ok((reader, writer))
    }

    fn data(&mut self, body: &mut [u8], head: &Head, from: &From) -> Result<(), Reason> {
        const INLINE: u8 = 2;
        const DATA: u8 = 4;
        const KEY: u8 = 8;
        let mut fields = Fields::new(body, head.little());
        fields.skip(2)?;
        let skipped = usize::from(fields.u16()?).checked_sub(16).ok_or(Reason::Malformed)?;
        let (_, writer) = self.ends(&mut fields, from)?;
        let number = fields.number()?;
        fields.skip(skipped)?;
        let mut about = None;
        if head.flags & INLINE != 0 {
            message::parameters(&mut fields, limits::PARAMETERS, |id, _, value| {
                about = about.or(discovery::key_hash(id, value));
                Ok(())
            })?;
        }
        let about = about.map(|(prefix, entity)| (*prefix, entity));
        let (start, payload) = (fields.at(), fields.rest());
        let has = head.flags & (DATA | KEY);
        if has != 0 && payload.len() < 4 {
            return Err(Reason::Malformed);
        }
        if writer == PARTICIPANTS.0 {
            if has != DATA {
                gone(about, (has == KEY).then_some(payload), from)?;
                // RustDDS must still receive this message; the participant is unknown from the next
                // datagram on.
                self.leaving = Some(from.participant);
                return Ok(());
            }
            let announced = discovery::read(payload, &from.participant)?;
            if announced.entity.is_none() {
                return Err(Reason::Malformed);
            }
            let lease = discovery::lease(&announced, &self.limits);
            let returned = self.peers.announce(from.participant, from.address, lease, from.now)?;
            // Fast DDS repeats its announcement under the same sequence number, and RustDDS
            // processes each number once; it would never match a participant that came back.
            if returned > 0 {
                put_number(body, 12, head.little(), (number & 0xff_ffff_ffff) + (returned << 40));
            }
            if let Some((said, at)) = announced.lease
                && said > lease
                && let Some(payload) = body.get_mut(start..)
            {
                discovery::put_lease(payload, at, lease);
            }
            let payload = body.get_mut(start..).unwrap_or_default();
            self.same.rewrite(payload, &announced.unicast, from.address);
            return Ok(());
        }
        if writer == WRITERS.0 || writer == READERS.0 {
            if has == DATA {
                let announced = discovery::read(payload, &from.participant)?;
                let end = announced.entity.ok_or(Reason::Malformed)?;
                self.peers.open(&from.participant, end)?;
                let payload = body.get_mut(start..).unwrap_or_default();
                self.same.rewrite(payload, &announced.unicast, from.address);
            } else if let Some(end) = gone(about, (has == KEY).then_some(payload), from)? {
                self.peers.close(&from.participant, end);
            }
        }
        self.flows.sample((from.participant, writer), number, from.now)
    }

    fn fragment(&mut self, body: &[u8], head: &Head, from: &From) -> Result<Answer, Reason> {
        const INLINE: u8 = 2;
        const KEY: u8 = 4;
        let mut fields = Fields::new(body, head.little());
        fields.skip(2)?;
        let skipped = usize::from(fields.u16()?).checked_sub(28).ok_or(Reason::Malformed)?;
        let (_, writer) = self.ends(&mut fields, from)?;
        // Participant announcements never need fragments, and fragmented ones could not be checked.
        if writer == PARTICIPANTS.0 {
            return Err(Reason::Announcement);
        }
        let number = fields.number()?;
        let (first, count, fragment) = (fields.u32()?, fields.u16()?, fields.u16()?);
        let whole = fields.u32()?;
        fields.skip(skipped)?;
        if head.flags & INLINE != 0 {
            message::parameters(&mut fields, limits::PARAMETERS, |_, _, _| Ok(()))?;
        }
        if is_builtin(writer) && whole > u32::from(u16::MAX) {
            return Err(Reason::Announcement);
        }
        if (writer == WRITERS.0 || writer == READERS.0) && first == 1 && head.flags & KEY == 0 {
            let end = discovery::first_piece(fields.rest(), &from.participant)?;
            self.peers.open(&from.participant, end)?;
        }
        let piece = Piece { first, count, fragment, whole, payload: fields.rest().len() };
        self.flows.sample((from.participant, writer), number, from.now)?;
        self.pieces.add((from.participant, writer, number), piece, from.now)
    }

    fn heartbeat(&mut self, body: &mut [u8], head: &Head, from: &From) -> Result<(), Reason> {
        let mut fields = Fields::new(body, head.little());
        let (_, writer) = self.ends(&mut fields, from)?;
        let at = fields.at();
        let said = Heard { first: fields.number()?, last: fields.number()? };
        fields.u32()?;
        let heard = self.flows.heartbeat((from.participant, writer), said, from.now)?;
        if heard != said {
            put_number(body, at, head.little(), heard.first);
            put_number(body, at + 8, head.little(), heard.last);
        }
        Ok(())
    }

    fn gap(&mut self, body: &mut [u8], head: &Head, from: &From) -> Result<(), Reason> {
        let mut fields = Fields::new(body, head.little());
        let (_, writer) = self.ends(&mut fields, from)?;
        let start = fields.number()?;
        let at = fields.at();
        let end = fields.number()?;
        fields.bitmap()?;
        let heard = self.flows.gap((from.participant, writer), start, end, from.now)?;
        if heard != end {
            put_number(body, at, head.little(), heard);
            // The bitmap is about later numbers, which do not belong to the narrowed gap.
            if let Some(bits) = body.get_mut(at + 8..at + 12) {
                bits.fill(0);
            }
        }
        Ok(())
    }
}

/// Reads which end is gone; `None` if that cannot be read. Refuses ends of other participants.
fn gone(
    about: Option<(Prefix, Entity)>,
    key: Option<&[u8]>,
    from: &From,
) -> Result<Option<Entity>, Reason> {
    match (about, key) {
        (Some((prefix, _)), _) if prefix != from.participant => Err(Reason::Name),
        (Some((_, entity)), _) => Ok(Some(entity)),
        (None, Some(payload)) => Ok(discovery::read(payload, &from.participant)?.entity),
        (None, None) => Ok(None),
    }
}

/// The sender of the submessages that follow (9.4.5.10).
fn source(body: &[u8]) -> Result<Prefix, Reason> {
    let prefix = body.get(8..).and_then(<[u8]>::first_chunk);
    prefix.copied().ok_or(Reason::Malformed)
}

/// Built-in ends communicate only with their counterparts, and users' ends only with users' ends.
fn pair(reader: Entity, writer: Entity) -> Result<(), Reason> {
    let mixed = reader != UNKNOWN && is_builtin(reader) != is_builtin(writer);
    let of_own = |(theirs, ours): &(Entity, Entity)| *ours == reader && *theirs != writer;
    if mixed || PAIRS.iter().any(of_own) { Err(Reason::Name) } else { Ok(()) }
}

/// Limits the number of locators to which replies are sent (9.4.5.9).
fn reply(body: &[u8], head: &Head) -> Result<(), Reason> {
    const MULTICAST: u8 = 2;
    const LOCATOR: usize = 24;
    let mut fields = Fields::new(body, head.little());
    for _ in 0..if head.flags & MULTICAST == 0 { 1 } else { 2 } {
        let count = fields.u32()?;
        if count > limits::LOCATORS {
            return Err(Reason::Announcement);
        }
        fields.skip(count as usize * LOCATOR)?;
    }
    Ok(())
}
