//! Which messages pass and which do not, byte by byte.

#[path = "../../../../tests/src/siege/forger.rs"]
pub(crate) mod forger;

use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;

use forger::{Forger, USER, WRITERS, data, fragment, gap, heartbeat};
use proptest::prelude::*;

use super::limits::{AHEAD, HELD, WINDOW};
use super::message::{Fields, HEADER, Head, kind};
use super::{Guard, Lack, Limits, Reason, Tally};

const PEER: Forger = Forger(*b"\x01\x10somebody..");
const OTHER: Forger = Forger(*b"\x01\x10another...");
const SAMPLE: &[u8] = &[0, 1, 0, 0, 7, 0, 0, 0];

struct World {
    guard: Guard,
    tally: Arc<Tally>,
    now: Duration,
    /// Whether what readers lack is sent again, and what they did.
    repairs: bool,
    lacks: Vec<Lack>,
}

impl World {
    /// A world in which [`PEER`] is known.
    fn new() -> Self {
        let mut world = Self::with(Limits::default());
        assert!(world.hears(&mut PEER.announcement(1, 7000, 20)));
        world
    }

    fn with(limits: Limits) -> Self {
        let tally = Arc::new(Tally::default());
        let (guard, now) = (Guard::new(limits, Arc::clone(&tally)), Duration::from_secs(9));
        Self { guard, tally, now, repairs: false, lacks: Vec::new() }
    }

    fn hears(&mut self, datagram: &mut [u8]) -> bool {
        self.hears_from(datagram, 1)
    }

    /// The peer announces itself again after a silence.
    fn meets_again(&mut self) -> bool {
        let late = !self.hears(&mut PEER.announcement(2, 7000, 20));
        self.now += Duration::from_secs(3);
        late && self.hears(&mut PEER.announcement(3, 7000, 20))
    }

    fn hears_from(&mut self, datagram: &mut [u8], host: u8) -> bool {
        let repair = &mut |_, lack: &Lack| {
            self.lacks.push(*lack);
            self.repairs
        };
        self.guard.screen(datagram, Some(IpAddr::from([10, 0, 0, host])), self.now, repair)
    }

    /// Kind and body of a submessage of the peer's after the guard.
    fn left(&mut self, submessage: Vec<u8>) -> (u8, Vec<u8>) {
        let mut datagram = PEER.message(&[submessage]);
        assert!(self.hears(&mut datagram));
        let head = Head::read(&datagram, HEADER).unwrap().unwrap();
        (head.kind, datagram[head.body].to_vec())
    }

    fn passes(&mut self, submessage: Vec<u8>) -> bool {
        let before = submessage.clone();
        let (_, body) = self.left(submessage);
        body == before[4..]
    }

    fn is_silenced(&mut self, submessage: Vec<u8>) -> bool {
        self.left(submessage).0 == kind::PAD
    }

    fn numbers(&mut self, submessage: Vec<u8>) -> (i64, i64) {
        let (_, body) = self.left(submessage);
        let mut fields = Fields::new(&body, true);
        fields.skip(8).unwrap();
        (fields.number().unwrap(), fields.number().unwrap())
    }

    fn refused(&self, reason: Reason) -> u64 {
        self.tally.list().iter().find(|(of, ..)| *of == reason).map_or(0, |(_, count, _)| *count)
    }
}

#[test]
fn what_peers_say_passes_as_it_came() {
    let mut world = World::new();
    assert!(world.hears(&mut PEER.writer("rt/demo/position", "demo::msg::dds_::State_")));
    for number in 1..100 {
        assert!(world.passes(data(USER, number, SAMPLE)));
        assert!(world.passes(heartbeat(USER, 1, number, i32::try_from(number).unwrap())));
    }
    assert!(world.passes(gap(USER, 100, 120)));
    assert!(world.passes(heartbeat(USER, 121, 120, 200)));
    // In fragments, some of them twice.
    for first in [1, 2, 2, 3] {
        let payload = if first == 3 { &[0; 100][..] } else { &[0; 1000] };
        assert!(world.passes(fragment(USER, 121, (first, 1, 1000), 2100, payload)));
    }
    assert_eq!(world.tally.list(), []);
}

