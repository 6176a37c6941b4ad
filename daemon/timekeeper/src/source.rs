//! The topic `/clock` of ROS 2.

use std::sync::Arc;
use std::thread::Thread;
use std::time::Duration;

use genom_middleware::{
    Address, OpenError, Policy, PortSpec, Quality, ReadError, Reading, Subscription,
};
use genom_registry::{BackendError, Backends};
use genom_types::{DataType, Kind, LayoutError, Member, Record, ScopedName, TypeTable};

/// Name of the topic, the same in every namespace.
pub(crate) const TOPIC: &str = "/clock";

/// The middleware that has it.
const ON: &str = "ros2";

/// How many dates may wait to be read. Beyond that the oldest are left out, and the steps are longer.
const WAITING: usize = 64;

/// Why there is no source.
#[derive(Debug, thiserror::Error)]
pub enum NoSource {
    /// The middleware cannot be opened.
    #[error("the clock follows {TOPIC}, and {0}")]
    Middleware(#[from] BackendError),
    /// The topic cannot be read.
    #[error("the clock follows {TOPIC}, and {0}")]
    Topic(#[from] OpenError),
    /// Does not happen: the message has a layout.
    #[error(transparent)]
    Layout(#[from] LayoutError),
}

/// Why a date is left out.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoDate {
    /// The middleware could not read it.
    #[error(transparent)]
    Unread(#[from] ReadError),
    /// It has a negative second, or more than a second of nanoseconds.
    #[error("{0} is no date: `sec` from 0, `nanosec` below 1000000000")]
    Beyond(String),
}

/// Reads the dates.
pub struct Source {
    subscription: Box<dyn Subscription>,
    /// `rosgraph_msgs/msg/Clock`: `sec` (int32), then `nanosec` (uint32).
    message: Record,
}

impl Source {
    /// Starts to read the topic. This may take a while, as it opens the middleware.
    ///
    /// # Errors
    /// The middleware cannot be opened, or refuses the topic.
    pub fn open(backends: &Backends) -> Result<Self, NoSource> {
        let ty = clock()?;
        let middleware = backends.get(ON)?;
        let address = Address::new("", TOPIC.trim_start_matches('/'));
        // Best effort, as ROS's nodes ask for it (`ClockQoS`).
        let quality = Quality { reliable: Some(false), ..Quality::default() };
        let port = PortSpec::new(&address, &ty).of(quality);
        let subscription = middleware.subscription(&port, Policy::Ring(WAITING))?;
        Ok(Self { subscription, message: Record::new(&ty) })
    }

    /// Has `thread` unparked when a date arrives. Returns whether the middleware does that.
    pub(crate) fn wakes(&mut self, thread: Thread) -> bool {
        self.subscription.on_arrival(Box::new(move || thread.unpark()))
    }

    /// The next date, if there is one.
    ///
    /// # Errors
    /// What was published is no date.
    pub(crate) fn next(&mut self) -> Result<Option<Duration>, NoDate> {
        match self.subscription.read(&mut self.message) {
            Ok(Reading::New) => self.date().map(Some),
            Ok(Reading::Same | Reading::Never) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    fn date(&self) -> Result<Duration, NoDate> {
        let date = &self.message.to_json()["clock"];
        let part = |name: &str| date[name].as_u64();
        match (part("sec"), part("nanosec")) {
            (Some(seconds), Some(nanos)) if nanos < 1_000_000_000 => {
                Ok(Duration::from_secs(seconds) + Duration::from_nanos(nanos))
            }
            _ => Err(NoDate::Beyond(date.to_string())),
        }
    }
}

/// `rosgraph_msgs/msg/Clock`.
fn clock() -> Result<DataType, LayoutError> {
    let mut table = TypeTable::default();
    let member = |name: &str, ty| Member { name: name.to_owned(), ty };
    let (sec, nanosec) = (table.add(Kind::Long), table.add(Kind::UnsignedLong));
    let time = table.add(Kind::Struct {
        name: ScopedName::new(["builtin_interfaces", "Time"]),
        members: vec![member("sec", sec), member("nanosec", nanosec)],
    });
    let clock = table.add(Kind::Struct {
        name: ScopedName::new(["rosgraph_msgs", "Clock"]),
        members: vec![member("clock", time)],
    });
    DataType::new(&Arc::new(table), clock)
}
