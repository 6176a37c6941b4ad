//! Diagrams and descriptions of components.

use expect_test::expect_file;
use genom_description_tools::{Graph, describe, describe_text, graph};

use crate::support::{accepted, all_accepted, path};

#[test]
fn the_papers_component_is_drawn() {
    let analysis = accepted(&path("../description/tests/papers/figure-2010.gen"));
    let component = &analysis.specification.components[0];
    expect_file!["figure-2010.dot"].assert_eq(&graph(component, Graph::Dot));
    expect_file!["figure-2010.mermaid"].assert_eq(&graph(component, Graph::Mermaid));
    let spec = &analysis.specification;
    expect_file!["figure-2010.txt"].assert_eq(&describe_text(spec, component));
}

#[test]
fn everything_declared_is_described() {
    let analysis = accepted(&path("tests/tools/rich.gen"));
    let spec = &analysis.specification;
    let demo = describe(spec, &spec.components[0]);
    let at = |pointer: &str| demo.pointer(pointer).cloned().unwrap_or_default();
    assert_eq!(at("/name"), "demo");
    assert_eq!(at("/tasks/0/period"), 0.005);
    assert_eq!(
        at("/tasks/0/codels/0/yields"),
        serde_json::json!(["pause::start", "step", "ether"])
    );
    let services: Vec<_> = at("/services").as_array().unwrap().clone();
    let names: Vec<_> = services.iter().map(|s| s["name"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        ["abort_activity", "connect_port", "connect_service", "kill", "set", "f", "act"]
    );
    let f = services.iter().find(|s| s["name"] == "f").unwrap();
    assert_eq!(f["parameters"][4]["default"], serde_json::json!({"a": 1}));
    let sources: Vec<_> = f["codels"][1]["parameters"].as_array().unwrap().clone();
    let sources: Vec<_> =
        sources.iter().map(|p| p["source"].as_str().unwrap().to_owned()).collect();
    assert_eq!(sources[..3], ["ids st.b", "ids sq[0].a", "ids bsq"]);
    assert_eq!(sources.last().unwrap(), "ids");
    expect_file!["rich.txt"].assert_eq(&describe_text(spec, &spec.components[0]));
}

#[test]
fn every_accepted_component_can_be_drawn_and_described() {
    for (_, analysis) in all_accepted() {
        let spec = &analysis.specification;
        for component in &spec.components {
            let dot = graph(component, Graph::Dot);
            assert_eq!(dot.matches('{').count(), dot.matches('}').count());
            let mermaid = graph(component, Graph::Mermaid);
            let opened = mermaid.lines().filter(|line| line.trim().starts_with("subgraph")).count();
            assert_eq!(opened, mermaid.lines().filter(|line| line.trim() == "end").count());
            assert_eq!(describe(spec, component)["name"], component.name.as_str());
            assert!(describe_text(spec, component).starts_with("component "));
        }
    }
}
