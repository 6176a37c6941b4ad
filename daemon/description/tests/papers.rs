//! The figures of the 2010 and 2011 papers, typed as printed (dialects.md A and B).

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use std::path::PathBuf;
use std::time::Duration;

use genom_description::diagnostic::render;
use genom_description::model::{
    CodelIx, CodelKind, Component, Dialect, Direction, Ix as _, PathStep, PortDirection, PortIx,
    ServiceKind, Source, TaskIx,
};
use genom_description::{Analysis, Options, read, read_text};

fn figure(name: &str) -> Analysis {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/papers").join(name);
    let analysis = read(&[path], &Options::default());
    let said = render::short(&analysis.diagnostics, &analysis.sources);
    assert!(!analysis.has_errors(), "{said}");
    analysis
}

fn only(analysis: &Analysis) -> &Component {
    assert_eq!(analysis.specification.components.len(), 1);
    &analysis.specification.components[0]
}

fn machine(component: &Component, service: &str) -> Vec<String> {
    let service = component.services.iter().find(|s| s.name == service).unwrap();
    let show = |ix: &CodelIx| {
        let codel = &component.codels[*ix];
        let CodelKind::Fsm { triggers, yields } = &codel.kind else { panic!("no state") };
        let from: Vec<_> = triggers.iter().map(|s| component.states[*s].as_str()).collect();
        let to: Vec<_> = yields.iter().map(|y| component.states[y.state].as_str()).collect();
        let parameters: Vec<_> = codel.parameters.iter().map(|p| p.name.as_str()).collect();
        format!(
            "{} -> {}({}) -> {}",
            from.join(","),
            codel.name,
            parameters.join(","),
            to.join(",")
        )
    };
    service.codels.iter().map(show).collect()
}

#[test]
fn the_figure_of_2010_reads_as_printed() {
    let analysis = figure("figure-2010.gen");
    let demo = only(&analysis);
    assert_eq!((demo.name.as_str(), demo.dialect), ("demo", Dialect::Paper2010));
    assert_eq!(demo.lang, "c");
    let ports: Vec<_> = demo.ports.iter().skip(1).map(|p| (p.name.as_str(), p.direction)).collect();
    assert_eq!(ports, [("parameter", PortDirection::In), ("position", PortDirection::Out)]);
    let sinks: Vec<_> = demo.sinks.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(sinks, ["emergency"]);
    assert_eq!(demo.states[demo.sinks[0].state], "emergency");
    assert_eq!(demo.tasks[TaskIx::new(0)].period, Some(Duration::from_millis(5)));
    assert_eq!(demo.tasks[TaskIx::new(0)].priority, Some(20));
    assert_eq!(
        machine(demo, "goto"),
        [
            "start -> demo_init_velocity(velocity) -> main",
            "main -> demo_servo(position,velocity,position_port) -> main,stop",
            "stop,emergency -> demo_stop() -> ether",
        ]
    );
    let goto = demo.services.iter().find(|s| s.name == "goto").unwrap();
    assert_eq!(
        (goto.kind, goto.task, goto.through_ids),
        (ServiceKind::Activity, Some(TaskIx::new(0)), true)
    );
    assert_eq!(goto.parameters.len(), 1);
    assert_eq!(goto.parameters[0].direction, Direction::InOut);
    assert_eq!(goto.parameters[0].target.as_ref().unwrap().path, [PathStep::Member(0)]);
    let servo = demo.codels.iter().find(|c| c.name == "demo_servo").unwrap();
    assert_eq!(servo.parameters[0].source, Source::Ids { path: vec![PathStep::Member(0)] });
    assert_eq!(servo.parameters[2].source, Source::Port(PortIx::new(2)));
    let thrown: Vec<_> = goto
        .throws
        .iter()
        .filter_map(|ty| analysis.specification.types.kind(*ty).name())
        .map(ToString::to_string)
        .collect();
    assert!(thrown.contains(&"::demo::SERVO_ERROR".to_owned()), "{thrown:?}");
    // `goto` is incompatible with itself: the newest one interrupts the one that runs.
    let own = demo.services.find(|s| s.name == "goto").unwrap();
    assert_eq!(goto.interrupts, [own]);
}

#[test]
fn the_figure_of_2011_reads_as_printed() {
    let analysis = figure("figure-2011.gen");
    let demo = only(&analysis);
    assert_eq!(demo.dialect, Dialect::Paper2011);
    let kinds: Vec<_> =
        demo.services.iter().filter(|s| !s.standard).map(|s| (s.name.as_str(), s.kind)).collect();
    assert_eq!(kinds, [("setspeed", ServiceKind::Attribute), ("goto", ServiceKind::Activity)]);
    // Used without a declaration: the use declares it.
    assert_eq!(demo.sinks.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["emergency"]);
    let check = demo.codels.iter().find(|c| c.name == "demo_chk_velocity").unwrap();
    assert!(matches!(check.kind, CodelKind::Validate));
    assert_eq!(check.parameters[0].source, Source::Parameter { index: 0, path: vec![] });
    let servo = demo.codels.iter().find(|c| c.name == "demo_servo").unwrap();
    assert_eq!(servo.parameters[0].source, Source::Ids { path: vec![PathStep::Member(0)] });
    let goto = demo.services.iter().find(|s| s.name == "goto").unwrap();
    assert!(goto.through_ids);
    assert_eq!(goto.parameters[0].direction, Direction::In);
}

#[test]
fn services_of_the_papers_say_what_they_interrupt() {
    let text = "component c { language: \"c\"; };
        ids s { long a; long b; };
        task t;
        service x() { task: t; interrupts: y; codel start: fx(out a) yield ether; }
        service y() { task: t; codel start: fy(out b) yield ether, sleep; }
        service z() { task: t; codel start: fz(in b) yield ether; }
        service w() { task: t; codel start: fw() yield ether; }";
    let analysis = read_text("c.gen", text, &Options::default());
    assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
    let c = only(&analysis);
    let interrupts = |name: &str| -> Vec<&str> {
        let service = c.services.iter().find(|s| s.name == name).unwrap();
        service.interrupts.iter().map(|rank| c.services[*rank].name.as_str()).collect()
    };
    assert_eq!(interrupts("x"), ["y"]);
    assert_eq!(interrupts("y"), ["y", "z"]);
    assert_eq!(interrupts("z"), ["y"]);
    assert_eq!(interrupts("w"), [""; 0]);
}

#[test]
fn events_are_read_in_current_components_too() {
    let text = "component c {
        event emergency;
        task t;
        activity a() { task t;
          codel<start> f() yield pause::start, ether;
          codel<emergency> g() yield sleep, ether; };
      };";
    let analysis = read_text("c.gen", text, &Options::default());
    assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
    assert_eq!(only(&analysis).dialect, Dialect::Current);
    assert_eq!(only(&analysis).sinks[0].name, "emergency");
}

#[test]
fn what_stands_outside_of_a_current_component_is_refused() {
    let text = "component c { task t; };\ntask u;\n";
    let analysis = read_text("c.gen", text, &Options::default());
    let codes: Vec<_> = analysis.diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(codes, ["E0104"]);
}

#[test]
fn a_colon_in_a_current_component_is_refused() {
    let text = "component c { task t { period: 5ms; }; };";
    let analysis = read_text("c.gen", text, &Options::default());
    assert_eq!(analysis.diagnostics[0].code, "E0103");
}
