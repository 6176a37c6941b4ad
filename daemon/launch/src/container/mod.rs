//! A component container (ROS 2 design, "Composition", `composition_interfaces`): launch files and
//! `ros2 component load` have the daemon load components, of those that the configuration lists.

mod messages;
mod wanted;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use genom_doors::Own;
use genom_finder::{LocateError, ReadError, Reading, component_name, locate};
use genom_middleware::Address;
use genom_nearest::suggest;
use genom_protocol::{
    BackendNames, ConnectionRequest, LoadRequest, Reason, Remap, renamed, routes,
};
use genom_registry::Backends;
use serde_json::{Value, json};
use tokio::runtime::Handle;
use tokio::task::spawn_blocking;

use crate::offer::{Answers, NotServed, Offered, unless_gone};
use messages::Service;
use wanted::{Rules, Unwanted, attributes, cell, parameter, refused, rules};

/// A container of components.
#[derive(Clone, Debug)]
pub struct Container {
    /// Its node.
    pub node: String,
    /// Libraries, descriptions or names of the components that it loads.
    pub components: Vec<String>,
    /// Middlewares of their ports and services.
    pub backend: BackendNames,
    /// Components that it holds at a time.
    pub most: usize,
    /// Directories in which components are searched.
    pub path: Vec<PathBuf>,
    /// Whether the clock of components is that of a simulator.
    pub simulated: bool,
    /// Directories in which files are searched that descriptions include.
    pub include: Vec<PathBuf>,
}

/// Offers the services of a container, which act through `plane`. This may take a while, as it opens
/// the middleware.
///
/// # Errors
/// The middleware cannot be opened, or refuses a service.
pub fn contain(
    container: Container,
    backends: &Arc<Backends>,
    plane: &Own,
    runtime: &Handle,
) -> Result<Offered, NotServed> {
    let mut offered = Offered::nothing(backends)?;
    offered.speak(backends, &Service::ALL)?;
    let node = container.node.clone();
    let spelled = offered.middleware().spelled(&Address::new(node.clone(), "x"));
    let namespace = spelled.strip_suffix("/x").and_then(|full| full.strip_suffix(&node));
    let namespace = namespace.unwrap_or_default().trim_matches('/').to_owned();
    tracing::info!("{node}: a container of ROS 2, for {}", container.components.join(", "));
    let node = Arc::new(Node {
        namespace,
        what: container,
        plane: plane.clone(),
        loaded: Mutex::default(),
        loading: tokio::sync::Mutex::default(),
    });
    let name = node.what.node.clone();
    offered.add(&name, &Service::ALL, &node, runtime)?;
    Ok(offered)
}

/// Why a component was not loaded, or not unloaded.
#[derive(Debug, thiserror::Error)]
enum Failure {
    #[error("{}", .0.line())]
    Refused(Reason),
    #[error("package `{name}` is not among those of this container; {help}")]
    NotListed { name: String, help: String },
    #[error("package `{package}` has component `{component}`, not `{plugin}`")]
    NoPlugin { package: String, component: String, plugin: String },
    #[error("there are {0} components in this container, the most that it takes")]
    Full(usize),
    #[error("there is no component {0} in this container")]
    Unknown(u64),
    #[error(transparent)]
    Unwanted(#[from] Unwanted),
    #[error(transparent)]
    NotFound(#[from] LocateError),
    #[error(transparent)]
    Unreadable(#[from] ReadError),
    #[error("the daemon stops")]
    Stopping,
}

impl From<Reason> for Failure {
    fn from(reason: Reason) -> Self {
        Self::Refused(reason)
    }
}

/// A component that the container loaded.
#[derive(Clone)]
struct Loaded {
    instance: String,
    /// `/lab/arm`.
    full_name: String,
}

/// The node of a container.
struct Node {
    /// Of the nodes that have no other, without slashes around it.
    namespace: String,
    what: Container,
    plane: Own,
    /// By number, which is never given twice.
    loaded: Mutex<(u64, BTreeMap<u64, Loaded>)>,
    /// One is loaded after the other.
    loading: tokio::sync::Mutex<()>,
}

impl Answers<Service> for Node {
    fn name(&self) -> &str {
        &self.what.node
    }

    async fn answer(&self, service: Service, input: &Value) -> Value {
        match service {
            Service::LoadNode => match self.load(input).await {
                Ok((number, loaded)) => json!({
                    "success": true,
                    "full_node_name": loaded.full_name,
                    "unique_id": number,
                }),
                Err(why) => self.told(&why, "is not loaded"),
            },
            Service::UnloadNode => match self.unload(input).await {
                Ok(()) => json!({"success": true}),
                Err(why) => self.told(&why, "is not unloaded"),
            },
            Service::ListNodes => {
                self.look().await;
                let loaded = self.lock();
                let names: Vec<&str> = loaded.1.values().map(|one| &*one.full_name).collect();
                let numbers: Vec<u64> = loaded.1.keys().copied().collect();
                json!({"full_node_names": names, "unique_ids": numbers})
            }
        }
    }
}

/// Text of a member of a request.
fn text<'a>(input: &'a Value, member: &str) -> &'a str {
    input[member].as_str().unwrap_or_default()
}

fn all<'a>(input: &'a Value, member: &str) -> &'a [Value] {
    input[member].as_array().map(Vec::as_slice).unwrap_or_default()
}

impl Node {
    fn lock(&self) -> MutexGuard<'_, (u64, BTreeMap<u64, Loaded>)> {
        self.loaded.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn told(&self, why: &Failure, what: &str) -> Value {
        tracing::warn!("{}: a component {what}: {why}", self.what.node);
        refused(why)
    }

