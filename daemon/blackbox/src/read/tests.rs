//! What is written is read, and nothing that may stand in the memory does harm.

use std::os::unix::fs::FileExt as _;

use proptest::prelude::*;

use super::*;
use crate::{LEAST_BYTES, Track, Writer};

fn made() -> (Memory, Writer) {
    let memory = Memory::new(LEAST_BYTES).unwrap();
    let writer = Writer::new(&memory).unwrap();
    (memory, writer)
}

/// A record whose content can be told from its number.
fn put(track: &mut Track, number: u64, length: usize) {
    let content: Vec<u8> = (0..length).map(|at| (number as usize + at) as u8).collect();
    track.put(1000 + number, &content);
}

#[track_caller]
fn check(kept: &Kept) {
    for record in kept.records() {
        assert_eq!(record.moment, 1000 + record.number);
        let right = |(at, byte): (usize, &u8)| *byte == (record.number as usize + at) as u8;
        assert!(record.content.iter().enumerate().all(right), "{}", record.number);
    }
}

#[test]
fn the_latest_records_are_kept_and_the_oldest_dropped() {
    let (memory, writer) = made();
    let mut track = writer.track(b"one", 64 << 10).unwrap();
    for number in 0..10_000 {
        put(&mut track, number, 100);
    }
    let [kept] = &read(&memory).unwrap()[..] else { panic!("one track") };
    check(kept);
    assert_eq!((&*kept.head, kept.open, kept.taken, kept.refused), (&b"one"[..], true, 10_000, 0));
    let numbers: Vec<u64> = kept.records().map(|one| one.number).collect();
    // Nearly all of its share: 128 bytes a record.
    let least = ((64 << 10) - 2 * BLOCK) / 128;
    assert!(numbers.len() >= least && numbers.len() <= (64 << 10) / 128, "{}", numbers.len());
    assert_eq!(numbers.last(), Some(&9_999));
    assert_eq!(kept.dropped(), numbers[0]);
    assert!(numbers.is_sorted_by(|one, other| one + 1 == *other));
    drop(track);
    let told = filled(&memory).unwrap();
    assert!(told.bytes <= 64 << 10 && told.tracks == 0, "{told:?}");
    assert!(!read(&memory).unwrap()[0].open);
}

#[test]
fn a_loud_track_leaves_the_others_their_blocks() {
    let (memory, writer) = made();
    let mut loud = writer.track(b"loud", 64 << 10).unwrap();
    let mut quiet = writer.track(b"quiet", 64 << 10).unwrap();
    for number in 0..5_000 {
        if number < 100 {
            put(&mut quiet, number, 40);
        }
        put(&mut loud, number, 500);
    }
    let kept = read(&memory).unwrap();
    kept.iter().for_each(check);
    assert_eq!(kept[1].records().len(), 100);
}

#[test]
fn what_is_larger_than_a_block_is_kept_whole_and_what_is_larger_than_a_track_is_counted() {
    let (memory, writer) = made();
    let mut track = writer.track(b"image", 64 << 10).unwrap();
    for number in 0..50 {
        put(&mut track, number, 10_001);
    }
    track.put(0, &[0; 64 << 10]);
    track.lose();
    let kept = &read(&memory).unwrap()[0];
    check(kept);
    assert_eq!((kept.taken, kept.refused), (52, 2));
    let numbers: Vec<u64> = kept.records().map(|one| one.number).collect();
    assert_eq!(numbers, [44, 45, 46, 47, 48, 49]);
}

#[test]
fn tracks_reach_back_equally_far_when_memory_is_short() {
    let (memory, writer) = made();
    let track = |name: &str| writer.track(name.as_bytes(), 1 << 20).unwrap();
    let mut all: Vec<Track> = (0..10).map(|number| track(&number.to_string())).collect();
    for number in 0..2_000 {
        for (rank, track) in all.iter_mut().enumerate() {
            put(track, number, 40 + 20 * rank);
        }
    }
    let kept = read(&memory).unwrap();
    kept.iter().for_each(check);
    let first: Vec<u64> = kept.iter().map(Kept::dropped).collect();
    let (low, high) = (first.iter().min().unwrap(), first.iter().max().unwrap());
    // A block of the smallest is 32 records.
    assert!(*low > 1_000 && high - low <= 2 * 32, "{first:?}");
}

#[test]
fn more_tracks_than_there_is_room_for_are_refused_and_those_that_ended_make_room() {
    let (memory, writer) = made();
    let most = usize::try_from(LEAST_BYTES).unwrap() / BLOCK / 2;
    let all: Vec<Track> = (0..most).map(|_| writer.track(b"x", 0).unwrap()).collect();
    assert_eq!(writer.track(b"x", 0).unwrap_err(), crate::NoRoom::Tracks(most));
    drop(all);
    for number in 0..1_000 {
        let mut track = writer.track(format!("again {number}").as_bytes(), 0).unwrap();
        put(&mut track, 0, 8);
    }
    let kept = read(&memory).unwrap();
    assert!(kept.len() <= 2 * most && kept.iter().any(|one| one.head == b"again 999"));
    kept.iter().for_each(check);
    assert_eq!(writer.track(&[0; LONGEST_HEAD + 1], 0).unwrap_err(), crate::NoRoom::Heads);
}

#[test]
fn what_is_read_while_threads_write_is_never_torn() {
    let (memory, writer) = made();
    let done = std::sync::atomic::AtomicBool::new(false);
    std::thread::scope(|scope| {
        for name in ["one", "other", "third"] {
            let (writer, done) = (&writer, &done);
            scope.spawn(move || {
                let mut track = writer.track(name.as_bytes(), 1 << 20).unwrap();
                let mut number = 0;
                while !done.load(std::sync::atomic::Ordering::Relaxed) {
                    put(&mut track, number, 10 + number as usize % 3_000);
                    number += 1;
                }
            });
        }
        for _ in 0..200 {
            read(&memory).unwrap().iter().for_each(check);
        }
        done.store(true, std::sync::atomic::Ordering::Relaxed);
    });
}

#[test]
fn a_memory_is_known_by_another_process_and_its_size_is_fixed() {
    let (memory, writer) = made();
    put(&mut writer.track(b"seen", 0).unwrap(), 0, 30);
    let same = Memory::of_process(std::process::id());
    // Tests beside this one have some, too.
    assert!(same.is_ok());
    assert!(memory.file.set_len(0).is_err() && memory.file.set_len(1 << 40).is_err());
    let other = std::fs::File::open("/dev/null").unwrap();
    assert!(matches!(Memory::of(other.into()), Err(crate::MemoryError::Other)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn a_memory_that_was_scribbled_over_is_read_without_harm(
        pieces in prop::collection::vec((any::<prop::sample::Index>(), any::<Vec<u8>>()), 1..60),
        word in any::<u64>(),
    ) {
        let (memory, writer) = made();
        let mut track = writer.track(b"one", 64 << 10).unwrap();
        (0..500).for_each(|number| put(&mut track, number, 300));
        let tables = memory.layout.heads();
        for (at, bytes) in pieces {
            let at = at.index(tables) as u64;
            memory.file.write_all_at(&bytes, at).unwrap();
            memory.file.write_all_at(&word.to_le_bytes(), at & !7).unwrap();
        }
        let _ = (read(&memory).unwrap(), filled(&memory).unwrap());
        // The writer goes on, too.
        (0..500).for_each(|number| put(&mut track, number, 300));
    }
}
