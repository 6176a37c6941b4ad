//! Scenarios as text: see `scenarios/README.md`.

use std::fmt::Write as _;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_description::model::Owner;
use genom_runtime::{
    Clock, ConnectionError, Execution, Frozen, FrozenActivity, Instance, Options, Outcome,
    Progress, Reply, Resume, Resumed, Supervision, VirtualClock, input_record,
};
use serde_json::Value;

use super::scripted::{Answer, Script, Scripted, Shared};

/// A supervisor that records what it is asked to do.
struct Supervisor(Shared);

impl Supervision for Supervisor {
    fn connect_port(&self, local: &str, remote: &str) -> Result<(), ConnectionError> {
        self.note(format!("supervisor: connect_port {local} {remote}"));
        if local == "none" {
            return Err(ConnectionError::NoSuchInport(local.into()));
        }
        Ok(())
    }

    fn connect_service(&self, local: &str, remote: &str) -> Result<(), ConnectionError> {
        self.note(format!("supervisor: connect_service {local} {remote}"));
        Err(ConnectionError::NoSuchService(remote.into()))
    }

    fn kill(&self) {
        self.note("supervisor: kill".into());
    }
}

impl Supervisor {
    fn note(&self, line: String) {
        self.0.lock().unwrap().trace.push(line);
    }
}

struct Play {
    clock: Arc<VirtualClock>,
    script: Shared,
    body: Arc<Scripted>,
    instance: Option<Instance>,
    execution: Execution,
    limit: usize,
    requests: u8,
    frozen: Option<Frozen>,
}

/// Runs a scenario, and returns its text with the actual results.
pub(crate) fn replay(text: &str, execution: &Execution) -> String {
    let (gen_text, rest) = text.split_once("\n---\n").expect("a line --- after the component");
    let (answers, steps) = rest.split_once("---\n").expect("a line --- after the codels");
    let clock = Arc::new(VirtualClock::new());
    let script = Shared::new(Mutex::new(Script::default()));
    for line in answers.lines() {
        set_answers(&script, line);
    }
    let gen_text: String = gen_text
        .lines()
        .map(|line| if line.starts_with('#') { "\n".into() } else { format!("{line}\n") })
        .collect();
    let plan = super::plan(&gen_text);
    let body = Arc::new(Scripted { plan, script: Arc::clone(&script), clock: Arc::clone(&clock) });
    let mut play = Play {
        clock,
        script,
        body,
        instance: None,
        execution: execution.clone(),
        limit: 16,
        requests: 0,
        frozen: None,
    };
    let mut out = text[..text.len() - steps.len()].to_owned();
    for line in steps.lines() {
        if let Some(command) = line.strip_prefix("> ") {
            writeln!(out, "{line}").unwrap();
            play.command(command);
            for line in std::mem::take(&mut play.script.lock().unwrap().trace) {
                writeln!(out, "{line}").unwrap();
            }
        } else if line.starts_with('#') || line.is_empty() {
            writeln!(out, "{line}").unwrap();
        }
    }
    out
}

/// `servo: pause::main, OUT_OF_RANGE {"value": 3}, ether`
fn set_answers(script: &Shared, line: &str) {
    if line.trim().is_empty() || line.starts_with('#') {
        return;
    }
    let (codel, answers) = line.split_once(": ").expect("`codel: event, event`");
    let answer = |text: &str| {
        let (event, detail) = text.trim().split_once(' ').unwrap_or((text.trim(), "null"));
        let detail: Value = serde_json::from_str(detail).expect("a detail in JSON");
        Answer { event: event.into(), detail: Some(detail).filter(|d| !d.is_null()) }
    };
    let answers = answers.split(", ").map(answer).collect();
    script.lock().unwrap().answers.insert(codel.trim().into(), answers);
}

impl Play {
    fn note(&self, line: String) {
        self.script.lock().unwrap().trace.push(line);
    }

    fn command(&mut self, command: &str) {
        let (verb, rest) = command.split_once(' ').unwrap_or((command, ""));
        match verb {
            "limit" => self.limit = rest.parse().unwrap(),
            "start" => self.start(None),
            "step" => self.clock.step(duration(rest)),
            "codel" => set_answers(&self.script, rest),
            "request" => self.request(rest),
            "abort" => match self.instance().abort(rest.parse().unwrap()) {
                Ok(()) => {}
                Err(error) => self.note(error.to_string()),
            },
            "fire" => {
                let sinks = &self.body.plan.component().sinks;
                let sink = sinks.iter().position(|sink| sink.name == rest).unwrap();
                self.instance().fire(sink).unwrap();
            }
            "activities" => self.activities(),
            "freeze" => self.freeze(),
            "thaw" => self.thaw(rest == "held"),
            "go-on" => self.instance().go_on(),
            "shutdown" => match self.instance().shutdown(Duration::from_secs(60)) {
                Ok(()) => self.note("stopped".into()),
                Err(error) => self.note(error.to_string()),
            },
            _ => panic!("unknown command `{command}`"),
        }
    }

    fn instance(&self) -> &Instance {
        self.instance.as_ref().expect("`> start` comes first")
    }

