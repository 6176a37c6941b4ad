//! The outbox between a real-time publisher and a middleware's thread.

use std::sync::Arc;
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use genom_middleware::bell::Bell;
use genom_middleware::conformance::samples::{number, numbered, set_number, state};
use genom_middleware::outbox::outbox;

/// Only a failing test waits this long.
const WATCHDOG: Duration = Duration::from_secs(60);

#[test]
fn what_is_put_is_taken_in_order() {
    let (mut writer, mut reader) = outbox(&state(), 8, Arc::default());
    assert_eq!(reader.take(number), None);
    for n in 0..8 {
        assert!(writer.put(&numbered(n)));
    }
    for n in 0..8 {
        assert_eq!(reader.take(number), Some(n));
    }
    assert_eq!((reader.take(number), writer.dropped()), (None, 0));
}

#[test]
fn a_stalled_thread_costs_the_oldest_samples_and_each_is_counted() {
    let (mut writer, mut reader) = outbox(&state(), 2, Arc::default());
    assert!(writer.put(&numbered(0)));
    // The thread is stuck within the middleware, with one sample in its hands.
    let in_hand = reader.take(|record| {
        for n in 1..=10 {
            assert!(writer.put(&numbered(n)), "the writer never waits");
        }
        number(record)
    });
    assert_eq!((in_hand, writer.dropped()), (Some(0), 8));
    assert_eq!([reader.take(number), reader.take(number)], [Some(9), Some(10)]);
}

#[test]
fn a_value_of_another_type_is_refused() {
    let (mut writer, mut reader) = outbox(&state(), 2, Arc::default());
    let other = genom_types::Record::new(&genom_middleware::conformance::samples::other_state());
    assert!(!writer.put(&other));
    assert_eq!(reader.take(number), None);
}

#[test]
fn the_reader_learns_that_the_writer_is_gone_after_its_last_sample() {
    let (mut writer, mut reader) = outbox(&state(), 2, Arc::default());
    writer.put(&numbered(1));
    assert!(!reader.is_abandoned());
    drop(writer);
    assert!(reader.is_abandoned());
    assert_eq!(reader.take(number), Some(1));
}

#[test]
fn between_two_threads_none_is_torn_or_out_of_order_and_taken_plus_dropped_is_all() {
    const LAST: u64 = 200_000;
    for depth in [1, 3] {
        let bell = Arc::new(Bell::default());
        let (mut writer, mut reader) = outbox(&state(), depth, Arc::clone(&bell));
        let (done, finished) = channel();
        thread::spawn(move || {
            let (mut previous, mut taken) = (0, 0);
            while previous != LAST {
                if !bell.wait(WATCHDOG) {
                    return;
                }
                while let Some(n) = reader.take(number) {
                    assert!(n > previous, "{n} after {previous}");
                    (previous, taken) = (n, taken + 1);
                }
            }
            let _ = done.send(taken);
        });
        let mut record = numbered(0);
        for n in 1..=LAST {
            set_number(&mut record, n);
            assert!(writer.put(&record));
        }
        let taken: u64 = finished.recv_timeout(WATCHDOG).expect("the last sample is taken");
        assert_eq!(taken + writer.dropped(), LAST);
    }
}

#[test]
fn a_ring_before_the_wait_is_kept_and_none_means_no() {
    let bell = Bell::default();
    bell.ring();
    bell.ring();
    assert!(bell.wait(WATCHDOG));
    assert!(!bell.wait(Duration::ZERO));
}
