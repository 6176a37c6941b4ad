//! The standard interface in every component (genom3.md 4.8).

use genom_description::model::{Ix as _, ServiceIx, TaskIx};

use super::{component, type_names, whole};
use genom_description::{Options, read_text};

#[test]
fn every_component_begins_with_the_standard_services_and_port() {
    let specification = whole("component c { function f(); typedef long l; port out l p; };");
    let c = component(&specification, "c");
    let services: Vec<_> = c.services.iter().map(|s| (s.name.as_str(), s.standard)).collect();
    assert_eq!(
        services,
        [
            ("abort_activity", true),
            ("connect_port", true),
            ("connect_service", true),
            ("kill", true),
            ("f", false)
        ]
    );
    let ports: Vec<_> = c.ports.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(ports, ["genom_state", "p"]);
    assert_eq!(c.services[ServiceIx::new(3)].interrupts, [0, 1, 2, 3, 4].map(ServiceIx::new));
    assert_eq!(*c.states, ["ether", "start", "stop"]);
}

#[test]
fn every_service_may_throw_the_seven_standard_exceptions() {
    let specification = whole(
        "component c { exception e, d; throw d; task t { throw e; };
           activity a() { task t; codel<start> x() yield ether; throw d; }; };",
    );
    let c = component(&specification, "c");
    assert_eq!(
        type_names(&specification, &c.services[ServiceIx::new(4)].throws),
        [
            "::genom::incompatible_digest",
            "::genom::bad_transition",
            "::genom::interrupted",
            "::genom::serialization",
            "::genom::too_many_activities",
            "::genom::disallowed",
            "::genom::mwerr",
            "::c::d",
            "::c::e",
        ]
    );
    assert_eq!(c.tasks[TaskIx::new(0)].throws, c.services[ServiceIx::new(4)].throws);
    assert!(type_names(&specification, &c.throws).contains(&"::genom::port_io".to_owned()));
}

#[test]
fn one_who_gives_the_interface_gets_it_once() {
    let text = "interface genom { function kill() { interrupts all; }; };
        #pragma provides genom\ncomponent c;";
    let specification = whole(text);
    let c = component(&specification, "c");
    assert_eq!(c.services.len(), 1);
    assert!(c.services[ServiceIx::new(0)].standard);
}

#[test]
fn a_service_that_takes_a_standard_name_is_told_so() {
    let analysis = read_text("c.gen", "component c { activity kill(); };", &Options::default());
    let error = &analysis.diagnostics[0];
    assert_eq!(error.code, "E0603");
    assert!(error.help.as_ref().unwrap().contains("part of every component"), "{error:?}");
}
