//! Actions: `demo/action/Goto` of the demo, which is run, and `demo/action/Count` of a test, which is
//! served. What their parts are made of is written here; names and hashes of their types are those
//! that the other end asks for or offers, and for the parts that are ROS's own, those of Jazzy.

use std::collections::HashMap;
use std::future::Future;

use hiroz::action::client::{GoalHandle, ZActionClient};
use hiroz::action::messages::CancelGoalServiceResponse;
use hiroz::action::server::{ExecutingGoal, ZActionServer};
use hiroz::action::{GoalId, GoalStatus, ZAction};
use hiroz::entity::EndpointKind;
use hiroz::msg::{SerdeCdrSerdes, ZMessage};
use hiroz::node::ZNode;
use hiroz::{Builder as _, TypeHash, TypeInfo};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use tokio::runtime::Runtime;
use tokio::sync::{mpsc, watch};
use tokio::time::timeout;

use super::graph::type_of;
use super::{Outcome, PATIENCE, Wrong, text, transient_local};

/// A part of an action, as hiroz writes and reads it.
macro_rules! part {
    ($name:ident { $($member:ident: $ty:ty),* }) => {
        #[derive(Clone, Debug, Deserialize, Serialize)]
        struct $name {
            $($member: $ty),*
        }

        impl ZMessage for $name {
            type Serdes = SerdeCdrSerdes<Self>;
        }
    };
}

part!(GotoGoal { goal: f64 });
part!(GotoResult { genom_exception: String, genom_detail: String });
part!(CountGoal { most: i32 });
part!(CountResult { genom_exception: String, genom_detail: String, numbers: Vec<i32> });
part!(State { genom_state: String });

/// An action of these parts.
macro_rules! action {
    ($name:ident, $goal:ty, $result:ty) => {
        struct $name;

        impl ZAction for $name {
            type Goal = $goal;
            type Result = $result;
            type Feedback = State;

            fn name() -> &'static str {
                stringify!($name)
            }

            fn cancel_goal_type_info() -> TypeInfo {
                own(
                    "action_msgs::srv::dds_::CancelGoal_",
                    "RIHS01_573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a",
                )
            }

            fn status_type_info() -> TypeInfo {
                own(
                    "action_msgs::msg::dds_::GoalStatusArray_",
                    "RIHS01_6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e",
                )
            }
        }
    };
}

action!(Goto, GotoGoal, GotoResult);
action!(Count, CountGoal, CountResult);

/// A type of ROS itself, with the hash that Jazzy publishes.
fn own(name: &str, hash: &str) -> TypeInfo {
    TypeInfo::new(name, TypeHash::from_rihs_string(hash).unwrap_or_else(TypeHash::zero))
}

/// A goal that was sent; its handle is given up for the result.
struct Sent {
    id: GoalId,
    handle: GoalHandle<Goto>,
    feedback: mpsc::UnboundedReceiver<State>,
    status: watch::Receiver<GoalStatus>,
}

#[derive(Default)]
pub(crate) struct Actions {
    /// The last goal of each.
    sent: HashMap<String, Sent>,
    executing: HashMap<String, ExecutingGoal<Count>>,
    clients: HashMap<String, ZActionClient<Goto>>,
    servers: HashMap<String, ZActionServer<Count>>,
    /// Of goals that have ended.
    last: HashMap<String, GoalId>,
}

/// Types of the goal, the result and the feedback, as the other end has them.
fn types(node: &ZNode, action: &str, services: EndpointKind) -> Result<[TypeInfo; 3], Wrong> {
    let topics = match services {
        EndpointKind::Service => EndpointKind::Publisher,
        _ => EndpointKind::Subscription,
    };
    let of = |part: &str, kind| type_of(node, kind, &format!("{action}/_action/{part}"));
    Ok([of("send_goal", services)?, of("get_result", services)?, of("feedback", topics)?])
}

/// Waits no longer than a failing test does.
fn soon<T>(runtime: &Runtime, work: impl Future<Output = T>) -> Result<T, Wrong> {
    runtime.block_on(async { timeout(PATIENCE, work).await }).map_err(Wrong::from)
}

