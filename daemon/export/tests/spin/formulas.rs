//! Random formulas of random components: whether they hold, by Spin and by ourselves.

use genom_export::export_claim;
use genom_formal::{Bounds, Formula, System, Verdict};

use super::compare::limits;
use super::random::Random;
use super::run::Checked;
use super::small;
use super::tally::Tally;

/// Kinds of formulas.
pub(crate) const NEVER: &str = "something never is";
pub(crate) const COMES: &str = "something comes";

/// Formulas about a component.
fn formulas(system: &System, random: &mut Random) -> Vec<String> {
    let plan = system.plan();
    let component = plan.component();
    let codels: Vec<&str> = component.codels.iter().map(|one| one.name.as_str()).collect();
    let activities: Vec<&str> = component
        .services
        .iter()
        .filter(|one| one.task.is_some() && !one.standard)
        .map(|one| one.name.as_str())
        .collect();
    let mut codel = || format!("codel({})", random.one(&codels));
    let (a, b, c, d) = (codel(), codel(), codel(), codel());
    let mut all = vec![
        format!("[] !({a} && {b})"),
        format!("[] (!{b} || {c} && {d})"),
        format!("[] ({a} -> <> !{a})"),
        format!("[] <> {c}"),
        format!("<> {d}"),
        format!("[] ({a} -> <> ({b} || {c}))"),
    ];
    if !activities.is_empty() {
        let (one, other) = (*random.one(&activities), *random.one(&activities));
        all.extend([
            format!("[] !(run({one}) && pending({other}))"),
            format!("[] !(pending({one}) && pending({other}))"),
            format!("[] (pending({one}) -> <> !pending({one}))"),
            format!("[] (run({one}) -> <> !run({one}))"),
            format!("[] (pending({one}) -> <> run({other}))"),
            format!("[] <> !run({one})"),
        ]);
    }
    all
}

/// Compares the verdicts on formulas of the component of this seed, if it has few states.
pub(crate) fn judge(seed: u64, most: usize) -> Option<Tally> {
    let system = small::random(seed);
    // Without shutdown there is more that must come.
    let kill = seed.is_multiple_of(4);
    let bounds = Bounds { kill, instances: 1, ..*system.bounds() };
    let system = System::new(system.plan(), bounds);
    let texts = formulas(&system, &mut Random(seed));
    let mut model: Option<String> = None;
    let mut ours = Vec::new();
    for (at, text) in texts.iter().enumerate() {
        let formula = Formula::new(&system, text).unwrap_or_else(|error| panic!("{text}: {error}"));
        let never = system.check_past(&formula, &limits(most));
        let is_never = never.is_some();
        let verdict = never.or_else(|| system.check_comes(&formula, &limits(most)));
        match verdict.unwrap_or_else(|| panic!("{text}")) {
            Verdict::Undecided(_) => return None,
            verdict => ours.push((is_never, verdict == Verdict::Holds)),
        }
        let claimed = export_claim(&system, &formula, None).unwrap();
        let claim = claimed.lines().last().unwrap();
        assert!(claim.starts_with("ltl user {"), "{claim}");
        let named = claim.replace("ltl user {", &format!("ltl user{at} {{"));
        model.get_or_insert_with(|| claimed.trim_end_matches(claim).to_owned()).push_str(&named);
        model.as_mut().unwrap().push('\n');
    }
    let spin = Checked::of(&model?, false);
    let mut tally = Tally::default();
    for (at, ((is_never, holds), text)) in ours.into_iter().zip(&texts).enumerate() {
        let kind = if is_never { NEVER } else { COMES };
        let spins = spin.user(&format!("user{at}")).map(|fails| !fails);
        tally.note(kind, text, Some(holds), spins);
    }
    Some(tally)
}
