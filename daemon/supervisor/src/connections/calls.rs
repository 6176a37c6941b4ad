//! Calls that codels make through remotes: to a service of this daemon, or through a middleware to
//! a service elsewhere (genom3.md 5.8).

use std::sync::mpsc::channel;
use std::sync::{Arc, Weak};
use std::time::Duration;

use genom_description::model::{Service, ServiceIx};
use genom_middleware::Outcome as Reply;
use genom_middleware::{Address, CallError, Client, Middleware, OpenError, ServiceType};
use genom_runtime::Outcome;
use genom_runtime::body::RemoteCall;
use genom_types::Record;
use serde_json::{Value, json};

use crate::components::{Components, Heard, Hosted};

/// An exception raised in the calling codel: its name and members.
type Thrown = (String, Value);

/// genom3.md 5.8: a call lasts as long as the service runs, without a timeout. This is the longest
/// time that middlewares accept.
const FOR_EVER: Duration = Duration::from_secs(10 * 365 * 24 * 3600);

/// A call within the daemon. The provider may be unloaded and loaded again: it is looked up at each
/// call.
pub(super) struct DirectCall {
    /// Weak, because the components own the caller.
    components: Weak<Components>,
    provider: String,
    service: String,
    /// Digest that the service must have (genom3.md 4.9), since a component loaded again may
    /// differ.
    digest: String,
    /// Version of the calling component, for exceptions.
    version: String,
}

impl DirectCall {
    /// Calls `service` of the component `provider`, on behalf of a component of this version.
    pub(super) fn new(
        components: &Arc<Components>,
        provider: &Hosted,
        service: &Service,
        caller: &str,
    ) -> Self {
        let (provider, version) = (provider.name.clone(), caller.to_owned());
        let (service, digest) = (service.name.clone(), service.call_digest.clone());
        Self { components: Arc::downgrade(components), provider, service, digest, version }
    }

    fn provider(&self) -> Option<(Arc<Hosted>, ServiceIx)> {
        let hosted = self.components.upgrade()?.get(&self.provider)?;
        let index = hosted.plan().service(&self.service)?;
        Some((hosted, index))
    }
}

impl RemoteCall for DirectCall {
    fn call(&mut self, input: &Record, output: &mut Record) -> Result<(), Thrown> {
        let absent = || ("::genom::no_such_service".to_owned(), Value::Null);
        let broken = |why: String| ("::genom::remote_io".to_owned(), json!({ "what": why }));
        let (hosted, index) = self.provider().ok_or_else(absent)?;
        let model = hosted.model();
        if model.services[index].call_digest != self.digest {
            return Err(incompatible(&self.version, &model.version));
        }
        hosted.may_wait_here(index).map_err(|error| broken(error.to_string()))?;
        let mut request = Record::new(&hosted.plan().services()[index].input);
        request.copy_from(input).map_err(|error| broken(error.to_string()))?;
        let (sender, ended) = channel();
        hosted.submit(index, request, move |heard| {
            if let Heard::Ended(outcome) = heard {
                let _ = sender.send(outcome);
            }
        });
        // The sender was dropped without a reply: the provider was stopped.
        let killed = |_| ("::genom::interrupted".to_owned(), json!({ "by": "kill" }));
        match ended.recv().map_err(killed)? {
            Outcome::Success(record) => {
                output.copy_from(&record).map_err(|error| broken(error.to_string()))
            }
            Outcome::Exception(exception) => Err((exception.name, exception.detail)),
        }
    }
}

/// A call through a middleware. The service may disappear and come back: the client is closed when
/// the service is gone, and opened again at the next call.
pub(super) struct FarCall {
    middleware: Arc<dyn Middleware>,
    at: Address,
    ty: ServiceType,
    /// Version of the calling component, for exceptions.
    version: String,
    client: Option<Box<dyn Client>>,
}

impl FarCall {
    /// Opens the client. Fails if the types are known to differ.
    pub(super) fn open(
        middleware: &Arc<dyn Middleware>,
        at: &Address,
        ty: ServiceType,
        version: &str,
    ) -> Result<Self, OpenError> {
        let client = Some(middleware.client(at, &ty)?);
        let (middleware, at, version) = (Arc::clone(middleware), at.clone(), version.to_owned());
        Ok(Self { middleware, at, ty, version, client })
    }

    /// Name of the middleware.
    pub(super) fn backend(&self) -> &'static str {
        self.middleware.name()
    }

    fn send(&mut self, input: &Record) -> Result<Reply, CallError> {
        let mut client = match self.client.take() {
            Some(client) => client,
            None => self.middleware.client(&self.at, &self.ty).map_err(unopened)?,
        };
        match client.call(input, FOR_EVER)? {
            Reply::Lost(error) => Err(error),
            reply => {
                self.client = Some(client);
                Ok(reply)
            }
        }
    }

    /// The exception for a failed call (genom3.md 4.8).
    fn thrown(&self, error: &CallError) -> Thrown {
        tracing::warn!("call of {} on {}: {error}", self.at, self.backend());
        let (name, detail) = match error {
            CallError::Nobody { .. } => ("no_such_service", Value::Null),
            CallError::Serialization(_) => ("serialization", Value::Null),
            CallError::TypeMismatch { .. } => {
                return incompatible(&self.version, "");
            }
            _ => ("remote_io", Value::Null),
        };
        (format!("::genom::{name}"), detail)
    }
}

/// genom3.md 4.8: the versions of both sides, as far as known.
fn incompatible(client: &str, server: &str) -> Thrown {
    let side =
        |version: &str| json!({ "version": version.get(..31).unwrap_or(version), "date": "" });
    let detail = json!({ "client": side(client), "server": side(server) });
    ("::genom::incompatible_digest".to_owned(), detail)
}

fn unopened(error: OpenError) -> CallError {
    match error {
        OpenError::TypeMismatch { address, ours, theirs } => {
            CallError::TypeMismatch { address, ours, theirs }
        }
        OpenError::Failed { backend, why, .. } => CallError::Failed { backend, why },
        error => CallError::Failed { backend: String::new(), why: error.to_string() },
    }
}

impl RemoteCall for FarCall {
    fn call(&mut self, input: &Record, output: &mut Record) -> Result<(), Thrown> {
        match self.send(input) {
            Ok(Reply::Success(record)) => output
                .copy_from(&record)
                .map_err(|error| self.thrown(&CallError::Serialization(error.to_string()))),
            Ok(Reply::Exception { name, detail }) => Err((name, detail)),
            Ok(Reply::Lost(error)) | Err(error) => Err(self.thrown(&error)),
        }
    }
}
