//! Mailboxes, index rings and bells between two threads.
//!
//! They hand over plain memory that nothing else synchronises, so that ThreadSanitizer and Miri can
//! tell whether they order the accesses (`docs/proofs.md`).

#![allow(clippy::unwrap_used)]

use std::cell::UnsafeCell;
use std::convert::Infallible;
use std::time::Duration;

use genom_kit::bell::Bell;
use genom_kit::index_ring::IndexRing;
use genom_kit::mailbox::{Full, Mailbox};

/// Number of messages; Miri is a thousand or more times slower.
const LAST: u64 = if cfg!(miri) { 40 } else { 20_000 };
/// Limit after which a test counts as hanging.
const LONG: Duration = Duration::from_secs(60);

/// Plain memory that two threads access in turn.
struct Plain<T>(UnsafeCell<T>);

// SAFETY: only the thread that got the index, or was woken by the bell, accesses it. That is what
// the tests check.
unsafe impl<T: Send> Sync for Plain<T> {}

impl<T> Plain<T> {
    fn new(value: T) -> Self {
        Self(UnsafeCell::new(value))
    }

    fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        // SAFETY: as above; the reference does not outlive `work`.
        work(unsafe { &mut *self.0.get() })
    }
}

#[test]
fn buffers_named_by_a_ring_belong_to_one_thread_at_a_time() {
    // When the ring is full the producer reclaims the oldest buffer; those that the consumer took
    // come back through a second ring.
    const DEPTH: usize = 3;
    let buffers: Vec<_> = (0..DEPTH + 2).map(|_| Plain::new([0u64; 4])).collect();
    let (there, back) = (IndexRing::new(DEPTH), IndexRing::new(DEPTH + 2));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut free: Vec<usize> = (0..buffers.len()).collect();
            for n in 1..=LAST {
                free.extend(std::iter::from_fn(|| back.pop()));
                let index = loop {
                    match free.pop().or_else(|| back.pop()) {
                        Some(index) => break index,
                        None => std::thread::yield_now(),
                    }
                };
                buffers[index].with(|buffer| *buffer = [n; 4]);
                free.extend(there.push_over(index));
            }
        });
        let mut previous = 0;
        while previous < LAST {
            let Some(index) = there.pop() else {
                std::thread::yield_now();
                continue;
            };
            let found = buffers[index].with(|buffer| *buffer);
            assert_eq!(found, [found[0]; 4], "the sample is torn");
            assert!(found[0] > previous, "{} after {previous}", found[0]);
            previous = found[0];
            assert!(back.push_if_free(index));
        }
    });
}

#[test]
fn every_message_of_a_mailbox_arrives_whole_in_order_or_is_counted_as_lost() {
    for full in [Full::Oldest, Full::Newest] {
        let (mailbox, bell) = (Mailbox::new(3, 8, full), Bell::default());
        let mut taken = 0;
        std::thread::scope(|scope| {
            let producer = scope.spawn(|| {
                for n in 1..=LAST {
                    mailbox
                        .put(|message| {
                            message.extend_from_slice(&n.to_le_bytes());
                            message.extend((0..n % 8).map(|_| n as u8));
                            Ok::<_, Infallible>(())
                        })
                        .unwrap();
                    bell.ring();
                }
            });
            let mut previous = 0;
            let mut take = || {
                let whole = |message: &[u8]| {
                    let (n, rest) = message.split_first_chunk().unwrap();
                    let n = u64::from_le_bytes(*n);
                    assert_eq!(rest, vec![n as u8; (n % 8) as usize]);
                    n
                };
                while let Some(n) = mailbox.take(|message| whole(message)) {
                    assert!(n > previous, "{n} after {previous}");
                    (previous, taken) = (n, taken + 1);
                }
            };
            while !producer.is_finished() {
                bell.wait(Some(Duration::from_millis(1)));
                take();
            }
            producer.join().unwrap();
            take();
        });
        assert_eq!(taken + mailbox.lost(), LAST, "{full:?}");
        assert!(taken >= 3);
    }
}

#[test]
fn who_hears_a_bell_sees_what_was_done_before_it_rang() {
    let (ball, there, back) = (Plain::new(0), Bell::default(), Bell::default());
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for n in 0..LAST {
                assert!(there.wait(Some(LONG)), "nobody rings");
                ball.with(|ball| {
                    assert_eq!(*ball, 2 * n + 1);
                    *ball += 1;
                });
                back.ring();
            }
        });
        for n in 0..LAST {
            ball.with(|ball| {
                assert_eq!(*ball, 2 * n);
                *ball += 1;
            });
            there.ring();
            assert!(back.wait(Some(LONG)), "nobody rings back");
        }
    });
    assert_eq!(ball.0.into_inner(), 2 * LAST);
}