impl Actions {
    pub(crate) fn command(
        &mut self,
        runtime: &Runtime,
        node: &ZNode,
        verb: &str,
        given: &[Value],
    ) -> Outcome {
        // Servers start tasks.
        let _inside = runtime.enter();
        let name = text(given, 0)?;
        match verb {
            "action" => {
                let [goal, result, feedback] = types(node, name, EndpointKind::Service)?;
                let client = node
                    .create_action_client::<Goto>(name)
                    .with_goal_type_info(goal)
                    .with_result_type_info(result)
                    .with_feedback_type_info(feedback)
                    .with_status_topic_qos(transient_local())
                    .build()?;
                let there = runtime.block_on(client.wait_for_server(PATIENCE));
                self.clients.insert(name.to_owned(), client);
                Ok(json!(there))
            }
            "serve action" => {
                let [goal, result, feedback] = types(node, name, EndpointKind::Client)?;
                let server = node
                    .create_action_server::<Count>(name)
                    .with_goal_type_info(goal)
                    .with_result_type_info(result)
                    .with_feedback_type_info(feedback)
                    .with_status_topic_qos(transient_local())
                    .build()?;
                self.servers.insert(name.to_owned(), server);
                Ok(json!("serves"))
            }
            "goal" | "feedback" | "status" | "cancel" | "result" => {
                self.run(runtime, verb, name, given)
            }
            _ => self.serve(runtime, verb, name, given),
        }
    }

    fn run(&mut self, runtime: &Runtime, verb: &str, name: &str, given: &[Value]) -> Outcome {
        let client = self.clients.get(name).ok_or("no such action")?;
        let sent = self.sent.get_mut(name);
        match (verb, sent) {
            ("goal", _) => {
                let goal = given.get(1).and_then(Value::as_f64).ok_or("no goal")?;
                let mut handle = soon(runtime, client.send_goal(GotoGoal { goal }))??;
                let id = handle.id();
                let feedback = handle.feedback().ok_or("no feedback")?;
                let status = handle.status_watch().ok_or("no status")?;
                self.last.insert(name.to_owned(), id);
                self.sent.insert(name.to_owned(), Sent { id, handle, feedback, status });
                Ok(json!("accepted"))
            }
            ("feedback", Some(sent)) => {
                let state = soon(runtime, sent.feedback.recv())?.ok_or("no more feedback")?;
                Ok(json!(state.genom_state))
            }
            ("status", Some(sent)) => {
                let wanted = text(given, 1)?;
                let is = |now: &GoalStatus| format!("{now:?}") == wanted;
                let now = *soon(runtime, sent.status.wait_for(is))??;
                Ok(json!(format!("{now:?}")))
            }
            ("cancel", sent) => {
                let id = sent.map(|sent| sent.id).or(self.last.get(name).copied());
                let id = id.ok_or("no goal was sent")?;
                let reply = soon(runtime, client.cancel_goal(id))??;
                let goals = reply.goals_canceling.iter();
                let same = goals.map(|goal| goal.goal_id == id).collect::<Vec<_>>();
                Ok(json!({"code": reply.return_code, "same": same}))
            }
            ("result", Some(_)) => {
                let sent = self.sent.remove(name).ok_or("no goal was sent")?;
                let result = runtime.block_on(sent.handle.result_with_timeout(PATIENCE))?;
                Ok(json!([result.genom_exception, result.genom_detail]))
            }
            _ => Err(format!("no goal was sent for {verb}").into()),
        }
    }

    fn serve(&mut self, runtime: &Runtime, verb: &str, name: &str, given: &[Value]) -> Outcome {
        let server = self.servers.get(name).ok_or("no such action")?;
        let executing = self.executing.remove(name);
        match (verb, executing) {
            ("asked", _) => {
                let goal = soon(runtime, server.recv_goal())??.accept().execute();
                let most = goal.goal().most;
                self.executing.insert(name.to_owned(), goal);
                Ok(json!(most))
            }
            ("feed", Some(goal)) => {
                let there = runtime.block_on(goal.wait_for_feedback_subscriber(1, PATIENCE));
                goal.publish_feedback(State { genom_state: text(given, 1)?.to_owned() })?;
                self.executing.insert(name.to_owned(), goal);
                Ok(json!(there))
            }
            // Answered here: what hiroz answers by itself is 1, which means that it is refused, or it
            // hears of it only when somebody has the result.
            ("to cancel", Some(goal)) => {
                let (request, query) = soon(runtime, server.recv_cancel_request_low())??;
                let id = request.goal_info.goal_id;
                let known = server.request_cancel(id) && id == goal.info().goal_id;
                let goals_canceling = vec![request.goal_info];
                let response = CancelGoalServiceResponse { return_code: 0, goals_canceling };
                server.send_cancel_response_low(&query, &response)?;
                let asked = goal.is_cancel_requested();
                self.executing.insert(name.to_owned(), goal);
                Ok(json!(known && asked))
            }
            ("end", Some(goal)) => {
                let result: CountResult = serde_json::from_value(json!({
                    "genom_exception": given.get(2), "genom_detail": given.get(3),
                    "numbers": given.get(4),
                }))?;
                match text(given, 1)? {
                    "succeed" => goal.succeed(result)?,
                    "abort" => goal.abort(result)?,
                    _ => goal.canceled(result)?,
                }
                Ok(json!("ended"))
            }
            _ => Err(format!("no verb {verb}, or there is no goal").into()),
        }
    }
}
