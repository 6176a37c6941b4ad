//! The greatest limit of a rule that can be broken, as the model has it, and the one a step of the clock
//! above, in the runtime: random limits are seldom so near to what can happen that a bound of the model
//! that is wrong by one step would show.

use std::sync::Arc;
use std::time::Duration;

use genom_description::model::{ServiceIx, ServiceKind};
use genom_formal::{Fires, Limits, System, Times};
use genom_runtime::{Plan, Rule};

use super::play::{plan, play_with};
use super::random::Random;
use super::runtime::{Broken, small, system};

const RUNS: u64 = 120;

/// Greater than any limit that is looked for, in steps of the clock.
const MOST: u64 = 64;

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

/// Rules about activities, in pairs: one with the greatest limit that can be broken, as the model says,
/// and one with the next.
fn edges(plan: &Arc<Plan>, slots: usize) -> Vec<Rule> {
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
            if let Some(most) = greatest(&system, &times, |ms| rule(service, ms)) {
                all.extend([rule(service, most), rule(service, most + 1)]);
            }
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
            clock = Some(broken.hear(&all, options));
        });
        let Some(clock) = clock else { continue };
        let broken = broken.counted(&all, clock.now());
        for can in (0..all.len()).step_by(2) {
            let cannot = can + 1;
            assert!(!broken.contains(&cannot), "seed {seed}: {:?}\n{}", all[cannot], played.text);
            looked += 1;
            reached += usize::from(broken.contains(&can));
        }
    }
    // What can happen does not happen in each random run.
    assert!(reached >= 3 && looked >= 30, "{reached} of {looked}");
}
