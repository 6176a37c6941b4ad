//! Digests (genom3.md 4.9).

use genom_description::model::{Ix as _, RemoteIx, ServiceIx};

use super::{component, plain, whole};

const EXAMPLE: &str = "component c { struct s { long a; string<8> b; double c[2]; \
    sequence<long> d; }; exception e { short q; }; port out s p; \
    function f(in long x, out s y) { throw e; }; };";

#[test]
fn the_worked_example_has_its_digests() {
    let specification = plain(EXAMPLE);
    let c = component(&specification, "c");
    assert_eq!(c.digest, "1fb4d66bbb8ad1586d8de865f40ae90");
    assert_eq!(c.services[ServiceIx::new(0)].digest, "384aad12927a41b9b5279c6a0474efa");
}

#[test]
fn the_standard_interface_is_part_of_the_digest() {
    let specification = whole(EXAMPLE);
    let c = component(&specification, "c");
    assert_ne!(c.digest, "1fb4d66bbb8ad1586d8de865f40ae90");
}

#[test]
fn a_remote_has_the_digest_of_the_service_it_calls() {
    let specification = whole(
        "interface i { exception e; function f(in long x, out double y) { throw e; }; };
         component server { provides i; };
         component client { uses i; };",
    );
    let provided =
        component(&specification, "server").services.iter().find(|s| s.name == "f").unwrap();
    let used = &component(&specification, "client").remotes[RemoteIx::new(0)];
    assert_eq!(used.name, "f");
    assert_eq!(used.digest, provided.digest);
}

#[test]
fn local_variables_of_a_service_are_no_affair_of_those_who_call_it() {
    let specification = whole(
        "interface i { function f(in long x); };
         component server { provides i; function f(in long x) { local double l; codel c(); }; };
         component client { uses i; };",
    );
    let provided =
        component(&specification, "server").services.iter().find(|s| s.name == "f").unwrap();
    let used = &component(&specification, "client").remotes[RemoteIx::new(0)];
    assert_eq!(used.digest, provided.call_digest);
    assert_ne!(provided.call_digest, provided.digest);
}

#[test]
fn exceptions_count_for_those_who_call() {
    // genom3.md 4.9: an additional exception in the server's `throw` changes the service.
    let specification = whole(
        "interface i { function f(in long x); };
         component server { provides i; exception e { short q; }; function f(in long x) { throw e; }; };
         component client { uses i; };",
    );
    let provided =
        component(&specification, "server").services.iter().find(|s| s.name == "f").unwrap();
    assert_ne!(
        component(&specification, "client").remotes[RemoteIx::new(0)].digest,
        provided.call_digest
    );
}
