//! What the runtime says that random runs break is never proved to be unbreakable.
//!
//! On a stepped clock codels take no time, and the model is given the same. Limits are random, and seldom
//! next to what can happen: that is `edges.rs`.

use std::fmt::Write as _;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_description::model::{CodelIx, CodelKind, Ix as _, Owner, ServiceKind};
use genom_formal::{Bounds, Duration as Takes, Fires, Limits, System, Times};
use genom_runtime::{
    Beats, Change, Clock, Happening, Options, Part, Plan, Program, Rule, Supervised, Watcher,
};

use super::play::play_with;
use super::random::Random;

/// Keeps which rules were broken, and when, until a permanent activity fails.
#[derive(Default)]
pub(super) struct Broken(Mutex<Kept>);

#[derive(Clone, Default)]
struct Kept {
    all: Vec<(usize, u64)>,
    failed: bool,
}

impl Broken {
    /// Hears of these rules in a run with these options; returns the clock of the run.
    pub(super) fn hear(self: &Arc<Self>, rules: &[Rule], options: &mut Options) -> Clock {
        let rules = rules.iter().cloned();
        let rules = rules.map(|rule| Supervised { rule, interrupts: false });
        options.rules = rules.collect();
        options.watcher = Some(Arc::clone(self) as Arc<dyn Watcher>);
        options.clock.clone()
    }

    /// Ranks of those that were broken in a run that ended at this date. The shutdown comes then, and
    /// most rules are not looked at any more.
    pub(super) fn counted(&self, rules: &[Rule], end: u64) -> Vec<usize> {
        let all = self.0.lock().unwrap().all.clone();
        let counts =
            |(rule, date): &(usize, u64)| *date < end || matches!(rules[*rule], Rule::Stop { .. });
        all.into_iter().filter(counts).map(|(rule, _)| rule).collect()
    }
}

impl Watcher for Broken {
    fn changed(&self, change: &Change) {
        let mut broken = self.0.lock().unwrap();
        match change {
            Change::Violated(violation) if !broken.failed => {
                broken.all.push((violation.rule, violation.date));
            }
            // A supervisor would end the instance.
            Change::Failed { .. } => broken.failed = true,
            _ => {}
        }
    }
}

/// A component whose states are few.
pub(super) fn small(random: &mut Random) -> String {
    let mut text = String::from("component demo {\n");
    let tasks = 1 + random.below(2);
    for task in 0..tasks {
        write!(text, " task t{task} {{ period {} ms;", random.one(&[5, 10])).unwrap();
        if random.percent(40) {
            write!(text, " codel<start> t{task}_start() yield pause::start;").unwrap();
        }
        text.push_str(" };\n");
    }
    for at in 0..1 + random.below(2) {
        let task = random.below(tasks);
        write!(text, " activity a{at}() {{ task t{task};").unwrap();
        let yields =
            random.one(&["main", "pause::main", "pause::main, ether", "pause::start, main"]);
        write!(text, " codel<start> a{at}_start() yield {yields};").unwrap();
        let yields = random.one(&["ether", "pause::main, ether", "pause::start"]);
        write!(text, " codel<main> a{at}_main() yield {yields};").unwrap();
        if random.percent(70) {
            let yields = random.one(&["ether", "ether, pause::stop"]);
            write!(text, " codel<stop> a{at}_stop() yield {yields};").unwrap();
        }
        let also: &&str = random.one(&["", " interrupts a0;"]);
        text.push_str(also);
        text.push_str(" };\n");
    }
    text + "};\n"
}

