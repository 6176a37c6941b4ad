//! The language of TChecker.

use std::fmt::Write as _;

use genom_formal::{Flat, FlatTo, System};

pub(crate) fn tchecker(system: &System, flat: &Flat) -> String {
    let name = &system.plan().component().name;
    let mut text = format!(
        "# Component {name}, with its clocks in units of {} ns. Checked by TChecker, saved as\n\
         # {name}.tck: a label that can be reached says that the task is late; `unreachable` never is.\n",
        flat.unit
    );
    for (_, task) in &flat.late {
        let _ = writeln!(text, "#   tck-reach -a covreach -l late_{task} {name}.tck");
    }
    let _ = writeln!(text, "#   tck-reach -a covreach -l unreachable {name}.tck");
    let _ = writeln!(text, "system:{name}\nevent:tau");
    flat.clocks.iter().for_each(|clock| {
        let _ = writeln!(text, "clock:1:{clock}");
    });
    let _ = writeln!(text, "process:p");
    for (at, (clock, most, _)) in flat.before.iter().enumerate() {
        let first = if at == 0 { "initial: : " } else { "" };
        let _ = writeln!(text, "location:p:b{at}{{{first}invariant: {clock}<={most}}}");
    }
    for (at, location) in flat.states.iter().enumerate() {
        let mut all = Vec::new();
        if at == 0 && flat.before.is_empty() {
            all.push("initial:".to_owned());
        }
        if location.urgent {
            all.push("urgent:".to_owned());
        }
        let most = location.most.iter().map(|(clock, most)| format!("{clock}<={most}"));
        let most: Vec<String> = most.collect();
        if !most.is_empty() {
            all.push(format!("invariant: {}", most.join(" && ")));
        }
        let _ = writeln!(text, "location:p:s{at}{{{}}}", all.join(" : "));
    }
    for (_, task) in &flat.late {
        let _ = writeln!(text, "location:p:late_{task}{{urgent: : labels: late_{task}}}");
    }
    let _ = writeln!(text, "location:p:unreachable{{urgent: : labels: unreachable}}");
    for (at, (clock, most, begins)) in flat.before.iter().enumerate() {
        let to = if at + 1 == flat.before.len() { "s0".into() } else { format!("b{}", at + 1) };
        let begin = if begins.is_empty() { String::new() } else { format!(" : do: {begins}=0") };
        let _ = writeln!(text, "edge:p:b{at}:{to}:tau{{provided: {clock}=={most}{begin}}}");
    }
    for edge in &flat.steps {
        let name = |task: u16| flat.late.iter().find(|(late, _)| *late == task);
        let (to, all) = match edge.to {
            FlatTo::State(to) => (format!("s{to}"), false),
            FlatTo::Unreachable => ("unreachable".into(), true),
            FlatTo::Late(task) => {
                (format!("late_{}", name(task).map_or("", |(_, name)| name.as_str())), true)
            }
        };
        let mut parts = Vec::new();
        if let Some((clock, least)) = &edge.least {
            parts.push(format!("provided: {clock}>={least}"));
        }
        // There nothing is of interest but that it was reached.
        let begins = if all { &flat.clocks } else { &edge.begins };
        let resets: Vec<String> = begins.iter().map(|clock| format!("{clock}=0")).collect();
        if !resets.is_empty() {
            parts.push(format!("do: {}", resets.join("; ")));
        }
        let _ = writeln!(text, "edge:p:s{}:{to}:tau{{{}}}", edge.from, parts.join(" : "));
    }
    text
}
