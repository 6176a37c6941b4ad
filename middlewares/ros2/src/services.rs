//! Creates the ends of services and actions.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::Instant;

use genom_middleware::describe::types_of_service;
use genom_middleware::{
    Address, Client, EndpointKind, OpenError, Served, ServiceHandler, ServiceKind, ServiceType,
};
use genom_rosidl::TypeName;
use rustdds::dds::CreateResult;
use rustdds::{GUID, RTPSEntity, Timestamp};

use crate::body::Style;
use crate::channel::{ClientEnd, Names, ServerEnd};
use crate::client::{ACQUAINTANCE, Ros2Client, Way};
use crate::core::Core;
use crate::goals::{ActionServer, Ends, Ros2Action};
use crate::graph::{Claim, Made, Service, Wanted};
use crate::names;
use crate::parameters::Parameters;
use crate::post::Post;
use crate::runs::{ActionEnd, Feedback, Runs};
use crate::server::{Ros2Served, Server};
use crate::wire;
use crate::within::Own;

/// Greatest number of feedback messages that wait for the receiving thread.
const CACHED: i32 = 1024;

/// What this daemon serves and calls, by request topic.
pub(crate) struct ServiceEnds {
    core: Arc<Core>,
    own: Arc<Own>,
    clients: Mutex<HashMap<String, Weak<ClientEnd>>>,
    actions: Mutex<HashMap<String, Weak<ActionEnd>>>,
    parameters: Arc<Parameters>,
}

/// All names of one service.
struct Plan {
    wanted: Wanted,
    path: String,
    ty: TypeName,
    style: Style,
}

impl Plan {
    fn names(&self, suffix: &str, part: &str) -> Names {
        Names {
            path: format!("{}{suffix}", self.path),
            request: self.ty.to_dds(&format!("{part}_Request")),
            reply: self.ty.to_dds(&format!("{part}_Response")),
        }
    }

    fn cancel_goal(&self) -> Names {
        let ty = TypeName::new("action_msgs", "srv", "CancelGoal");
        Names {
            path: format!("{}/_action/cancel_goal", self.path),
            request: ty.to_dds("_Request"),
            reply: ty.to_dds("_Response"),
        }
    }

    fn feedback(&self) -> (String, String) {
        (format!("rt/{}/_action/feedback", self.path), self.ty.to_dds("_FeedbackMessage"))
    }
}

fn gids(guids: &[GUID]) -> Vec<[u8; 16]> {
    guids.iter().map(|guid| guid.to_bytes()).collect()
}

impl ServiceEnds {
    pub(crate) fn new(core: Arc<Core>) -> Arc<Self> {
        Arc::new(Self {
            core,
            own: Arc::default(),
            clients: Mutex::default(),
            actions: Mutex::default(),
            parameters: Arc::default(),
        })
    }

    fn plan(&self, at: &Address, ty: &ServiceType) -> Result<Plan, OpenError> {
        let path = self.core.path(at);
        let activity = ty.kind == ServiceKind::Activity;
        let foreign = self.core.masquerades.service(ty).map_err(|why| self.core.failed(at, why))?;
        let (ros, style) = match foreign {
            Some((name, manner)) => (name, Style::Foreign(manner)),
            None => {
                let folder = if activity { "action" } else { "srv" };
                (names::service(&ty.input, at, folder), Style::Genom)
            }
        };
        let (suffix, part) = if activity { ("/_action/send_goal", "_SendGoal") } else { ("", "") };
        let wanted = Wanted {
            kind: EndpointKind::Service,
            address: self.core.full(at),
            types: types_of_service(ty),
            digest: ty.digest(),
            topic: format!("rq/{path}{suffix}Request"),
            hash: None,
            dds_type: ros.to_dds(&format!("{part}_Request")),
            node: names::token(&at.instance),
        };
        Ok(Plan { wanted, path, ty: ros, style })
    }

