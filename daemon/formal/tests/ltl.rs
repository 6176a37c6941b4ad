//! Formulas of users: how they are read, and whether they hold.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use genom_formal::{Bounds, Formula, Limits, System, Verdict};
use support::{limits, system};

const TEXT: &str = "component c {
  task t { period 10 ms; codel<start> t0() yield ether; };
  activity go() { task t; codel<start> g0() yield pause::main;
    codel<main> g1() yield pause::main, ether; codel<stop> g2() yield ether; interrupts go; };
  activity home() { task t; codel<start> h0() yield ether; after go; };
};";

fn component() -> System {
    system(TEXT, Bounds::default(), true)
}

fn verdict(text: &str) -> Verdict {
    let system = component();
    let formula = Formula::new(&system, text).unwrap_or_else(|error| panic!("{text}: {error}"));
    system.check_past(&formula, &limits()).unwrap_or_else(|| panic!("{text}"))
}

/// The run that shows that a formula does not hold.
fn run(text: &str) -> Vec<String> {
    let Verdict::Violated(found) = verdict(text) else { panic!("{text} holds") };
    found[0].run.iter().map(|line| format!("{}: {}", line.who, line.what)).collect()
}

#[test]
fn formulas_about_the_past_hold_in_all_states_or_a_run_shows_where_not() {
    for text in [
        "[] (codel(g1) -> once codel(g0))",
        "[] (run(home) -> once run(go))",
        "[] !(codel(g0) && codel(g1))",
        "always (pending(go) -> !previous run(go) || historically true)",
        // From its stop on, the activity of before is in `stop` until it ends.
        "[] (codel(g2) -> run(go) since (run(go) && once codel(g0)))",
    ] {
        assert_eq!(verdict(text), Verdict::Holds, "{text}");
    }
    let expected =
        ["t: starts", "t: t0 yields ether", "t: tick", "client: requests go", "go: is accepted"];
    assert_eq!(run("[] !codel(g0)"), expected);
    // A client may ask for another one while one runs.
    assert!(matches!(verdict("[] !(run(go) && pending(go))"), Verdict::Violated(_)));
}

#[test]
fn what_a_formula_says_comes_in_every_fair_run_or_one_is_told_in_which_it_does_not() {
    let system = system(TEXT, Bounds { kill: false, ..Bounds::default() }, true);
    let verdict = |text: &str| {
        let formula = Formula::new(&system, text).unwrap();
        system.check_comes(&formula, &limits()).unwrap_or_else(|| panic!("{text}"))
    };
    let run = |text: &str| -> Vec<String> {
        let Verdict::Violated(found) = verdict(text) else { panic!("{text} holds") };
        found[0].run.iter().map(|line| format!("{}: {}", line.who, line.what)).collect()
    };
    for text in [
        "<> codel(t0)",
        "[] (codel(g0) -> <> !codel(g0))",
        // Its tick comes, and it pauses: then the next codel is called, or it is asked to stop.
        "[] (codel(g0) -> <> (codel(g1) || codel(g2) || !run(go)))",
        "[] (run(home) -> <> !run(home))",
        "[] (codel(g2) -> <> !codel(g2))",
    ] {
        assert_eq!(verdict(text), Verdict::Holds, "{text}");
    }
    // Clients need not ask.
    assert!(run("<> go").last().unwrap().starts_with("from then on: "));
    // A yield that is never taken.
    let told = run("[] (go -> <> !go)");
    let last = told.last().unwrap();
    assert!(last.contains("g1 yields pause::main") && !last.contains("g1 yields ether"), "{last}");
    assert!(told.iter().any(|line| line == "client: requests go"), "{told:?}");
}

#[test]
fn formulas_are_read_as_spin_reads_them() {
    let system = component();
    // `->` is weaker than `||`, which is weaker than `&&`; `!` is the strongest.
    for (text, same) in [
        (
            "[] (go -> home || go && !home)",
            "[] (run(go) -> (run(home) || (run(go) && (!run(home)))))",
        ),
        ("[] go -> home", "([] go) -> home"),
        ("go -> home -> go", "go -> (home -> go)"),
        ("always eventually go", "[] <> go"),
        ("go U home", "go until home"),
    ] {
        let term = |text: &str| Formula::new(&system, text).unwrap().term().clone();
        assert_eq!(term(text), term(same), "{text}");
    }
    let error = |text: &str| Formula::new(&system, text).unwrap_err().to_string();
    assert_eq!(error("[] (go"), "character 7: `)` is wanted");
    assert_eq!(error("[] run(nobody)"), "character 4: there is no service `nobody`");
    assert_eq!(
        error("[] walks(go)"),
        "character 4: `walks` is none of codel, run, pending and late"
    );
    assert_eq!(error("go go"), "character 4: an operator, or the end");
    assert_eq!(error("[] §"), "character 4: an operator or a name");
    assert_eq!(error(&"!".repeat(100)), "the formula is too long");
    assert_eq!(error(&"(".repeat(3_000)), "the formula is too long");
}

#[test]
fn chains_as_long_as_a_formula_may_be_are_read_and_left_to_a_tool() {
    let system = component();
    for operator in ["&&", "||", "<->"] {
        let text = format!("[] ({})", ["go"; 390].join(operator));
        let formula = Formula::new(&system, &text).unwrap();
        assert_eq!(system.check_past(&formula, &limits()), None, "{operator}");
        assert_eq!(system.check_comes(&formula, &limits()), None, "{operator}");
    }
    // These are in each other, one by one.
    let error = Formula::new(&system, &["go"; 390].join("->")).unwrap_err();
    assert_eq!(error.to_string(), "the formula is too long");
}

#[test]
fn what_takes_a_tool_or_times_is_told() {
    let system = component();
    let formula = |text: &str| Formula::new(&system, text).unwrap();
    assert_eq!(system.check_past(&formula("<> go"), &limits()), None);
    assert_eq!(system.check_comes(&formula("[] !go"), &limits()), None);
    // What comes after what comes is of no form that is checked here.
    assert_eq!(system.check_comes(&formula("<> (go && <> home)"), &limits()), None);
    assert_eq!(system.check_comes(&formula("[] (go -> once home U go)"), &limits()), None);
    let late = formula("[] !late(t)");
    assert_eq!(system.check_past(&late, &limits()), None);
    let few = Limits { states: 3, ..limits() };
    let holds = formula("[] true");
    assert!(matches!(system.check_past(&holds, &few), Some(Verdict::Undecided(_))));
}