    /// Forgets what others unloaded: whoever uses the control plane can do so.
    async fn look(&self) {
        let Ok(running) = self.plane.ask(&routes::components(), None).await else { return };
        let runs = |one: &Loaded| running.components.iter().any(|other| other.name == one.instance);
        self.lock().1.retain(|_, one| runs(one));
    }

    /// The library, description or name that the configuration lists for a package.
    fn listed(&self, package: &str) -> Result<&str, Failure> {
        let listed = &self.what.components;
        let names: Vec<String> = listed.iter().map(|one| component_name(Path::new(one))).collect();
        let found = listed.iter().zip(&names).find(|(_, name)| *name == package);
        found.map(|(listed, _)| &**listed).ok_or_else(|| Failure::NotListed {
            name: package.to_owned(),
            help: suggest(package, names.iter().map(String::as_str)),
        })
    }

    /// The request as one of the control plane, and in ports with what they are to read.
    async fn understand(&self, input: &Value) -> Result<(LoadRequest, Rules), Failure> {
        let package = text(input, "package_name");
        let library = PathBuf::from(self.listed(package)?);
        let mut request = LoadRequest { library, ..LoadRequest::default() };
        let (wanted, path, include) =
            (request.clone(), self.what.path.clone(), self.what.include.clone());
        let reading = spawn_blocking(move || {
            let located = locate(&wanted, &path)?;
            Ok::<_, Failure>(Reading::new(&located.description, &include)?)
        });
        let reading = reading.await.map_err(|_| Failure::Stopping)??;
        let model = reading.model();
        let plugin = text(input, "plugin_name");
        // Classes of C++ have their namespace in front.
        if plugin.rsplit("::").next().is_some_and(|name| !name.is_empty() && name != model.name) {
            return Err(Failure::NoPlugin {
                package: package.to_owned(),
                component: model.name.clone(),
                plugin: plugin.to_owned(),
            });
        }
        let name = Some(text(input, "node_name")).filter(|name| !name.is_empty());
        let name = name.unwrap_or(&model.name);
        let given: Vec<&str> = all(input, "remap_rules").iter().filter_map(Value::as_str).collect();
        let mut sorted = rules(model, name, &given)?;
        let namespace = text(input, "node_namespace");
        if !namespace.is_empty() {
            let namespace = format!("__ns:=/{}", namespace.trim_start_matches('/'));
            sorted.remap.insert(0, namespace.parse().map_err(Unwanted::from)?);
        }
        let of = |member| all(input, member).iter().map(parameter).collect::<Vec<_>>();
        request.attributes = attributes(model, &of("parameters"), self.what.simulated)?;
        request.cell = cell(&of("extra_arguments"))?;
        request.backend = Some(self.what.backend.clone());
        request.name = Some(name.to_owned());
        request.remap.clone_from(&sorted.remap);
        Ok((request, sorted))
    }

    /// Namespace and name of the node of an instance, without slashes around them.
    fn node_of(&self, instance: &str, remap: &[Remap]) -> (String, String) {
        let names = renamed(instance, remap);
        let node = names.iter().find(|(of, _)| of == instance).map_or(instance, |(_, to)| to);
        let (namespace, node) = node.rsplit_once('/').unwrap_or((&self.namespace, node));
        (namespace.trim_matches('/').to_owned(), node.to_owned())
    }

    async fn load(&self, input: &Value) -> Result<(u64, Loaded), Failure> {
        let _alone = self.loading.lock().await;
        self.look().await;
        if self.lock().1.len() >= self.what.most {
            return Err(Failure::Full(self.what.most));
        }
        let (request, rules) = self.understand(input).await?;
        let instance = request.instance();
        self.plane.ask(&routes::load(), Some(&request)).await?;
        let (namespace, node) = self.node_of(&instance, &rules.remap);
        let absolute = |parts: [&str; 3]| {
            let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
            format!("/{}", parts.join("/"))
        };
        for (port, to) in &rules.reads {
            let topic = match (to.strip_prefix('/'), to.strip_prefix("~/")) {
                (Some(topic), _) => absolute([topic, "", ""]),
                (_, Some(private)) => absolute([&namespace, &node, private]),
                _ => absolute([&namespace, to, ""]),
            };
            let request = ConnectionRequest {
                inport: format!("{instance}/{port}"),
                outport: format!("ros2:{topic}"),
                policy: None,
                over: None,
                wait: true,
            };
            if let Err(why) = self.plane.ask(&routes::connect(), Some(&request)).await {
                self.plane.ask(&routes::unload(&instance), None).await?;
                return Err(why.into());
            }
        }
        let full_name = absolute([&namespace, &node, ""]);
        let loaded = Loaded { instance, full_name };
        tracing::info!("{}: loaded as {}, as ROS asked", loaded.instance, loaded.full_name);
        let mut all = self.lock();
        all.0 += 1;
        let number = all.0;
        all.1.insert(number, loaded.clone());
        Ok((number, loaded))
    }

    async fn unload(&self, input: &Value) -> Result<(), Failure> {
        let number = input["unique_id"].as_u64().unwrap_or_default();
        let _alone = self.loading.lock().await;
        self.look().await;
        let known = self.lock().1.get(&number).cloned();
        let Some(Loaded { instance, .. }) = known else { return Err(Failure::Unknown(number)) };
        unless_gone(self.plane.ask(&routes::unload(&instance), None).await)?;
        self.lock().1.remove(&number);
        tracing::info!("{instance}: unloaded, as ROS asked");
        Ok(())
    }
}