    pub(crate) fn serve(
        &self,
        at: &Address,
        ty: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError> {
        let plan = self.plan(at, ty)?;
        let claim = self.core.graph.claim(at, plan.wanted.clone(), self.core.announcer())?;
        let weak = Arc::downgrade(&handler);
        let served = match ty.kind {
            ServiceKind::Activity => self.serve_action(&plan, ty, handler, claim),
            _ => self.serve_function(&plan, at, ty, handler, claim),
        };
        let served = served.map_err(|why| self.core.failed(at, why))?;
        self.own.add(plan.wanted.topic, weak);
        Ok(served)
    }

    fn serve_function(
        &self,
        plan: &Plan,
        at: &Address,
        ty: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
        claim: Claim,
    ) -> CreateResult<Box<dyn Served>> {
        let parameter = self.parameters.add(&self.core, at, ty, &handler);
        let server = Server::new(ty.clone(), plan.style, handler);
        let weak = Arc::downgrade(&server);
        let on_request = move |id, _, message: &[u8]| {
            if let Some(server) = weak.upgrade() {
                server.request(id, message);
            }
        };
        let names = plan.names("", "");
        let end =
            ServerEnd::open(&self.core.dds, &self.core.maker(), &names, Box::new(on_request))?;
        claim.made(Made {
            writers: gids(&[end.writer()]),
            readers: gids(&[end.reader]),
            offers: None,
        });
        let _ = server.end.set(end);
        let core = Arc::clone(&self.core);
        Ok(Box::new(Ros2Served { server, claim: Some(claim), parameter, core }))
    }

    fn serve_action(
        &self,
        plan: &Plan,
        ty: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
        claim: Claim,
    ) -> CreateResult<Box<dyn Served>> {
        let server = ActionServer::new(ty.clone(), plan.style, handler, self.core.orders().clone());
        let (maker, dds) = (self.core.maker(), &self.core.dds);
        let open = |names: &Names, on: fn(&Arc<ActionServer>, _, _, &[u8])| {
            let weak = Arc::downgrade(&server);
            let on_request = move |id, asker, message: &[u8]| {
                if let Some(server) = weak.upgrade() {
                    on(&server, id, asker, message);
                }
            };
            ServerEnd::open(dds, &maker, names, Box::new(on_request))
        };
        let get_result = open(&plan.names("/_action/get_result", "_GetResult"), |to, id, _, m| {
            to.get_result(id, m);
        })?;
        let cancel_goal = open(&plan.cancel_goal(), |to, id, _, m| to.cancel_goal(id, m))?;
        let send_goal = open(&plan.names("/_action/send_goal", "_SendGoal"), |to, id, by, m| {
            to.send_goal(id, by, m);
        })?;
        let (topic, name) = plan.feedback();
        let writer = dds.writer(&topic, &name, &wire::qos(true, false, CACHED))?;
        let feedback = Post::new(writer, &self.core.matches, Box::new(|_| {}));
        let topic = format!("rt/{}/_action/status", plan.path);
        let name = TypeName::new("action_msgs", "msg", "GoalStatusArray").to_dds("");
        let status = dds.writer(&topic, &name, &wire::qos(true, true, CACHED))?;
        claim.made(Made {
            writers: gids(&[
                send_goal.writer(),
                get_result.writer(),
                cancel_goal.writer(),
                feedback.guid(),
                status.guid(),
            ]),
            readers: gids(&[send_goal.reader, get_result.reader, cancel_goal.reader]),
            offers: None,
        });
        let status = Arc::new(Mutex::new(status));
        let ends = Ends { send_goal, get_result, cancel_goal, feedback, status };
        let _ = server.ends.set(ends);
        let core = Arc::clone(&self.core);
        Ok(Box::new(Ros2Action { server, claim: Some(claim), core }))
    }

    pub(crate) fn client(
        &self,
        at: &Address,
        ty: &ServiceType,
    ) -> Result<Box<dyn Client>, OpenError> {
        let plan = self.plan(at, ty)?;
        if let Service::Differs(theirs) = self.core.graph.service(&plan.wanted, Instant::now()) {
            let ours = types_of_service(ty);
            return Err(OpenError::TypeMismatch { address: at.clone(), ours, theirs });
        }
        let topic = plan.wanted.topic.clone();
        let way = match ty.kind {
            ServiceKind::Activity => {
                shared(&self.actions, topic, || self.action(&plan)).map(Way::Action)
            }
            _ => shared(&self.clients, topic, || {
                ClientEnd::open(&self.core.dds, &self.core.maker(), &plan.names("", ""))
            })
            .map(Way::Service),
        };
        let way = way.map_err(|why| self.core.failed(at, why))?;
        let (at, ty, style, core) = (at.clone(), ty.clone(), plan.style, Arc::clone(&self.core));
        let acquainted = Instant::now() + ACQUAINTANCE;
        Ok(Box::new(Ros2Client {
            at,
            ty,
            style,
            wanted: plan.wanted,
            way,
            acquainted,
            own: Arc::clone(&self.own),
            core,
        }))
    }

    fn action(&self, plan: &Plan) -> CreateResult<ActionEnd> {
        let (maker, dds) = (self.core.maker(), &self.core.dds);
        let runs = Arc::new(Runs::default());
        let (topic, name) = plan.feedback();
        let since = Timestamp::now();
        let reader = dds.reader(&topic, &name, &wire::qos(true, false, CACHED))?;
        let mut mark = [0; 8];
        let of = reader.guid().to_bytes();
        mark.iter_mut().zip(of.iter().skip(4)).for_each(|(to, byte)| *to = *byte);
        let sink = Feedback { runs: Arc::clone(&runs), since };
        let feedback = self.core.inlet.add(reader, Box::new(sink));
        let get_result = plan.names("/_action/get_result", "_GetResult");
        Ok(ActionEnd {
            send_goal: ClientEnd::open(
                dds,
                &maker,
                &plan.names("/_action/send_goal", "_SendGoal"),
            )?,
            get_result: ClientEnd::open(dds, &maker, &get_result)?,
            cancel_goal: ClientEnd::open(dds, &maker, &plan.cancel_goal())?,
            runs,
            feedback,
            inlet: Arc::clone(&self.core.inlet),
            mark,
        })
    }
}

/// The end of that name; reuses one that is still in use, or creates it.
fn shared<T>(
    all: &Mutex<HashMap<String, Weak<T>>>,
    name: String,
    make: impl FnOnce() -> CreateResult<T>,
) -> CreateResult<Arc<T>> {
    let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(there) = all.get(&name).and_then(Weak::upgrade) {
        return Ok(there);
    }
    all.retain(|_, other| other.strong_count() > 0);
    let made = Arc::new(make()?);
    all.insert(name, Arc::downgrade(&made));
    Ok(made)
}
