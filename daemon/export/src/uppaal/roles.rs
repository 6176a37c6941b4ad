//! Who takes the steps of the rules.

use genom_formal::System;

use super::role::{Role, Step};
use crate::tables::{Sizes, is_aborted, most_answers, small, wakes};

/// What the edges of all roles are made with.
struct Edges {
    timed: bool,
    contexts: usize,
    answers: usize,
}

pub(super) fn roles(system: &System, sizes: &Sizes, timed: bool) -> Vec<Role> {
    let edges = Edges { timed, contexts: sizes.contexts(), answers: most_answers(system) };
    let mut all = vec![
        edges.begin(system),
        edges.task(system),
        edges.tick(system),
        control(),
        edges.client(system),
        event(system, sizes),
    ];
    all.extend(stop(system));
    all.retain(Role::is_there);
    all
}

impl Edges {
    /// A step in which contexts begin nodes. The clocks of those that execute none are 0 before it, so
    /// that they are 0 when they begin.
    fn begins(&self, assign: &str) -> String {
        let own = |c: usize| format!("since[idle({c})] = 0, ");
        let resets = (0..self.contexts).filter(|_| self.timed).map(own);
        resets.chain([assign.to_owned()]).collect()
    }

    /// The end of what a context executes (R6, R11).
    fn returns(&self, context: &str, assign: &str) -> Option<Step> {
        let guard = format!("may_answer({context}, k)");
        let most = self.answers.checked_sub(1)?;
        let step = if self.timed {
            let assign = self.begins(&format!("since[{context}] = 0, {assign}"));
            Step::new(&format!("{guard} && since[{context}] >= LEAST[held[{context}]]"), &assign)
        } else {
            Step::new(&guard, assign)
        };
        Some(step.any(format!("k : int[0,{most}]")))
    }

    /// A context executes a node for so long at most.
    fn within(&self, context: &str) -> String {
        let limit = format!("held[{context}] == 0 || since[{context}] <= MOST[held[{context}]]");
        if self.timed { limit } else { String::new() }
    }

    /// The ticks before the first date are where delays put them.
    fn begin(&self, system: &System) -> Role {
        let periodic = (0..).zip(system.periods()).filter(|(_, period)| period.is_some());
        let clocks: Vec<String> = periodic
            .map(|(task, _): (usize, _)| format!("clk[{task}] = SINCE_TICK[{task}]"))
            .collect();
        let begin = Role::new("Beginning", "", Vec::new()).beginning(clocks.join(", "));
        let there = self.timed && !clocks.is_empty();
        begin.of(there.then(|| ("Beginning".to_owned(), String::new())))
    }

    /// Passes (R3 to R8), and what control collects of the task whatever else that does (R9).
    fn task(&self, system: &System) -> Role {
        let mut steps = vec![
            Step::new("may_hurry(id)", "hurry(id)"),
            Step::at_once("phase != STOPPED && may_begin(id)", &self.begins("begin(id)")),
            Step::at_once("phase != STOPPED && T[id].at == WAKE", "wake_others(id)"),
            Step::at_once(
                "phase != STOPPED && phase != STARTING && T[id].no > 0",
                "collect_one(id), examine()",
            ),
        ];
        let returns = "task_returns(id, answer_kind(id, k), answer_to(id, k))";
        steps.extend(self.returns("id", returns));
        let names = (0..small(system.periods().len()))
            .map(|task| (format!("Task_{}", system.task_name(task)), task.to_string()));
        Role::new("Task", "const int[0,TASKS - 1] id", steps).within(self.within("id")).of(names)
    }

    /// R2
    fn tick(&self, system: &System) -> Role {
        let step = if self.timed {
            Step::new("phase != STOPPED && clk[id] == PERIOD[id]", "clk[id] = 0, tick(id)")
        } else {
            Step::new("phase != STOPPED && may_tick(id)", "tick(id)")
        };
        let periodic = (0..).zip(system.periods()).filter(|(_, period)| period.is_some());
        let names = periodic
            .map(|(task, _)| (format!("Tick_{}", system.task_name(task)), task.to_string()));
        let limit = if self.timed { "clk[id] <= PERIOD[id]" } else { "" };
        Role::new("Tick", "const int[0,TASKS - 1] id", vec![step]).within(limit.into()).of(names)
    }

    /// The clients of a service, and the worker that serves a request (R10, R11).
    fn client(&self, system: &System) -> Role {
        let mut steps = vec![
            Step::new("may_request(id)", &self.begins("request(id)")),
            Step::at_once("phase != STOPPED && pc[id] >= WAKE_OK", "proceed(id)"),
        ];
        let returns = "worker_returns(id, answer_kind(TASK_COUNT + id, k))";
        steps.extend(self.returns("TASK_COUNT + id", returns));
        let own = (0..).zip(system.services()).filter(|(_, service)| service.builtin.is_none());
        let names =
            own.map(|(at, _)| (format!("Client_{}", system.service_name(at)), at.to_string()));
        Role::new("Client", "const int[0,SERVICES - 1] id", steps)
            .within(self.within("TASK_COUNT + id"))
            .of(names)
    }
}

/// R1, R9, R15
fn control() -> Role {
    let steps = vec![
        Step::at_once("starts()", "start_task()"),
        Step::at_once("advances()", "advance()"),
        Step::at_once("phase != STOPPED && phase != STARTING && several_ended()", "collect_all()"),
        Step::new("KILL == 1 && phase == RUNNING", "kill()"),
    ];
    Role::only("Control", steps)
}

/// R13
fn stop(system: &System) -> Option<Role> {
    if !is_aborted(system) {
        return None;
    }
    let mut steps = vec![
        Step::new("may_abort() && i < np", "abort_pending(i)").any("i : int[0,PENDING - 1]"),
        Step::new("may_abort() && may_stop(t, x)", "abort_run(t, x)")
            .any("t : int[0,TASKS - 1], x : int[0,RUNS - 2]"),
        // The request itself, once its effect is there.
        Step::at_once("phase != STOPPED && pc[ABORTS] >= WAKE_OK", "proceed(ABORTS)"),
    ];
    if wakes(system) {
        steps.push(Step::new("may_abort()", "abort_none()"));
    }
    Some(Role::only("Stop", steps))
}

/// R14
fn event(system: &System, sizes: &Sizes) -> Role {
    let tasks = 0..if system.bounds().fire { sizes.tasks } else { 0 };
    let pairs = tasks.flat_map(|task| (0..sizes.sinks).map(move |sink| (task, sink)));
    let names =
        pairs.map(|(task, sink)| (format!("Event_{task}_{sink}"), format!("{task}, {sink}")));
    let parameters = "const int[0,TASKS - 1] t, const int[0,HEARD - 1] k";
    Role::new("Event", parameters, vec![Step::new("may_fire(t, k)", "fire(t, k)")]).of(names)
}
