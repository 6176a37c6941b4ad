//! The greatest limit of a rule that can be broken, as the model has it, and the one a step of the clock
//! above, in the runtime: random limits are seldom so near to what can happen that a bound of the model
//! that is wrong by one step would show.

use std::sync::Arc;
use std::time::Duration;

use genom_description::model::{ServiceIx, ServiceKind};
use genom_formal::{Fires, Limits, System, Times};
use genom_runtime::{Plan, Rule, Supervised, Watcher};

use super::play::{plan, play_with};
use super::random::Random;
use super::runtime::{Broken, small, system};

const RUNS: u64 = 120;

/// Greater than any limit that is looked for, in steps of the clock.
const MOST: u64 = 64;

/// A rule at the edge of what can happen.
struct Edge {
    rule: Rule,
    /// Whether it can be broken, as the model says.
    can: bool,
}

/// The greatest limit in steps that can be broken, if the next one cannot; of a rule by its limit.
fn greatest(system: &System, times: &Times, rule: impl Fn(u64) -> Rule) -> Option<u64> {
    let limits = Limits { states: 4_000, time: Duration::MAX, ..Limits::default() };
    let fires = |limit: u64| match system.fires(&rule(limit), Ok(times), &limits) {
        Fires::Never => Some(false),
        Fires::Can { .. } | Fires::Always { .. } => Some(true),
        Fires::Undecided(_) => None,
    };
    if fires(MOST)? {
        return None;
    }
    let (mut broken, mut kept) = (0, MOST);
    while kept - broken > 1 {
        let middle = u64::midpoint(broken, kept);
        if fires(middle)? { broken = middle } else { kept = middle }
    }
    (broken > 0).then_some(broken)
}

/// Rules about activities, two of each kind.
fn edges(plan: &Arc<Plan>, slots: usize) -> Vec<Edge> {
    let (system, times) = system(plan, slots);
    let mut all = Vec::new();
    let services = plan.component().services.pairs();
    for (service, _) in
        services.filter(|(_, one)| !one.standard && one.kind == ServiceKind::Activity)
    {
        let of: [fn(ServiceIx, u64) -> Rule; 2] = [
            |service, ms| Rule::Activity { service, longest: Duration::from_millis(ms) },
            |service, ms| Rule::Stop { service, longest: Duration::from_millis(ms) },
        ];
        for rule in of {
            let Some(most) = greatest(&system, &times, |ms| rule(service, ms)) else { continue };
            all.push(Edge { rule: rule(service, most), can: true });
            all.push(Edge { rule: rule(service, most + 1), can: false });
        }
    }
    all
}

#[test]
fn activities_take_as_long_in_the_runtime_as_the_model_says_and_never_a_step_longer() {
    let (mut reached, mut looked) = (0, 0);
    for seed in 0..RUNS {
        let plan = plan(&small(&mut Random(seed)));
        let (mut all, broken) = (Vec::new(), Arc::new(Broken::default()));
        let mut clock = None;
        let played = play_with(seed, small, |_, options| {
            if options.activity_limit > 2 {
                return;
            }
            all = edges(&plan, options.activity_limit);
            let rules = all.iter().map(|edge| edge.rule.clone());
            let rules = rules.map(|rule| Supervised { rule, interrupts: false });
            options.rules = rules.collect();
            clock = Some(options.clock.clone());
            options.watcher = Some(Arc::clone(&broken) as Arc<dyn Watcher>);
        });
        let Some(clock) = clock else { continue };
        // The shutdown comes at the last date, and most rules are not looked at then.
        let (end, broken) = (clock.now(), broken.all());
        for (at, Edge { rule, can }) in all.iter().enumerate() {
            let counts = |date: u64| date < end || matches!(rule, Rule::Stop { .. });
            let broken = broken.iter().any(|(rule, date)| *rule == at && counts(*date));
            assert!(*can || !broken, "seed {seed}: {rule:?}\n{}", played.text);
            looked += usize::from(!can);
            reached += usize::from(*can && broken);
        }
    }
    // What can happen does not happen in each random run.
    assert!(reached >= 3 && looked >= 30, "{reached} of {looked}");
}