#[test]
fn a_writer_that_runs_for_weeks_is_heard_from_its_first_message_on() {
    let mut world = World::new();
    let far = (1 << 31) + 5;
    // It holds ten samples, and a gap tells a late reader that earlier ones are gone.
    assert!(world.passes(gap(USER, 1, far)));
    assert!(world.passes(heartbeat(USER, far, far + 9, 1)));
    for number in far..far + 5000 {
        assert!(world.passes(data(USER, number, SAMPLE)));
    }
    // As its first message, without a gap; and a sample before any heartbeat.
    assert!(world.passes(heartbeat([0, 0, 1, 3], 1 << 40, (1 << 40) + 9, 1)));
    assert!(world.passes(data([0, 0, 2, 3], 1 << 40, SAMPLE)));
    // This machine slept for a night; the writer at 1 kHz did not.
    world.now += Duration::from_secs(8 * 3600);
    assert!(world.meets_again());
    assert!(world.passes(data(USER, far + 8 * 3_600_000, SAMPLE)));
    assert_eq!(world.tally.list(), []);
}

#[test]
fn a_heartbeat_of_more_numbers_than_can_be_is_silenced() {
    for last in [1 << 31, 1 << 62, i64::MAX] {
        let mut world = World::new();
        assert!(world.is_silenced(heartbeat(USER, 1, last, 1)), "{last}");
        assert_eq!(world.refused(Reason::Range), 1);
        // The writer's real messages pass.
        assert!(world.passes(heartbeat(USER, 1, 5, 1)));
    }
}

#[test]
fn a_long_heartbeat_tells_of_what_follows_next_and_then_of_more() {
    let mut world = World::new();
    let held = 40_000;
    let mut count = 0;
    let mut received = 0;
    while received < held {
        count += 1;
        let (first, last) = world.numbers(heartbeat(USER, 1, held, count));
        assert!(first <= received + 1 && last > received, "{first} {last} {received}");
        assert!(last <= received + 1 + WINDOW);
        for number in received + 1..=last.min(held) {
            assert!(world.passes(data(USER, number, SAMPLE)));
        }
        received = last;
        world.now += Duration::from_millis(100);
    }
    assert_eq!(world.tally.list(), []);
}

#[test]
fn wide_heartbeats_are_few() {
    let mut world = World::new();
    assert!(world.passes(data(USER, 1, SAMPLE)));
    assert!(world.passes(data(USER, 200_000, SAMPLE)));
    let silenced =
        (1..1000).filter(|count| world.is_silenced(heartbeat(USER, 1, 200_000, *count))).count();
    assert_eq!(silenced, 999 - 50);
}

#[test]
fn a_writer_does_not_jump_unless_it_stays_there() {
    let mut world = World::new();
    assert!(world.passes(data(USER, 5, SAMPLE)));
    // In its name: its flow would be dead.
    assert!(world.is_silenced(gap(USER, 1, 1 << 40)));
    assert!(world.is_silenced(heartbeat(USER, 1 << 40, 1 << 40, 9)));
    assert!(world.is_silenced(data(USER, 1 << 40, SAMPLE)));
    assert_eq!(world.refused(Reason::Ahead), 3);
    assert!(world.passes(data(USER, 6, SAMPLE)));
    assert!(world.passes(data(USER, 6 + AHEAD / 2, SAMPLE)));
    // Real messages in between: the jump is not accepted.
    for second in 0..10 {
        world.now += Duration::from_secs(1);
        assert!(world.passes(data(USER, 7 + AHEAD / 2 + second, SAMPLE)));
        assert!(world.is_silenced(data(USER, 1 << 50, SAMPLE)));
    }
    // The writer really is there, for instance because this machine's clock was stopped.
    let there = 1 << 45;
    for _ in 0..3 {
        assert!(world.is_silenced(data(USER, there, SAMPLE)));
        world.now += Duration::from_secs(1);
    }
    assert!(world.passes(data(USER, there, SAMPLE)));
    assert!(world.passes(data(USER, there + 1, SAMPLE)));
}

