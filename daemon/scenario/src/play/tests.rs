//! Plays scenarios on a daemon that is written down: replies by request, and a clock.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::future::Future;
use std::path::Path;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use expect_test::expect;
use genom_protocol::Reason;
use genom_protocol::routes::{Bytes, Route};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::*;
use crate::model::Suite;

#[derive(Default)]
struct Written {
    /// Replies by request; the last one of a request stays.
    replies: RefCell<BTreeMap<String, Vec<Value>>>,
    now: Cell<u64>,
    /// What was asked for, in order.
    asked: RefCell<Vec<String>>,
    /// Requests of this form are never answered.
    silent: Option<&'static str>,
}

impl Written {
    fn new(replies: &[(&str, &[Value])]) -> Self {
        let all = replies.iter().map(|(request, all)| ((*request).to_owned(), all.to_vec()));
        let written = Self { replies: RefCell::new(all.collect()), ..Self::default() };
        let mut replies = written.replies.borrow_mut();
        replies.entry("GET /components".to_owned()).or_insert_with(|| {
            vec![json!({"components": [
                {"name": "arm", "component": "arm", "state": "running", "backend": "local",
                 "library": "arm.so", "activities": 0}
            ]})]
        });
        replies.entry("GET /components/arm/tasks".to_owned()).or_insert_with(|| {
            let none = json!({"count": 0, "last_ns": 0, "mean_ns": 0, "p50_ns": 0, "p99_ns": 0,
                              "max_ns": 0});
            vec![json!({"tasks": [{"name": "main", "period_ns": 5_000_000, "real_time": false,
                                   "cycles": none, "lateness": none, "overruns": 0}],
                        "codels": [], "lost_changes": 0})]
        });
        drop(replies);
        written
    }

    async fn reply<R: DeserializeOwned>(&self, request: String, body: Value) -> Result<R, Trouble> {
        if self.silent.is_some_and(|silent| request.ends_with(silent)) {
            std::future::pending::<()>().await;
        }
        let told = if body.is_null() { request.clone() } else { format!("{request} {body}") };
        self.asked.borrow_mut().push(told);
        let reply = if request == "POST /clock" {
            self.now.set(self.now.get() + body["nanoseconds"].as_u64().unwrap());
            json!({"clock": "virtual", "now": self.now.get()})
        } else {
            let mut replies = self.replies.borrow_mut();
            let Some(all) = replies.get_mut(&request) else {
                return Err(Trouble::Refused(Reason::new("none", format!("no {request}"))));
            };
            if all.len() > 1 { all.remove(0) } else { all[0].clone() }
        };
        Ok(serde_json::from_value(reply).unwrap())
    }
}

impl Daemon for Written {
    async fn send<R: DeserializeOwned, Q, B: Serialize>(
        &self,
        route: Route<R, Q, B>,
        body: &B,
    ) -> Result<R, Trouble> {
        self.reply(format!("{route:?}"), serde_json::to_value(body).unwrap()).await
    }

    async fn ask<R: DeserializeOwned, Q>(&self, route: Route<R, Q>) -> Result<R, Trouble> {
        self.reply(format!("{route:?}"), Value::Null).await
    }

    async fn bytes<Q>(&self, _: Route<Bytes, Q>) -> Result<Vec<u8>, Trouble> {
        Ok(Vec::new())
    }

    fn kill(&self, _: u32) -> Result<(), Trouble> {
        Ok(())
    }

    async fn moment(&self) {}
}

fn scenario(steps: &str) -> Scenario {
    let text = format!("[[scenario]]\nname = \"a\"\nsteps = [\n{steps}\n]\n");
    Suite::read(Path::new("a.toml"), &text).unwrap().scenarios.remove(0)
}

/// Nothing of it waits but for what is never answered.
fn done<T>(of: impl Future<Output = T>) -> Option<T> {
    match pin!(of).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => Some(value),
        Poll::Pending => None,
    }
}

#[test]
fn the_first_step_that_does_not_hold_ends_the_scenario() {
    let daemon = Written::new(&[]);
    let steps = "{ step = \"3ms\" },\n{ fire = \"arm/stop\" },\n{ step = \"7ms\" },";
    let (outcome, played) = done(play(&scenario(steps), &daemon, &Progress::default())).unwrap();
    assert_eq!(played, Played { steps: 1, nanoseconds: 3_000_000 });
    let Outcome::Failed(unmet) = outcome else { panic!("{outcome:?}") };
    assert_eq!((unmet.line, unmet.step.as_str()), (5, "fire arm/stop"));
    assert_eq!(unmet.came, "refused: no POST /components/arm/events/stop");
}

#[test]
fn who_gives_a_scenario_up_learns_which_step_did_not_end() {
    let daemon = Written { silent: Some("/clock"), ..Written::new(&[]) };
    let (scenario, progress) = (scenario("{ step = \"3ms\" }"), Progress::default());
    assert!(done(play(&scenario, &daemon, &progress)).is_none());
    let (outcome, played) = progress.given_up(&scenario, "too long");
    assert_eq!(played.steps, 0);
    let unmet = outcome.unmet().unwrap();
    assert_eq!((unmet.line, unmet.step.as_str(), unmet.came.as_str()), (4, "step 3ms", "too long"));
}

#[test]
fn samples_of_a_fault_are_passed_on_where_periods_end() {
    let port = |samples: u64, value: f64| {
        json!({"address": "eye/width", "name": "width", "direction": "out", "multiple": false,
               "type": "double", "backend": "local", "value": value,
               "traffic": {"samples": samples, "dropped": 0, "failed": 0, "age_ns": null}})
    };
    let connections = json!({"connections": [{"kind": "port", "in": "arm/thing",
                                              "out": "eye/width", "backend": "local"}]});
    let daemon = Written::new(&[
        ("GET /connections", &[connections]),
        // When the fault begins, what is due then, and at the end of each slice.
        ("GET /components/eye/ports/width", &[3, 3, 4, 5, 5].map(|n| port(n, n as f64))),
        ("GET /components/arm/ports/thing", &[port(0, 0.5)]),
        ("DELETE /connections/arm/thing", &[json!({"disconnected": "arm/thing"})]),
        ("POST /components/arm/ports/thing", &[json!({"address": "arm/thing", "value": 0})]),
        ("POST /connections", &[json!({"kind": "port", "in": "arm/thing", "out": "eye/width"})]),
    ]);
    let steps = "{ step = \"3ms\" },{ fault = \"arm/thing\", corrupt = 9, every = 2 },\
                 { step = \"10ms\" },{ repair = \"arm/thing\" },";
    let (outcome, _) = done(play(&scenario(steps), &daemon, &Progress::default())).unwrap();
    assert_eq!(outcome, Outcome::Passed);
    let asked = daemon.asked.take();
    let shown: Vec<&str> =
        asked.iter().map(String::as_str).filter(|it| !it.starts_with("GET")).collect();
    expect![[r#"
        POST /clock {"nanoseconds":3000000}
        DELETE /connections/arm/thing
        POST /components/arm/ports/thing 0.5
        POST /clock {"nanoseconds":0}
        POST /clock {"nanoseconds":2000000}
        POST /components/arm/ports/thing 4.0
        POST /clock {"nanoseconds":5000000}
        POST /components/arm/ports/thing 9
        POST /clock {"nanoseconds":3000000}
        POST /connections {"in":"arm/thing","out":"eye/width"}"#]]
    .assert_eq(&shown.join("\n"));
}
