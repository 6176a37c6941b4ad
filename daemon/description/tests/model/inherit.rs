//! `provides`, `uses`, `extends` and reopening (genom3.md 4.6).

use genom_description::model::{
    CodelIx, Ix as _, PathStep, PortDirection, RemoteIx, ServiceIx, Source, TaskIx,
};

use super::{component, plain};

#[test]
fn uses_flips_ports_and_makes_remotes() {
    let specification = plain(
        "interface i { struct s { long x; }; port out s p; port multiple in s q;
           function f(in long a, out s b); attribute at(); activity ac(); };
         component c { uses i; };",
    );
    let c = component(&specification, "c");
    let ports: Vec<_> =
        c.ports.iter().map(|p| (p.name.as_str(), p.direction, p.multiple)).collect();
    assert_eq!(ports, [("p", PortDirection::In, false), ("q", PortDirection::Out, true)]);
    let remotes: Vec<_> = c.remotes.iter().map(|r| r.name.as_str()).collect();
    assert_eq!(remotes, ["f", "at", "ac"]);
    assert!(c.services.is_empty());
    assert_eq!(specification.types.members(c.remotes[RemoteIx::new(0)].input).len(), 1);
}

#[test]
fn what_is_provided_finds_the_ids_of_the_component() {
    let specification = plain(
        "interface i { ids { long x; long y; };
           task t { period 1 ms; codel<start> s(out y) yield ether; };
           attribute at(in y = 4: \"why\");
           activity run(in long n) { task t; codel<start> r(in n, inout y) yield ether; }; };
         component c { ids { double own; }; provides i; };",
    );
    let c = component(&specification, "c");
    let y = vec![PathStep::Member(2)];
    assert_eq!(c.services[ServiceIx::new(0)].parameters[0].target.as_ref().unwrap().path, y);
    assert_eq!(c.codels[CodelIx::new(0)].parameters[0].source, Source::Ids { path: y.clone() });
    let run = c.codels.iter().find(|codel| codel.name == "r").unwrap();
    assert_eq!(run.parameters[0].source, Source::Parameter { index: 0, path: vec![] });
    assert_eq!(run.parameters[1].source, Source::Ids { path: y });
    assert_eq!(c.services[ServiceIx::new(1)].task, Some(TaskIx::new(0)));
}

#[test]
fn an_interface_extends_another_and_a_component_refines_it() {
    let specification = plain(
        "interface i { function f(in long a = 2: \"two\"); doc \"one\"; requires \"x\"; };
         interface j { extends i; function g(); };
         component c { doc \"two\"; provides j; requires \"x\", \"y\";
           function f(in long a) { codel cf(in a); doc \"refined\"; }; };",
    );
    let c = component(&specification, "c");
    let names: Vec<_> = c.services.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["f", "g"]);
    assert_eq!(c.services[ServiceIx::new(0)].codels.len(), 1);
    assert!(c.services[ServiceIx::new(0)].parameters[0].default.is_some());
    assert_eq!(c.doc.as_deref(), Some("two\none"));
    assert_eq!(c.requires, ["x", "y"]);
}

#[test]
fn bodies_services_tasks_ids_and_modules_are_reopened() {
    let specification = plain(
        "module m { typedef long a; }; module m { typedef a b; };
         component c { ids { m::b x; }; task t; function f(in long a); };
         component c { ids { long y; }; task t { period 1 s; };
           function f(in long a) { local double z; codel g(in a, out z, in y); }; };",
    );
    let c = component(&specification, "c");
    assert_eq!(specification.types.members(c.ids.unwrap()).len(), 2);
    assert!(c.tasks[TaskIx::new(0)].period.is_some());
    assert_eq!(
        c.codels[CodelIx::new(0)].parameters[1].source,
        Source::Local { index: 0, path: vec![] }
    );
}
