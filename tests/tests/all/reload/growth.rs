//! What many reloads leave behind: nothing.

use genom_tests::reloads::reloads;
use genom_tests::{Daemon, until};

use super::{Author, count, held, mapped, text};

#[test]
fn after_many_reloads_nothing_has_grown_and_all_is_as_without() {
    const RELOADS: usize = 60;
    let author = Author::new();
    let libraries = [author.make("one.so", super::C, 1), author.make("two.so", super::C, 2)];
    let library = author.save(1);
    let daemon = Daemon::start(&["--clock", "virtual", text(&library)]);
    let pid = daemon.process().id();
    daemon.ctl(&["start", "edit", "run"]).expect_code(0);
    daemon.step(5);
    let counted = count(&daemon);
    let mut before = (0, 0);
    for reload in 0..RELOADS {
        let one = text(&libraries[reload % 2]);
        let told = daemon.json(&["reload", "edit", one]);
        assert!(told["old_stays"].is_null(), "{told}");
        daemon.step(5);
        if reload == 4 {
            before = held(pid);
        }
    }
    assert_eq!(count(&daemon), counted + 3 * RELOADS as i64 / 2);
    assert_eq!([mapped(pid, "edit.so"), mapped(pid, "one.so")], [0, 0]);
    assert_eq!(mapped(pid, "two.so"), 1);
    until("nothing is held that was not before", || held(pid) <= before);
    let running = daemon.json(&["activities", "edit"])["activities"][0].clone();
    assert_eq!(running["state"], "main");
}

#[test]
fn under_load_ids_ports_and_activities_are_as_without_reloads() {
    for (in_cell, described) in [(false, false), (true, false), (false, true), (true, true)] {
        let did = reloads(30, in_cell, described);
        let [before, after] = [did.before, did.after].map(|held| held.footprint);
        assert!(after.descriptors <= before.descriptors + 4, "{did:?}");
        assert!(after.threads <= before.threads + 4, "{did:?}");
        assert!(did.after.maps <= did.before.maps + 16, "{did:?}");
    }
}