/// Rules with random limits, near to the periods of random components.
pub(super) fn rules(plan: &Plan, random: &mut Random) -> Vec<Rule> {
    let model = plan.component();
    let mut ms = |below: usize| Duration::from_millis(random.below(below).try_into().unwrap());
    let mut all = Vec::new();
    for (service, one) in model.services.pairs().filter(|(_, one)| !one.standard) {
        if one.kind == ServiceKind::Activity {
            let longest = Duration::from_millis(1) + ms(40);
            all.push(Rule::Activity { service, longest });
            all.push(Rule::Stop { service, longest: Duration::from_millis(1) + ms(6) });
        }
    }
    for (ix, codel) in model.codels.pairs() {
        let during = match codel.owner {
            _ if !matches!(codel.kind, CodelKind::Fsm { .. }) => continue,
            Owner::Service(service) => Some(service),
            Owner::Task(_) => None,
        };
        let least = ms(12);
        let longest = least + Duration::from_millis(1) + ms(12);
        all.push(Rule::Beat { of: Beats::Codels(vec![ix]), least, longest, during });
    }
    let calls: Vec<Happening> = model
        .codels
        .pairs()
        .filter(|(_, codel)| matches!(codel.kind, CodelKind::Fsm { .. }))
        .map(|(ix, _)| Happening::Call(ix))
        .collect();
    all.extend((0..4).map(|_| Rule::Formula(between(&calls, random))));
    all.truncate(genom_runtime::MOST_RULES);
    all
}

/// `a -> once[x, y] b`, or `a -> not once[x, y] b`, with bounds of which neither side is open.
fn between(calls: &[Happening], random: &mut Random) -> Program {
    const MS: u64 = 1_000_000;
    let (a, b) = (*random.one(calls), *random.one(calls));
    let least = MS * u64::try_from(1 + random.below(20)).unwrap();
    let most = least + MS * u64::try_from(1 + random.below(15)).unwrap();
    let parts = vec![
        Part::Happens(vec![a]),
        Part::Happens(vec![b]),
        Part::Once(genom_runtime::Bounds { least, most }, 1),
        Part::Not(2),
        Part::Implies(0, if random.percent(50) { 2 } else { 3 }),
    ];
    Program::new(parts.into_iter().map(|part| (part, String::new())).collect()).unwrap()
}

/// The system of a run, with as many requests as may wait, and codels that take no time.
pub(super) fn system(plan: &Arc<Plan>, slots: usize) -> (System, Times) {
    let bounds = Bounds { slots, instances: slots, ..Bounds::default() };
    let model = plan.component();
    let mut times = Times::declared(model);
    times.bound_others(0);
    for at in 0..model.codels.len() {
        times.set_one(CodelIx::new(at), Takes { least: 0, most: Some(0) });
    }
    (System::new(plan, bounds), times)
}

#[test]
fn what_the_runtime_says_is_broken_is_not_proved_to_be_unbreakable() {
    let limits = Limits { states: 4_000, time: Duration::MAX, ..Limits::default() };
    // By kind: broken there and found here, proved here, and neither.
    let (mut found, mut proved, mut open) = ([0; 4], [0; 4], 0);
    for seed in 0..120 {
        let (mut all, broken) = (Vec::new(), Arc::new(Broken::default()));
        let mut clock = None;
        let played = play_with(seed, small, |plan, options| {
            all = rules(plan, &mut Random(seed));
            clock = Some(broken.hear(&all, options));
        });
        if played.slots > 2 {
            continue;
        }
        let (system, times) = system(&played.plan, played.slots);
        let broken = broken.counted(&all, clock.unwrap().now());
        for (at, rule) in all.iter().enumerate() {
            let kind = match rule {
                Rule::Activity { .. } => 0,
                Rule::Stop { .. } => 1,
                Rule::Formula(_) => 3,
                _ => 2,
            };
            match system.fires(rule, Ok(&times), &limits) {
                Fires::Never => {
                    proved[kind] += 1;
                    assert!(!broken.contains(&at), "seed {seed}: {rule:?}\n{}", played.text);
                }
                Fires::Can { .. } | Fires::Always { .. } => {
                    found[kind] += usize::from(broken.contains(&at));
                }
                Fires::Undecided(_) => open += 1,
            }
        }
    }
    assert!(found.iter().chain(&proved).all(|count| *count >= 3), "{found:?} {proved:?} {open}");
}