#[test]
fn a_gap_in_the_middle_is_told_little_by_little() {
    let mut world = World::new();
    assert!(world.passes(data(USER, 1, SAMPLE)));
    assert_eq!(world.numbers(gap(USER, 3, 900_000)), (3, 3 + WINDOW));
    assert!(world.passes(gap(USER, 10, 20)));
    for (start, end) in [(0, 5), (9, 8), (-5, 5), (i64::MIN, i64::MAX), (3, i64::MAX)] {
        assert!(world.is_silenced(gap(USER, start, end)), "{start} {end}");
    }
}

#[test]
fn fragments_of_a_sample_that_has_just_become_complete_are_not_heard_twice() {
    let mut world = World::new();
    let piece = |first| fragment(USER, 7, (first, 1, 1000), 1500, &[0; 500]);
    assert!(world.passes(piece(2)));
    assert!(world.passes(piece(2)), "the other one is missing");
    assert!(world.passes(piece(1)));
    assert!(world.is_silenced(piece(2)));
    // A reader that was created later asks for the sample.
    world.now += Duration::from_secs(1);
    assert!(world.passes(piece(2)));
    assert_eq!(world.tally.list(), []);
}

#[test]
fn a_reader_that_lost_much_asks_for_the_whole_sample() {
    let mut world = World::new();
    let number = |number: u32| [[0; 4], number.to_le_bytes()].concat();
    let ends = [[0, 0, 0x12, 0x04], USER].concat();
    let acknack = [&ends[..], &number(3), &[0; 4], &[1, 0, 0, 0]].concat();
    assert!(world.passes(forger::submessage(kind::ACKNACK, 2, &acknack)));
    let set = [&9946_u32.to_le_bytes()[..], &256_u32.to_le_bytes(), &[0xff; 32]].concat();
    let nack_frag = [&ends[..], &number(4), &set, &[2, 0, 0, 0]].concat();
    let nack_frag = forger::submessage(kind::NACK_FRAG, 0, &nack_frag);
    let (asks, body) = world.left(nack_frag.clone());
    let wants = [&2_u32.to_le_bytes()[..], &(1_u32 << 30).to_le_bytes(), &[2, 0, 0, 0]].concat();
    assert_eq!((asks, body), (kind::ACKNACK, [&ends[..], &number(3), &wants].concat()));
    assert!(world.is_silenced(nack_frag));
    assert_eq!(world.tally.list(), []);
}

#[test]
fn samples_in_fragments_are_bounded_each_and_in_all() {
    let mut world = World::with(Limits { sample: 1 << 20, ..Limits::default() });
    for forger in [PEER, OTHER] {
        assert!(world.hears(&mut forger.announcement(1, 7000, 20)));
    }
    let piece = |number, whole| fragment(USER, number, (1, 1, 1000), whole, &[0; 1000]);
    for whole in [u32::MAX, u32::MAX - 7, (1 << 20) + 1] {
        assert!(world.is_silenced(piece(1, whole)), "{whole}");
    }
    // Fragments of one byte.
    assert!(world.is_silenced(fragment(USER, 1, (1, 1, 1), 1 << 20, &[0])));
    // Invalid numbers.
    for (first, count, size) in
        [(0, 1, 1000), (1, 0, 1000), (1, 1, 0), (1, 9, 1000), (u32::MAX, 2, 1000)]
    {
        assert!(world.is_silenced(fragment(USER, 1, (first, count, size), 4000, &[0; 8])));
    }
    // One participant may use half of the memory.
    for number in 1..=4 {
        assert!(world.passes(piece(number, 1 << 20)));
    }
    assert!(world.is_silenced(piece(5, 1 << 20)));
    assert!(world.passes(piece(4, 1 << 20)));
    let mut theirs = OTHER.message(&[piece(1, 1 << 20)]);
    assert!(world.hears(&mut theirs));
    assert_eq!(theirs, OTHER.message(&[piece(1, 1 << 20)]));
    // Samples that are complete or were given up make room.
    for first in 2..=1049 {
        let size = if first == 1049 { (1 << 20) - 1_048_000 } else { 1000 };
        assert!(world.passes(fragment(USER, 4, (first, 1, 1000), 1 << 20, &vec![0; size])));
    }
    assert!(world.passes(piece(5, 1 << 20)));
    assert!(world.is_silenced(piece(6, 1 << 20)));
    world.now += Duration::from_secs(14);
    assert!(world.passes(piece(6, 1 << 20)));
}

