//! Creates the ends of services and actions.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::Instant;

use genom_middleware::describe::types_of_service;
use genom_middleware::{
    Address, Client, EndpointKind, OpenError, Served, ServiceHandler, ServiceKind, ServiceType,
};
use genom_rosidl::TypeName;

use crate::body::Style;
use crate::client::{ACQUAINTANCE, Ros2Client, Way};
use crate::goals::{ActionServer, Ends, Ros2Action};
use crate::names;
use crate::nodes::Nodes;
use crate::rmw::{Claim, ClientEnd, EndError, Entities, Named, Reply, Service, Wanted};
use crate::ros::{Ros, failed};
use crate::runs::{ActionEnd, Runs};
use crate::server::{Ros2Served, Server};
use crate::used::{Parts, Used, hash};
use crate::within::Own;

/// What this daemon serves and calls, by the name of the service.
pub(crate) struct ServiceEnds {
    ros: Arc<Ros>,
    own: Arc<Own>,
    clients: Mutex<HashMap<String, Weak<dyn ClientEnd>>>,
    actions: Mutex<HashMap<String, Weak<ActionEnd>>>,
    nodes: Arc<Nodes>,
}

/// All names of one service.
struct Plan {
    wanted: Wanted,
    path: String,
    ty: TypeName,
    parts: Parts,
    style: Style,
}

impl Plan {
    fn part(&self, suffix: &str, part: &str, of: Option<&Arc<Used>>) -> Named {
        Named {
            name: format!("{}/_action/{suffix}", self.path),
            ty: self.ty.part(part),
            hash: hash(of),
        }
    }

    /// The function itself, or the service that takes the goals of an action.
    fn service(&self) -> &Named {
        &self.wanted.of
    }

    fn get_result(&self) -> Named {
        self.part("get_result", "_GetResult", self.parts.get_result.as_ref())
    }

    fn feedback(&self) -> Named {
        self.part("feedback", "_FeedbackMessage", self.parts.feedback.as_ref())
    }

    /// A part of every action, of a type of ROS.
    fn common(&self, ros: &Ros, suffix: &str, folder: &str, name: &str) -> Named {
        let ty = TypeName::new("action_msgs", folder, name);
        ros.of_ros(format!("{}/_action/{suffix}", self.path), ty)
    }

    fn cancel_goal(&self, ros: &Ros) -> Named {
        self.common(ros, "cancel_goal", "srv", "CancelGoal")
    }

    fn status(&self, ros: &Ros) -> Named {
        self.common(ros, "status", "msg", "GoalStatusArray")
    }
}

impl ServiceEnds {
    pub(crate) fn new(ros: Arc<Ros>, nodes: Arc<Nodes>) -> Arc<Self> {
        Arc::new(Self {
            ros,
            own: Arc::default(),
            clients: Mutex::default(),
            actions: Mutex::default(),
            nodes,
        })
    }

    fn plan(&self, at: &Address, ty: &ServiceType) -> Result<Plan, OpenError> {
        let masquerades = &self.ros.masquerades;
        let path = self.ros.names.path(at);
        let activity = ty.kind == ServiceKind::Activity;
        let foreign = masquerades.service(ty).map_err(|why| failed(at, why))?;
        let parts = |name: &TypeName, foreign| masquerades.of_service(name, ty, foreign);
        let (ros, parts, style) = match foreign {
            Some((name, manner)) => {
                let parts = parts(&name, true);
                (name, parts, Style::Foreign(manner))
            }
            None => {
                let folder = if activity { "action" } else { "srv" };
                let name = names::service(&ty.input, at, folder);
                let parts = parts(&name, false);
                (name, parts, Style::Genom)
            }
        };
        let (suffix, part) = if activity { ("/_action/send_goal", "_SendGoal") } else { ("", "") };
        let of = Named {
            name: format!("{path}{suffix}"),
            ty: ros.part(part),
            hash: hash(parts.service.as_ref()),
        };
        let wanted = Wanted {
            kind: EndpointKind::Service,
            address: self.ros.names.full(at),
            types: types_of_service(ty),
            digest: ty.digest(),
            of,
            node: self.ros.names.node(&at.instance),
        };
        Ok(Plan { wanted, path, ty: ros, parts, style })
    }

