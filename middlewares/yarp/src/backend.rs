//! The middleware as genomd opens it.

use std::borrow::Cow;
use std::sync::Arc;

use genom_middleware::{Backend, Capabilities, Discovery, Middleware, Refused, Services};

use crate::core::Core;
use crate::desks::Desks;
use crate::error::{BACKEND, YarpError};
use crate::options::Options;
use crate::readers::Readers;
use crate::steward;

/// YARP as a middleware.
pub struct Yarp {
    pub(crate) core: Arc<Core>,
    pub(crate) readers: Readers,
    pub(crate) desks: Arc<Desks>,
}

impl Yarp {
    /// Opens it. The name server is asked when the first port is opened.
    ///
    /// # Errors
    /// An option is wrong, a file of YARP cannot be used, or the system gives no thread.
    pub fn open(options: &Options) -> Result<Arc<Self>, YarpError> {
        let (core, jobs) = Core::new(options.settings()?)?;
        core.joins(steward::start(jobs, Arc::downgrade(&core))?);
        Ok(Arc::new(Self { core, readers: Readers::default(), desks: Arc::default() }))
    }
}

impl Backend for Yarp {
    const NAME: &'static str = BACKEND;
    const VERSION: &'static str = "YARP 3 (own implementation)";
    const GATEWAY: bool = true;
    type Options = Options;
    type Error = YarpError;

    fn check(options: &Options) -> Result<(), YarpError> {
        options.check()
    }

    fn open(options: Options) -> Result<Arc<dyn Middleware>, YarpError> {
        Ok(Self::open(&options)?)
    }
}

impl Middleware for Yarp {
    fn name(&self) -> &'static str {
        BACKEND
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities::NETWORK
    }

    fn services(&self) -> Option<&dyn Services> {
        Some(self)
    }

    fn discovery(&self) -> Option<&dyn Discovery> {
        Some(self)
    }

    fn meeting_point(&self) -> Vec<(Cow<'static, str>, String)> {
        vec![("server".into(), self.core.names.server())]
    }

    fn refused(&self) -> Vec<Refused> {
        self.core.refusals.listed()
    }
}
