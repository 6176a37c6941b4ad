//! Which codels exclude each other (genom3.md 4.5).

use genom_description::model::{Component, Node};

use super::{component, plain};

/// `name: those it excludes`, for codels and then attributes.
fn table(c: &Component) -> Vec<String> {
    let name = |node: usize| match c.node(node) {
        Node::Codel(codel) => c.codels[codel].name.as_str(),
        Node::Transfer(service) => c.services[service].name.as_str(),
    };
    let mut rows = Vec::new();
    for node in 0..c.codels.len() + c.services.len() {
        let mut others: Vec<_> = c.exclusion(node).iter().map(|other| name(*other)).collect();
        others.sort_unstable();
        if !others.is_empty() {
            rows.push(format!("{}: {}", name(node), others.join(" ")));
        }
    }
    rows.sort_unstable();
    rows
}

#[test]
fn the_worked_example_has_exactly_its_table() {
    let specification = plain(
        "component c { ids { long a; long b; };
           attribute set_a(in a); attribute get_a(out a);
           function f1() { codel c1(in a, out b); };
           function f2() { codel c2(in b, out a); };
           task t { codel<start> c3(in a) yield x; codel<x> c4(in b) yield y;
                    codel<y> c5() yield ether; };
           activity a1() { task t; codel<start> c6(in a, out b) yield z;
                           codel<z> c7(in b, out a) yield ether; }; };",
    );
    assert_eq!(
        table(component(&specification, "c")),
        [
            "c1: c4 c6 c7",
            "c2: c3 c6 c7",
            "c3: c2 set_a",
            "c4: c1",
            "c6: c1 c2 set_a",
            "c7: c1 c2 get_a set_a",
            "get_a: c7",
            "set_a: c3 c6 c7",
        ]
    );
}

#[test]
fn two_tasks_that_read_one_port_exclude_each_other() {
    let specification = plain(
        "component c { typedef long l; port in l p; task t { codel<start> x(in p) yield ether; };
           task u { codel<start> y(in p) yield ether; }; };",
    );
    assert_eq!(table(component(&specification, "c")), ["x: y", "y: x"]);
}

#[test]
fn members_and_elements_exclude_only_what_contains_them() {
    let specification = plain(
        "component c { ids { long a[3]; struct s { long x, y; } b; };
           task t { codel<start> x(out a[1], in b.x) yield ether; };
           task u { codel<start> y(in a[2], out b.y) yield ether; };
           task v { codel<start> z(in a[1], in b) yield ether; };
           task w { codel<start> all(in ::ids) yield ether; }; };",
    );
    assert_eq!(
        table(component(&specification, "c")),
        ["all: x y", "x: all z", "y: all z", "z: x y"]
    );
}

#[test]
fn a_codel_does_not_exclude_those_that_interrupt_its_service() {
    let specification = plain(
        "component c { ids { long v; }; task t; task u;
           activity x() { task t; codel<start> a(out v) yield ether; };
           activity y() { task u; codel<start> b(out v) yield ether; interrupts x; }; };",
    );
    assert_eq!(table(component(&specification, "c")), ["b: a"]);
}

#[test]
fn remotes_never_exclude() {
    let specification = plain(
        "interface i { function r(in long a); };
         component c { uses i; task t { codel<start> x(remote in r) yield ether; };
           task u { codel<start> y(remote in r) yield ether; }; };",
    );
    assert_eq!(table(component(&specification, "c")), [""; 0]);
}