#[test]
fn strangers_are_not_heard_and_participants_are_counted() {
    let limits = Limits { participants: 8, ..Limits::default() };
    let mut world = World::with(limits);
    let forger = |number: u8| Forger([1, 16, 0, 0, 0, 0, 0, 0, 0, 0, 0, number]);
    assert!(!world.hears(&mut forger(1).message(&[data(USER, 1, SAMPLE)])));
    for host in 0..2 {
        for number in 0..4 {
            let mut announcement = forger(host * 4 + number).announcement(1, 7000, 20);
            assert!(world.hears_from(&mut announcement, host));
        }
        assert!(!world.hears_from(&mut forger(100 + host).announcement(1, 7000, 20), host));
    }
    assert!(!world.hears_from(&mut forger(100).announcement(1, 7000, 20), 9));
    assert_eq!(world.refused(Reason::Participants), 3);
    // They are forgotten some time after their lease has expired.
    world.now += Duration::from_secs(31);
    assert!(world.hears_from(&mut forger(100).announcement(1, 7000, 20), 9));
    assert!(!world.hears(&mut forger(1).message(&[data(USER, 2, SAMPLE)])));
}

#[test]
fn who_was_silent_for_too_long_is_heard_when_rustdds_has_lost_it() {
    let mut world = World::new();
    world.now += Duration::from_secs(20);
    assert!(world.hears(&mut PEER.announcement(2, 7000, 20)));
    world.now += Duration::from_secs(21);
    assert!(!world.hears(&mut PEER.announcement(3, 7000, 20)));
    assert!(!world.hears(&mut PEER.message(&[data(USER, 1, SAMPLE)])));
    world.now += Duration::from_millis(2600);
    assert!(!world.hears(&mut PEER.message(&[data(USER, 1, SAMPLE)])));
    assert!(world.hears(&mut PEER.announcement(4, 7000, 20)));
    assert!(world.hears(&mut PEER.message(&[data(USER, 1, SAMPLE)])));
    assert_eq!(world.tally.list(), []);
}

#[test]
fn who_comes_back_with_the_same_words_is_heard_anew() {
    let mut world = World::new();
    let number = |datagram: &[u8]| {
        let mut fields = Fields::new(&datagram[HEADER + 4..], true);
        fields.skip(12).unwrap();
        fields.number().unwrap()
    };
    let same = PEER.announcement(1, 7000, 20);
    let mut heard = Vec::new();
    for seconds in [5, 5, 60, 3, 5] {
        world.now += Duration::from_secs(seconds);
        let mut datagram = same.clone();
        if world.hears(&mut datagram) {
            heard.push(number(&datagram));
        }
    }
    let again = 1 + (1 << 40);
    assert_eq!(heard, [1, 1, again, again]);
}

