//! The middleware: a session, opened according to its options.

use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::Arc;

use genom_middleware::{
    Backend, Capabilities, DiscoverError, Discovery, Endpoint, Middleware, Obstacle, Relay,
    Services, Stranger,
};
use genom_zenoh_doctor::plain;
use zenoh::key_expr::OwnedKeyExpr;
use zenoh::{Session, Wait};

use crate::core::{Core, apart};
use crate::error::{BACKEND, SessionError};
use crate::keys::Keys;
use crate::options::Options;
use crate::rendezvous::{self, Rendezvous};
use crate::trouble;

/// A zenoh session as a middleware.
pub struct Zenoh {
    /// Settings with which foreign programs reach it.
    meeting: Vec<(Cow<'static, str>, String)>,
    pub(crate) core: Arc<Core>,
}

impl Zenoh {
    /// Opens a session. May take half a second if an endpoint to connect to is unreachable.
    ///
    /// # Errors
    /// An option is wrong, or zenoh fails.
    pub fn open(options: &Options) -> Result<Arc<Self>, SessionError> {
        let prefix = options.prefix.trim_matches('/');
        let keys = Keys::new(prefix);
        if !prefix.is_empty()
            && (prefix.contains(['*', '$', '@']) || OwnedKeyExpr::new(prefix).is_err())
        {
            return Err(SessionError::Prefix(prefix.to_owned()));
        }
        let alone = options.to_zenoh(None, &[])?;
        let (rendezvous, session) = match options.meeting() {
            None => (None, open(options, alone.clone())?),
            Some(directory) => {
                let entered = Rendezvous::enter(directory).map_err(|source| {
                    SessionError::Rendezvous { path: directory.to_owned(), source }
                })?;
                let (own, opening) = entered;
                let config = options.to_zenoh(Some(own.socket()), &opening.others)?;
                let session = open(options, config)?;
                (Some(own), session)
            }
        };
        // The endpoint that clients of this session connect to.
        let own = rendezvous.iter().map(|own| rendezvous::endpoint(own.socket()));
        let connect: Vec<String> = own.chain(options.listen.iter().cloned()).collect();
        let mut meeting = vec![(Cow::from("prefix"), keys.of_all().to_owned())];
        if !connect.is_empty() {
            meeting.push(("connect".into(), connect.join(",")));
        }
        if let Some(directory) = options.sole_meeting() {
            meeting.push(("rendezvous".into(), directory.display().to_string()));
        }
        let core = Core::new((session, alone), keys, rendezvous)?;
        Ok(Arc::new(Self { meeting, core }))
    }

    /// Blocks the out port that was opened first from sending until the result is dropped, so that
    /// tests can see how a stalled network affects real-time callers.
    #[doc(hidden)]
    #[must_use]
    pub fn stall(&self) -> impl Send + use<> {
        self.core.orders().stall()
    }
}

fn open(options: &Options, config: zenoh::Config) -> Result<Session, SessionError> {
    let opened = apart(|| zenoh::open(config).wait().map_err(|error| plain(&error.to_string())));
    let opened = opened.unwrap_or_else(|| Err("it panicked; see standard error".to_owned()));
    let secret = options.connect.iter().any(|endpoint| endpoint.starts_with("tls/"));
    opened.map_err(if secret { SessionError::Refused } else { SessionError::Open })
}

impl Backend for Zenoh {
    const NAME: &'static str = BACKEND;
    const VERSION: &'static str = "zenoh 1.10";
    const GATEWAY: bool = true;
    type Options = Options;
    type Error = SessionError;

    fn places(options: &Options) -> Vec<PathBuf> {
        options.rendezvous.clone().into_iter().collect()
    }

    fn open(options: Options) -> Result<Arc<dyn Middleware>, SessionError> {
        Ok(Self::open(&options)?)
    }
}

impl Middleware for Zenoh {
    fn name(&self) -> &'static str {
        BACKEND
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities::NETWORK
    }

    fn meeting_point(&self) -> Vec<(Cow<'static, str>, String)> {
        self.meeting.clone()
    }

    fn services(&self) -> Option<&dyn Services> {
        Some(self)
    }

    fn discovery(&self) -> Option<&dyn Discovery> {
        Some(self)
    }

    fn trouble(&self) -> Vec<Obstacle> {
        trouble::trouble(&self.core)
    }

    fn relay(&self) -> Option<&dyn Relay> {
        Some(self)
    }
}

impl Discovery for Zenoh {
    fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError> {
        Ok(self.core.graph().list())
    }

    fn strangers(&self) -> Vec<Stranger> {
        self.core.strangers()
    }
}
