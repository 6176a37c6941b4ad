//! `genomctl info`: describes a running component.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{
    Component, Description, Parameter, PortDescription, Service, ServiceKind, routes,
};

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::Session;

/// Describe a component, or one of its services.
///
/// `= ?` after an input of an attribute means that the input keeps its present value when it is
/// left out of a call. For a single service this value is shown as well: `velocity ? 0.5`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
    /// Name of a service, to describe only that one.
    #[arg(add = ArgValueCompleter::from(Names::Services))]
    service: Option<String>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    if let Some(service) = &args.service {
        let reply = session.ask(routes::service(&args.component, service)).await?;
        return session.show(&reply, |service| render_service(service, ""));
    }
    session.show(&session.ask(routes::component(&args.component)).await?, render)
}

fn render(reply: &Description) -> String {
    let Component { name, component, backend, library, .. } = &reply.instance;
    let mut out = format!("{name} ({component} {})\n", reply.version);
    push_doc(&mut out, "  ", reply.doc.as_deref());
    out.push_str(&format!("  backend {backend}, library {}\n", library.display()));
    for backend in backend.names() {
        let there = |served: &Vec<String>| served.iter().any(|on| on == backend);
        let absent = reply.services.iter();
        let absent = absent.filter(|one| one.served.as_ref().is_some_and(|on| !there(on)));
        let absent: Vec<_> = absent.map(|service| service.name.as_str()).collect();
        if !absent.is_empty() {
            let what = if absent.len() == reply.services.len() {
                "no service".to_owned()
            } else {
                format!("all services but {}", absent.join(", "))
            };
            out.push_str(&format!("  {backend} has {what}\n"));
        }
    }
    for task in &reply.tasks {
        match task.period {
            Some(period) => out.push_str(&format!("task {} every {period} s\n", task.name)),
            None => out.push_str(&format!("task {}\n", task.name)),
        }
    }
    for port in &reply.ports {
        let multiple = if port.multiple { "multiple " } else { "" };
        let PortDescription { direction, ty, name, .. } = port;
        out.push_str(&format!("port {multiple}{direction} {ty} {name}\n"));
        push_doc(&mut out, "    ", port.doc.as_deref());
    }
    for event in &reply.events {
        out.push_str(&format!("event {event}\n"));
    }
    for service in reply.services.iter().filter(|service| !service.standard) {
        out.push_str(&render_service(service, ""));
    }
    for service in reply.services.iter().filter(|service| service.standard) {
        out.push_str(&render_service(service, "standard "));
    }
    out
}

fn render_service(service: &Service, prefix: &str) -> String {
    let Service { kind, name, .. } = service;
    let keeps = *kind == ServiceKind::Attribute;
    let parameters: Vec<String> =
        service.parameters.iter().map(|one| signature(one, keeps)).collect();
    let mut out = format!("{prefix}{kind} {name}({})\n", parameters.join(", "));
    push_doc(&mut out, "    ", service.doc.as_deref());
    for parameter in &service.parameters {
        if let Some(doc) = &parameter.doc {
            out.push_str(&format!("    {}: {doc}\n", parameter.name));
        }
        if let Some(current) = &parameter.current {
            out.push_str(&format!("    {} ? {current}\n", parameter.name));
        }
    }
    let mut facts = Vec::new();
    facts.extend(service.task.as_ref().map(|task| format!("task {task}")));
    // Exceptions that every service may raise are left out.
    let throws = service.throws.iter().filter(|name| !name.starts_with("::genom::"));
    let throws: Vec<String> = throws.cloned().collect();
    for (word, names) in [("interrupts", &service.interrupts), ("throws", &throws)] {
        if !names.is_empty() && prefix.is_empty() {
            facts.push(format!("{word} {}", names.join(", ")));
        }
    }
    if !facts.is_empty() {
        out.push_str(&format!("    [{}]\n", facts.join("; ")));
    }
    out
}

/// The form of an input in a call; `keeps` if it keeps its present value when left out.
fn signature(parameter: &Parameter, keeps: bool) -> String {
    let Parameter { direction, ty, name, .. } = parameter;
    match &parameter.default {
        _ if keeps && direction.is_input() => format!("{direction} {ty} {name} = ?"),
        Some(default) => format!("{direction} {ty} {name} = {default}"),
        None => format!("{direction} {ty} {name}"),
    }
}

fn push_doc(out: &mut String, indent: &str, doc: Option<&str>) {
    for line in doc.unwrap_or_default().lines().map(str::trim).filter(|line| !line.is_empty()) {
        out.push_str(&format!("{indent}{line}\n"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;
    use serde_json::json;

    #[test]
    fn a_component_reads_like_its_description() {
        let reply = serde_json::from_value(json!({
            "name": "arm", "component": "demo", "version": "1.0", "doc": "A servo.",
            "backend": "shm", "library": "/x/demo.so", "state": "running", "activities": 0,
            "tasks": [{"name": "main", "period": 0.005}],
            "ports": [{"name": "position", "direction": "out", "multiple": false, "type": "double"}],
            "events": ["emergency"],
            "services": [{
                "name": "goto", "kind": "activity", "task": "main", "doc": "Moves.",
                "parameters": [{"name": "goal", "direction": "in", "type": "double",
                                "default": 1.0, "doc": "where to"}],
                "interrupts": ["goto"], "throws": ["::demo::TOO_FAR"],
            }],
        }));
        expect![[r#"
            arm (demo 1.0)
              A servo.
              backend shm, library /x/demo.so
            task main every 0.005 s
            port out double position
            event emergency
            activity goto(in double goal = 1.0)
                Moves.
                goal: where to
                [task main; interrupts goto; throws ::demo::TOO_FAR]
        "#]]
        .assert_eq(&render(&reply.unwrap()));
    }

    #[test]
    fn what_an_attribute_keeps_is_marked_and_shown() {
        let parameter = |name: &str, direction: &str| json!({"name": name, "direction": direction, "type": "double", "default": 0.5});
        let mut velocity = parameter("velocity", "in");
        velocity["current"] = json!(0.3);
        let service = json!({
            "name": "set", "kind": "attribute", "parameters": [velocity, parameter("was", "out")],
        });
        expect![[r#"
            attribute set(in double velocity = ?, out double was = 0.5)
                velocity ? 0.3
        "#]]
        .assert_eq(&render_service(&serde_json::from_value(service).unwrap(), ""));
    }
}