#[test]
fn announcements_that_came_are_not_asked_for_again() {
    let mut world = World::new();
    let end = |number: u8| PEER.end([0, 0, number, 3], "rt/a", "a::msg::dds_::A_");
    for number in [1, 2, 3, 5] {
        assert!(world.passes(data(WRITERS, i64::from(number), &end(number))));
    }
    world.now += Duration::from_secs(60);
    assert!(world.meets_again());
    assert_eq!(world.numbers(heartbeat(WRITERS, 1, 6, 1)), (4, 6));
    assert!(world.passes(data(WRITERS, 4, &end(4))));
    assert_eq!(world.numbers(heartbeat(WRITERS, 1, 6, 2)), (6, 6));
    assert!(world.passes(data(WRITERS, 6, &end(6))));
    assert_eq!(world.numbers(heartbeat(WRITERS, 1, 6, 3)), (7, 6));
    // For other writers RustDDS keeps what it has.
    assert!(world.passes(data(USER, 1, SAMPLE)));
    assert_eq!(world.numbers(heartbeat(USER, 1, 6, 1)), (1, 6));
}

#[test]
fn a_lease_is_bounded_in_place() {
    let mut world = World::new();
    for (asked, granted) in [(20, 20), (50, 50), (51, 50), (i32::MAX.cast_unsigned(), 50)] {
        let mut announcement = OTHER.announcement(1, 7000, asked);
        assert!(world.hears(&mut announcement));
        assert_eq!(announcement, OTHER.announcement(1, 7000, granted));
    }
}

#[test]
fn nobody_announces_in_the_name_of_another() {
    let mut world = World::new();
    let stolen = OTHER.end(USER, "rt/a", "a::msg::dds_::A_");
    assert!(world.is_silenced(data(WRITERS, 1, &stolen)));
    // Built-in writers do not send to users' readers, nor to built-in readers of another kind.
    let mut mixed = data(WRITERS, 1, SAMPLE);
    mixed[8..12].copy_from_slice(&[0, 0, 1, 4]);
    assert!(world.is_silenced(mixed));
    let mut crossed = data([0, 3, 0, 0xc3], 1, &PEER.end(USER, "rt/a", "a::msg::dds_::A_"));
    crossed[8..12].copy_from_slice(&[0, 0, 3, 0xc7]);
    assert!(world.is_silenced(crossed));
    assert_eq!(world.refused(Reason::Name), 3);
}

#[test]
fn announcements_and_ends_are_bounded() {
    let mut world = World::new();
    let long = PEER.end(USER, &"x".repeat(2000), "a::msg::dds_::A_");
    assert!(world.is_silenced(data(WRITERS, 1, &long)));
    assert!(world.is_silenced(data(WRITERS, 1, &[0, 3, 0, 0, 0x5a, 0])));
    let mut refused = 0;
    for number in 0..5000_u32 {
        let [_, a, b, c] = number.to_be_bytes();
        let end = PEER.end([a, b, c, 3], "rt/a", "a::msg::dds_::A_");
        refused += u32::from(world.is_silenced(data(WRITERS, i64::from(number) + 1, &end)));
    }
    assert_eq!(refused, 5000 - 4096);
}

#[test]
fn a_silenced_submessage_leaves_the_others() {
    let mut world = World::new();
    let good = data(USER, 1, SAMPLE);
    let mut datagram = PEER.message(&[heartbeat(USER, 1, HELD * 2, 1), good.clone()]);
    assert!(world.hears(&mut datagram));
    assert!(datagram.ends_with(&good));
    // The last submessage may have length 0, which means up to the end of the message.
    let mut open = data(USER, 1 << 60, SAMPLE);
    open[2..4].fill(0);
    let mut datagram = PEER.message(&[good, open]);
    assert!(world.hears(&mut datagram));
    let first = Head::read(&datagram, HEADER).unwrap().unwrap();
    let second = Head::read(&datagram, first.body.end).unwrap().unwrap();
    assert_eq!((second.kind, second.body.end), (kind::PAD, datagram.len()));
}

