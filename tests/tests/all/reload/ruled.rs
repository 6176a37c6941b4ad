//! What a component is supervised by, and what is done when it fails, is the same after a reload.

use genom_tests::{Home, signal, until};

use super::described::wider;
use super::{Author, C, count, text};

/// `edit` in a cell, supervised, and another one beside it.
fn robot(library: &str) -> String {
    format!(
        "[[component]]\nlibrary = {library:?}\nname = \"other\"\n\
         [[component]]\nlibrary = {library:?}\ncell = \"arm\"\n\
         [component.on_failure]\ncall = \"other/set_note\"\ninputs = {{ note = \"safe\" }}\n\
         [[component.supervision]]\ncodel = \"edit_hang\"\nlongest_ms = 20\nreaction = \"event\"\n\
         [cells]\nrestart_delay = 0.0\n"
    )
}

#[test]
fn rules_of_supervision_and_of_faults_hold_after_a_reload_with_either_description() {
    for described in [false, true] {
        let author = Author::new();
        let library = author.save(1);
        let daemon = Home::new().configured(&robot(text(&library))).start(&[]);
        let mut events = daemon.events();
        if described {
            let (gen_text, c) = wider();
            author.describe(&gen_text);
            author.make("edit.so", &c, 1_000_000);
        } else {
            author.make("edit.so", C, 1_000_000);
        }
        daemon.ctl(&["reload", "edit"]).expect_code(0);
        until("it counts by the new step", || count(&daemon) > 1_000_000);
        daemon.ctl(&["start", "edit", "hang"]).expect_code(0);
        let told = events.wait_for(|change| change["event"] == "supervision_violated");
        assert_eq!(told["component"], "edit", "{told}");
        assert!(signal(&daemon.json(&["cells"])["cells"][0]["pid"], "KILL"));
        let note = || daemon.json(&["call", "other", "get"])["result"]["note"].clone();
        until("what is to be done is done", || note() == "safe");
    }
}