    fn freeze(&mut self) {
        let frozen = self.instance().freeze(Duration::ZERO, &mut || {}).unwrap();
        let model = self.body.plan.component();
        for a in &frozen.activities {
            let owner = match a.owner {
                Owner::Task(task) => format!("permanent of {}", model.tasks[task].name),
                Owner::Service(service) => model.services[service].name.clone(),
            };
            let places = a.tokens.iter();
            let places =
                places.map(|token| format!("{} {:?}", model.states[token.state], token.waits));
            let mut line = format!("{} {owner}: {:?}", a.id, a.phase);
            if a.pending {
                line.push_str(" pending");
            }
            if let Some(by) = &a.stopped_by {
                write!(line, " stopped by {by}").unwrap();
            }
            write!(line, " [{}]", places.collect::<Vec<_>>().join(", ")).unwrap();
            self.note(line);
        }
        let executed = frozen.executed.iter().map(|&service| model.services[service].name.as_str());
        self.note(format!("executed [{}]", executed.collect::<Vec<_>>().join(" ")));
        self.frozen = Some(frozen);
    }

    /// Another instance in the place of this one, with what was frozen last.
    fn thaw(&mut self, hold: bool) {
        self.instance = None;
        self.script.lock().unwrap().trace.clear();
        let Frozen { executed, activities, .. } = self.frozen.take().expect("`> freeze` before");
        let script = &self.script;
        let resumed = |activity: FrozenActivity| {
            let (id, script) = (activity.id, Arc::clone(script));
            let reply: Reply = Box::new(move |progress| {
                let line = match progress {
                    Progress::Accepted { activity } if activity == id => format!("{id} goes on"),
                    Progress::Accepted { activity } => format!("{id} goes on as {activity}"),
                    Progress::Ended(Outcome::Success(output)) => {
                        format!("{id} done {}", output.to_json())
                    }
                    Progress::Ended(Outcome::Exception(exception)) => {
                        format!("{id} failed {exception}")
                    }
                };
                script.lock().unwrap().trace.push(line);
            });
            Resumed { activity, reply: Some(reply), goes_on: false }
        };
        let activities = activities.into_iter().map(resumed).collect();
        self.start(Some(Resume { ids: None, ports: Vec::new(), executed, activities, hold }));
        let unresumed = self.instance().unresumed();
        unresumed.into_iter().for_each(|what| self.note(format!("not resumed: {what}")));
    }

    fn start(&mut self, resume: Option<Resume>) {
        let supervision = Arc::new(Supervisor(Arc::clone(&self.script)));
        let mut options = Options::new(self.body.plan.component().name.clone(), supervision);
        options.clock = Clock::Virtual(Arc::clone(&self.clock));
        options.activity_limit = self.limit;
        options.execution = self.execution.clone();
        options.resume = resume;
        let body = Arc::clone(&self.body);
        match Instance::start(Arc::clone(&self.body.plan), body, options) {
            Ok(instance) => self.instance = Some(instance),
            Err(error) => self.note(format!("does not start: {error}")),
        }
    }

    /// `goto {"goal": 1}`: the first request is A, the next one B.
    fn request(&mut self, request: &str) {
        let (service, input) = request.split_once(' ').unwrap_or((request, "{}"));
        let plan = &self.body.plan;
        let rank = plan.service(service).unwrap_or_else(|| panic!("no service {service}"));
        let mut record = input_record(plan, rank).unwrap().unwrap();
        record.merge_json(&serde_json::from_str(input).unwrap()).unwrap();
        let letter = char::from(b'A' + self.requests);
        self.requests += 1;
        let script = Arc::clone(&self.script);
        let reply = Box::new(move |progress| {
            let line = match progress {
                Progress::Accepted { activity } => format!("{letter} accepted as {activity}"),
                Progress::Ended(Outcome::Success(output)) => {
                    format!("{letter} done {}", output.to_json())
                }
                Progress::Ended(Outcome::Exception(exception)) => {
                    format!("{letter} failed {exception}")
                }
            };
            script.lock().unwrap().trace.push(line);
        });
        self.instance().request(rank, record, reply);
    }

    fn activities(&self) {
        for a in self.instance().activities() {
            let name = a.service.as_deref().unwrap_or("permanent");
            let mut line = format!("{} {name} of {}: {:?} in {}", a.id, a.task, a.phase, a.state);
            if a.paused {
                line.push_str(", paused");
            }
            if let Some(by) = a.stopped_by {
                write!(line, ", stopped by {by}").unwrap();
            }
            self.note(line);
        }
    }
}

fn duration(text: &str) -> Duration {
    if text == "0" {
        return Duration::ZERO;
    }
    let (number, unit) = text.split_at(text.find(|c: char| !c.is_ascii_digit()).unwrap());
    let number: u64 = number.parse().unwrap();
    match unit {
        "us" => Duration::from_micros(number),
        "ms" => Duration::from_millis(number),
        "s" => Duration::from_secs(number),
        _ => panic!("unknown unit `{unit}`"),
    }
}