#[test]
fn who_says_good_bye_is_heard_once_and_then_a_stranger() {
    let mut world = World::new();
    let bye = |forger: Forger| {
        let key = [&[0x70, 0, 16, 0][..], &forger.0, &[0, 0, 1, 0xc1]].concat();
        let inline = [&key[..], &[0x71, 0, 4, 0, 0, 0, 0, 3, 1, 0, 0, 0]].concat();
        let head = [&[0, 0, 16, 0, 0, 1, 0, 0xc7, 0, 1, 0, 0xc2][..], &[0, 0, 0, 0, 9, 0, 0, 0]];
        forger::submessage(kind::DATA, 2, &[&head.concat()[..], &inline].concat())
    };
    assert!(world.is_silenced(bye(OTHER)));
    assert!(world.hears(&mut PEER.message(&[bye(PEER)])));
    assert!(!world.hears(&mut PEER.message(&[data(USER, 1, SAMPLE)])));
}

fn word() -> impl Strategy<Value = i64> {
    prop_oneof![0..20_i64, any::<i64>(), (0..64_u32).prop_map(|bit| 1_i64.wrapping_shl(bit))]
}

fn any_submessage() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        (word(), word(), any::<i32>()).prop_map(|(a, b, n)| heartbeat(USER, a, b, n)),
        (word(), word()).prop_map(|(a, b)| gap(USER, a, b)),
        (word(), any::<(u32, u16, u16)>(), any::<u32>())
            .prop_map(|(sn, part, whole)| fragment(USER, sn, part, whole, &[0; 64])),
        (word(), prop::collection::vec(any::<u8>(), 0..80))
            .prop_map(|(sn, payload)| data(WRITERS, sn, &payload)),
        (any::<u8>(), any::<u8>(), prop::collection::vec(any::<u8>(), 0..80))
            .prop_map(|(kind, flags, body)| forger::submessage(kind, flags, &body)),
    ]
}

proptest! {
    #[test]
    fn no_datagram_is_too_strange(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let mut world = World::new();
        let _ = world.hears(&mut bytes.clone());
        let _ = world.hears(&mut PEER.message(&[bytes]));
    }

    /// Checks, with a model of RustDDS's state, that what it iterates over after any messages is
    /// bounded.
    #[test]
    fn what_is_heard_is_well_formed_and_bounded(
        messages in prop::collection::vec(prop::collection::vec(any_submessage(), 1..4), 1..30)
    ) {
        let mut world = World::new();
        // RustDDS has all samples before this number.
        let mut base = 1;
        for message in messages {
            world.now += Duration::from_millis(10);
            let mut datagram = PEER.message(&message);
            if !world.hears(&mut datagram) {
                continue;
            }
            let mut at = HEADER;
            while let Some(head) = Head::read(&datagram, at).unwrap() {
                at = head.body.end;
                let body = &datagram[head.body.clone()];
                let mut fields = Fields::new(body, head.little());
                if head.kind == kind::HEARTBEAT && body.get(4..8) == Some(&USER[..]) {
                    fields.skip(8).unwrap();
                    let (first, last) = (fields.number().unwrap(), fields.number().unwrap());
                    base = base.max(first);
                    prop_assert!(last - base <= super::limits::REACH + WINDOW);
                } else if head.kind == kind::GAP && body.get(4..8) == Some(&USER[..]) {
                    fields.skip(8).unwrap();
                    let (start, end) = (fields.number().unwrap(), fields.number().unwrap());
                    prop_assert!(start <= base || end - start <= WINDOW);
                    if start <= base {
                        base = base.max(end);
                    }
                }
            }
        }
    }
}

#[test]
fn what_is_sent_again_is_not_asked_of_rustdds() {
    let mut world = World { repairs: true, ..World::new() };
    let nack = |number, base| forger::nack_fragments(USER, number, base, 1);
    assert!(world.is_silenced(nack(4, 300)));
    let Lack { writer, number, base, missing } = world.lacks[0];
    assert_eq!((writer, number, base, missing.count()), (USER, 4, 300, 1));
    // Strangers, and numbers that cannot be, are not heard.
    assert!(!world.hears(&mut OTHER.message(&[nack(4, 300)])));
    assert!(world.is_silenced(nack(4, u32::MAX)) && world.is_silenced(nack(-4, 300)));
    assert_eq!(world.lacks.len(), 1);
}