    pub(crate) fn serve(
        &self,
        at: &Address,
        ty: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError> {
        let plan = self.plan(at, ty)?;
        let claim = self.ros.rmw.claim(at, &plan.wanted)?;
        let weak = Arc::downgrade(&handler);
        let served = match ty.kind {
            ServiceKind::Activity => self.serve_action(&plan, at, ty, handler, claim),
            _ => self.serve_function(&plan, at, ty, handler, claim),
        };
        let served = served.map_err(|why| failed(at, why))?;
        self.own.add(plan.wanted.of.name, weak);
        Ok(served)
    }

    fn serve_function(
        &self,
        plan: &Plan,
        at: &Address,
        ty: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
        claim: Box<dyn Claim>,
    ) -> Result<Box<dyn Served>, EndError> {
        let ros = &self.ros;
        let part = self.nodes.service(ros, at, ty, &handler, &plan.parts);
        let server = Server::new(ty.clone(), plan.style, handler);
        let weak = Arc::downgrade(&server);
        let on_request = move |reply, message: &[u8]| {
            if let Some(server) = weak.upgrade() {
                server.request(reply, message);
            }
        };
        let end = ros.rmw.server(&plan.wanted.node, plan.service(), Box::new(on_request))?;
        claim.made(end.entities());
        Ok(Box::new(Ros2Served {
            server,
            end,
            claim: Some(claim),
            part,
            rmw: Arc::clone(&ros.rmw),
        }))
    }

    fn serve_action(
        &self,
        plan: &Plan,
        at: &Address,
        ty: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
        claim: Box<dyn Claim>,
    ) -> Result<Box<dyn Served>, EndError> {
        let part = self.nodes.service(&self.ros, at, ty, &handler, &plan.parts);
        let server = ActionServer::new(ty.clone(), plan.style, handler);
        let (ros, node) = (&self.ros, plan.wanted.node.as_str());
        let open = |of: &Named, on: fn(&Arc<ActionServer>, Box<dyn Reply>, &[u8])| {
            let weak = Arc::downgrade(&server);
            let on_request = move |reply, message: &[u8]| {
                if let Some(server) = weak.upgrade() {
                    on(&server, reply, message);
                }
            };
            ros.rmw.server(node, of, Box::new(on_request))
        };
        // Whoever sees the service for goals finds the others.
        let feedback = ros.rmw.writer(node, &plan.feedback(), false)?;
        let status = ros.rmw.writer(node, &plan.status(ros), true)?;
        let _ = server.topics.set((feedback, status));
        let get_result = open(&plan.get_result(), |to, by, m| to.get_result(by, m))?;
        let cancel_goal = open(&plan.cancel_goal(ros), |to, by, m| to.cancel_goal(by, m))?;
        let send_goal = open(plan.service(), ActionServer::send_goal)?;
        let ends = Ends { send_goal, get_result, cancel_goal };
        let mut entities = Entities::default();
        let topics = server.topics.get().map(|(feedback, status)| [feedback, status]);
        let topics = topics.into_iter().flatten().map(|topic| topic.entities());
        for one in ends.all().into_iter().map(|end| end.entities()).chain(topics) {
            entities.writers.extend(one.writers);
            entities.readers.extend(one.readers);
        }
        claim.made(entities);
        let rmw = Arc::clone(&ros.rmw);
        Ok(Box::new(Ros2Action { server, ends, claim: Some(claim), part, rmw }))
    }

    pub(crate) fn client(
        &self,
        at: &Address,
        ty: &ServiceType,
    ) -> Result<Box<dyn Client>, OpenError> {
        let plan = self.plan(at, ty)?;
        if let Service::Differs(theirs) = self.ros.rmw.service(&plan.wanted, Instant::now()) {
            let ours = types_of_service(ty);
            return Err(OpenError::TypeMismatch { address: at.clone(), ours, theirs });
        }
        let of = plan.service();
        // Two of one name may have different types if one of them masquerades.
        let key = format!("{} {}", of.name, of.ty);
        let way = match ty.kind {
            ServiceKind::Activity => {
                shared(&self.actions, key, || self.action(&plan).map(Arc::new)).map(Way::Action)
            }
            _ => shared(&self.clients, key, || {
                Ok(Arc::from(self.ros.rmw.caller(&self.ros.names.own_node(), of)?))
            })
            .map(Way::Service),
        };
        let way = way.map_err(|why| failed(at, why))?;
        let (at, ty, style, rmw) = (at.clone(), ty.clone(), plan.style, Arc::clone(&self.ros.rmw));
        let acquainted = Instant::now() + ACQUAINTANCE;
        Ok(Box::new(Ros2Client {
            at,
            ty,
            style,
            wanted: plan.wanted,
            way,
            acquainted,
            own: Arc::clone(&self.own),
            rmw,
        }))
    }

    fn action(&self, plan: &Plan) -> Result<ActionEnd, EndError> {
        let (ros, node) = (&self.ros, self.ros.names.own_node());
        let runs = Arc::new(Runs::default());
        let heard = Arc::clone(&runs);
        let on_feedback = Box::new(move |message: &[u8]| heard.feedback(message));
        Ok(ActionEnd {
            feedback: ros.rmw.reader(&node, &plan.feedback(), on_feedback)?,
            send_goal: ros.rmw.caller(&node, plan.service())?,
            get_result: ros.rmw.caller(&node, &plan.get_result())?,
            cancel_goal: ros.rmw.caller(&node, &plan.cancel_goal(ros))?,
            runs,
            mark: ros.rmw.mark(),
        })
    }
}

/// The end of that name; reuses one that is still in use, or creates it.
fn shared<T: ?Sized>(
    all: &Mutex<HashMap<String, Weak<T>>>,
    name: String,
    make: impl FnOnce() -> Result<Arc<T>, EndError>,
) -> Result<Arc<T>, EndError> {
    let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(there) = all.get(&name).and_then(Weak::upgrade) {
        return Ok(there);
    }
    all.retain(|_, other| other.strong_count() > 0);
    let made = make()?;
    all.insert(name, Arc::downgrade(&made));
    Ok(made)
}
