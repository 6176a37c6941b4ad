//! A component's code and memory: the runtime's `Body`.

mod call;
mod checker;
mod code;
mod codel;
mod convert;
mod copies;
mod cxx;
mod error;
mod exchange;
mod frame;
mod inner;
mod last;
mod parts;
mod returned;
mod saved;
mod types;
mod way;
mod zones;

pub use convert::Conversions;
pub use error::{CannotExchange, LoadError, LoadErrors};
pub use zones::{MemoryCheck, check_memory};

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use genom_description::model::{Owner, PortIx, RemoteIx, Span};
use genom_middleware::{Publisher, Subscription};
use genom_runtime::body::{Body, Frame, Opener, RemoteCall};
use genom_runtime::plan::Plan;
use genom_types::Record;
use serde_json::Value;

use crate::contract;
use crate::library::{Contents, Library};
use checker::Checker;
use inner::Inner;
use parts::Parts;

/// One instance of a component: its private copy of the library, its IDS, ports and remotes.
///
/// The library is closed when the component and its last frame are dropped; the threads that run
/// codels must have ended by then.
pub struct Component {
    inner: Arc<Inner>,
}

impl Component {
    /// Checks the library against the component of `plan`, and allocates the memory of one
    /// instance.
    ///
    /// `locate` formats a position in the `.gen` for messages, as file and line.
    ///
    /// # Errors
    /// All that is wrong: codels missing in the library, types or arguments without a layout or
    /// address, differences between the types in the library and in the description.
    pub fn load(
        library: Library,
        plan: &Plan,
        locate: &dyn Fn(Span) -> String,
    ) -> Result<Self, LoadErrors> {
        Self::make(library, plan, locate, true)
    }

    /// As [`load`](Self::load), for a library whose content was loaded with this plan before: types
    /// are not compared again.
    ///
    /// # Errors
    /// As for `load`, without differences.
    pub fn load_again(
        library: Library,
        plan: &Plan,
        locate: &dyn Fn(Span) -> String,
    ) -> Result<Self, LoadErrors> {
        Self::make(library, plan, locate, false)
    }

    /// Has the interpreter of this process load a script, as [`load`](Self::load) does a library. What
    /// the script does when it is run may take so long.
    ///
    /// # Errors
    /// As for `load`; or the process has no interpreter, or the script does not fit.
    pub fn load_script(
        script: Contents,
        plan: &Plan,
        within: Duration,
        locate: &dyn Fn(Span) -> String,
    ) -> Result<Self, LoadErrors> {
        let refuse = |errors| LoadErrors { library: script.path.clone(), errors };
        let model = plan.component();
        let language = genom_elf::languages::of(&script.path).unwrap_or_default();
        if model.lang != language {
            let (component, place, lang) = (&model.name, locate(model.span), &model.lang);
            return Err(refuse(vec![LoadError::Codels(format!(
                "its codels are in {language}, but component `{component}` ({place}) has lang \
                 \"{lang}\": say lang \"{language}\" there"
            ))]));
        }
        let own = genom_interpreter::own().filter(|own| own.language() == language);
        let Some(interpreter) = own else {
            return Err(refuse(vec![LoadError::NoInterpreter { language }]));
        };
        let given = interpreter
            .load(&script, plan, within, locate)
            .map_err(|errors| refuse(errors.into_iter().map(LoadError::Codels).collect()))?;
        Self::make(Library::of_script(script, given), plan, locate, false)
    }

    fn make(
        library: Library,
        plan: &Plan,
        locate: &dyn Fn(Span) -> String,
        compare: bool,
    ) -> Result<Self, LoadErrors> {
        let mut checker =
            Checker { specification: plan.specification(), locate, errors: Vec::new() };
        let parts = Parts::new(&mut checker, plan, &library);
        let mut errors = checker.errors;
        if compare && parts.is_some() {
            errors.extend(differences(&library, plan, locate));
        }
        let path = library.path().to_owned();
        let refuse = |errors| LoadErrors { library: path, errors };
        match parts {
            Some(parts) if errors.is_empty() => match parts.assemble(plan, library) {
                Some(inner) => Ok(Self { inner: Arc::new(inner) }),
                None => Err(refuse(vec![LoadError::NoClosures])),
            },
            _ => Err(refuse(errors)),
        }
    }

    /// Sets its name in the report of a crash; the first one counts.
    pub fn name_it(&self, instance: &str) {
        let _ = self.inner.instance.set(instance.to_owned());
    }

    /// What its library was loaded from, whatever the file holds by now; `None` if no copy of it was
    /// kept.
    #[must_use]
    pub fn contents(&self) -> Option<Contents> {
        self.inner.code.get().library.contents()
    }

    /// The library file, by the path it was requested with.
    #[must_use]
    pub fn library(&self) -> PathBuf {
        self.inner.code.get().library.path().to_owned()
    }
}

/// Differences between the library and the description.
fn differences(library: &Library, plan: &Plan, locate: &dyn Fn(Span) -> String) -> Vec<LoadError> {
    let report = contract::check(library, plan, locate);
    if let Some(why) = &report.unchecked {
        let path = library.path().display();
        tracing::info!("{path}: unchecked: {why}: nothing to compare with the .gen");
    }
    report.differences.into_iter().map(LoadError::Contract).collect()
}

impl Body for Component {
    fn frame(&self, owner: Owner) -> Box<dyn Frame> {
        Box::new(frame::BoundFrame::new(&self.inner, owner))
    }

    fn bind_out(&self, port: PortIx, element: Option<&str>, publisher: Option<Box<dyn Publisher>>) {
        self.inner.ports.bind_out(port, element, publisher);
    }

    fn bind_in(
        &self,
        port: PortIx,
        element: Option<&str>,
        subscription: Option<Box<dyn Subscription>>,
    ) {
        self.inner.ports.bind_in(port, element, subscription);
    }

    fn bind_remote(&self, remote: RemoteIx, call: Option<Box<dyn RemoteCall>>) {
        self.inner.remotes.bind(remote, call);
    }

    fn set_opener(&self, opener: Box<dyn Opener>) {
        self.inner.ports.set_opener(opener);
    }

    fn port_value(&self, port: PortIx, element: Option<&str>) -> Option<Value> {
        self.inner.ports.look(port, element, Record::to_json)
    }

    fn last_value(&self, port: PortIx, element: Option<&str>) -> Option<Record> {
        self.inner.ports.last(port, element)
    }

    fn port_message(&self, port: PortIx, element: Option<&str>) -> Option<Vec<u8>> {
        let message = |value: &Record| {
            let mut out = Vec::with_capacity(value.message_size());
            value.encode_message(&mut out).ok().map(|()| out)
        };
        self.inner.ports.look(port, element, message).flatten()
    }

    fn written(&self, port: PortIx) -> u64 {
        self.inner.ports.written(port)
    }

    fn damage(&self) -> Option<String> {
        self.inner.damage.get().cloned()
    }

    fn ids(&self) -> Option<Record> {
        self.inner.ids_in_c()
    }

    fn set_ids(&self, ids: &Record) {
        self.inner.set_ids(ids);
    }

    fn restore_port(&self, port: PortIx, element: Option<&str>, value: &Record) {
        self.inner.ports.restore(port, element, value);
    }

    fn write_port(&self, port: PortIx, value: &Record) {
        self.inner.ports.write(port, value);
    }
}
