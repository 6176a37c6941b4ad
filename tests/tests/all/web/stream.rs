//! The live stream of a page.

use std::io::{BufRead as _, Read as _};

use genom_tests::{Home, until};
use serde_json::json;

use super::visitor::{Visitor, demo, link, next, set_speed};

#[test]
fn one_stream_tells_all_that_a_page_watches_and_only_what_changes() {
    let daemon = demo(Home::new(), &[]);
    let owner = Visitor::with_link(&link(&daemon, &[]));
    let mut live = owner.follows(
        "/live?rate=30&watch=/components/demo/activities&watch=/events&watch=/components/nobody\
         &watch=/components/demo/ports/position/stream%3Frate=30",
    );
    let first = next(&mut live, |told| told["watch"] == 0);
    assert_eq!((&first["status"], &first["body"]["activities"]), (&json!(200), &json!([])));
    let missing = next(&mut live, |told| told["watch"] == 2);
    assert_eq!(missing["body"]["error"]["code"], "no_such_component");
    set_speed(&daemon, "0.01");
    let started = daemon.json(&["start", "demo", "goto", "goal=0.5"]);
    let number = &started["activity"];
    let mut heard = [false; 4];
    // None of these waits for another: a reply that did not change is not sent again.
    while heard != [true; 4] {
        let told = next(&mut live, |_| true);
        assert_ne!(told["watch"], 2, "it did not change: {told}");
        if !heard[0] && told["body"]["activities"][0]["status"] == "running" {
            heard[0] = true;
            set_speed(&daemon, "1");
        }
        heard[1] |=
            told["told"]["event"] == "activity_ended" && told["told"]["activity"] == *number;
        heard[2] |= told["body"]["activities"][0]["status"] == "done";
        heard[3] |= told["watch"] == 3 && told["told"]["position"].is_number();
    }
}

#[test]
fn a_stream_has_the_rights_of_its_session_and_ends_with_it() {
    let daemon = demo(Home::new(), &[]);
    let nobody = Visitor::with_link(&link(&daemon, &["--rights", "wire"]));
    let mut live = nobody.follows("/live?watch=/components&watch=/events");
    let mut refused = [false; 2];
    while refused != [true; 2] {
        let told = next(&mut live, |_| true);
        assert_eq!(told["status"], 403, "{told}");
        refused[0] |= told["body"]["error"]["message"]
            .as_str()
            .is_some_and(|told| told.starts_with("GET /components needs the right `read`"));
        refused[1] |= told["ended"] == true;
    }
    assert_eq!(nobody.sends("DELETE", "/session", "").status, 204);
    next(&mut live, |told| told["over"] == true);
    let mut rest = String::new();
    live.read_to_string(&mut rest).unwrap();
    assert!(!rest.contains("watch"), "{rest}");
}

#[test]
fn a_session_has_a_limited_number_of_streams_of_limited_width() {
    let daemon = demo(Home::new(), &[]);
    let owner = Visitor::with_link(&link(&daemon, &[]));
    let open: Vec<_> = (0..16).map(|_| owner.follows("/live?watch=/components")).collect();
    let refused = owner.gets("/live?watch=/components");
    assert_eq!((refused.status, refused.code().as_str()), (503, "too_many_streams"));
    // Another session has its own.
    let mut other = Visitor::with_link(&link(&daemon, &[])).follows("/live?watch=/components");
    assert!(other.read_line(&mut String::new()).is_ok());
    drop(open);
    until("streams end with their pages", || owner.looks_into("/live?watch=/components") == 200);
    let wide = "&watch=/components".repeat(33);
    for query in [wide.as_str(), "watch=components", "rate=0", "rate=31", "rate=fast", "x=1"] {
        let refused = owner.gets(&format!("/live?{query}"));
        assert!(matches!(refused.status, 400 | 422), "{query}: {refused:?}");
    }
}
