//! Interprets the result of a codel: an event, an exception, or an error.

use std::ffi::c_char;

use genom_runtime::body::{EventId, Returned};
use serde_json::Value;

use super::codel::Prepared;
use super::frame::BoundFrame;
use super::inner::Meant;
use super::last::Last;
use super::zones::MemoryCheck;
use crate::context::Context;
use crate::detail::UNKEX;
use crate::events::text;
use crate::ffi::Thrown;

impl BoundFrame {
    /// Interprets the pointer that a codel returned.
    #[inline]
    pub(super) fn understand(
        &mut self,
        event: *const c_char,
        codel: &Prepared,
        context: &Context,
    ) -> Returned {
        if event.is_null() {
            self.last = Last::Plain;
            return self.rested(codel).unwrap_or(Returned::Ok);
        }
        let Some(id) = self.cache.get(event) else { return self.read(event, codel, context) };
        self.meant(id, event, codel, context)
    }

    /// Handles an event that is not cached, because it is new or its text may be overwritten.
    #[cold]
    fn read(&mut self, event: *const c_char, codel: &Prepared, context: &Context) -> Returned {
        let library = &self.inner.code.get().library;
        let constant = library.is_constant(event as usize);
        // The runner of a script has said where its events are. Others are those of the host, which
        // ports and remotes returned.
        let foreign =
            library.is_script() && !constant && !self.inner.shared.events.get().is_given(event);
        let known = constant || library.contains(event as usize);
        let Some(text) = (if foreign { None } else { text(event, known) }) else {
            tracing::error!("codel {} returned {event:p}, where no event is", codel.name);
            return self.fail(format!("{} returned {event:p}, where no event is", codel.name));
        };
        if library.is_script() && text == UNKEX.as_bytes() {
            let size = context.take_detail(event, text, &mut self.detail);
            let detail =
                size.and_then(|size| self.inner.details.to_json(UNKEX, &self.detail, size));
            let what = detail.as_ref().and_then(|detail| detail["what"].as_str());
            // As with an exception that escapes from a codel in C++.
            let what = what.unwrap_or_default().to_owned();
            return self.rested(codel).unwrap_or_else(|| self.fail(what));
        }
        let Some(id) = self.inner.shared.events.get().id(text) else {
            return self.rested(codel).unwrap_or_else(|| self.unknown(event, text, context));
        };
        if constant {
            self.cache.note(event, id);
        }
        self.meant(id, event, codel, context)
    }

    /// Handles an event of the plan.
    #[inline]
    fn meant(
        &mut self,
        id: EventId,
        event: *const c_char,
        codel: &Prepared,
        context: &Context,
    ) -> Returned {
        let everything = Meant { exception: true, rests: true };
        let meant = self.inner.meant.get(usize::from(id.0)).copied().unwrap_or(everything);
        if (meant.rests || self.check == MemoryCheck::EachCodel)
            && let Some(failed) = self.rested(codel)
        {
            return failed;
        }
        self.last = if meant.exception { self.detailed(event, id, context) } else { Last::Plain };
        Returned::Event(id)
    }

    /// After a codel paused or ended: an error if something wrote past its memory.
    #[inline]
    fn rested(&mut self, codel: &Prepared) -> Option<Returned> {
        match self.check {
            MemoryCheck::Pauses if self.watched.is_whole_nearby() => None,
            MemoryCheck::Off => None,
            _ => self.overwritten(codel),
        }
    }

    #[cold]
    fn overwritten(&mut self, codel: &Prepared) -> Option<Returned> {
        let written = self.watched.take_written()?;
        let told = format!("codel {} wrote {written}", codel.name);
        tracing::error!(
            "{}: {told}, or codels beside it did; its memory may be wrong from here on",
            self.inner.code.get().library.path().display()
        );
        let _ = self.inner.damage.set(told.clone());
        Some(self.fail(told))
    }

    /// Keeps the detail of an exception of the plan.
    fn detailed(&mut self, event: *const c_char, id: EventId, context: &Context) -> Last {
        let name = self.inner.events.get(usize::from(id.0)).map_or("", String::as_str);
        let found = context.take_detail(event, name.as_bytes(), &mut self.detail);
        let Some(size) = found else { return Last::Plain };
        if self.inner.details.is_plain(name) {
            return Last::Detailed(id, size);
        }
        // Converted now, since what it points to may be gone when the runtime asks.
        self.inner.details.to_json(name, &self.detail, size).map_or(Last::Plain, Last::Told)
    }

    #[cold]
    fn unknown(&mut self, event: *const c_char, text: &[u8], context: &Context) -> Returned {
        let name = String::from_utf8_lossy(text).into_owned();
        let size = context.take_detail(event, text, &mut self.detail);
        let detail = size.and_then(|size| self.inner.details.to_json(&name, &self.detail, size));
        self.last = Last::Unknown(name, detail);
        Returned::Unknown
    }

    /// No event was returned: becomes `genom::unkex`, with a message as its detail.
    #[cold]
    pub(super) fn fail(&mut self, what: String) -> Returned {
        self.last = Last::Failed(what);
        Returned::Failed
    }

    /// A codel in C++ threw a declared exception, or one of the run time.
    #[cold]
    pub(super) fn thrown(&mut self, name: String, detail: Option<Value>) -> Returned {
        match self.inner.shared.events.get().id(name.as_bytes()) {
            Some(id) => {
                self.last = detail.map_or(Last::Plain, Last::Told);
                Returned::Event(id)
            }
            None => {
                self.last = Last::Unknown(name, detail);
                Returned::Unknown
            }
        }
    }

    #[cold]
    pub(super) fn escaped(&mut self, codel: &str, how: Thrown) -> Returned {
        let text = self.what.iter().take_while(|byte| **byte != 0).copied().collect::<Vec<_>>();
        let text = String::from_utf8_lossy(&text).into_owned();
        match how {
            Thrown::Exception => tracing::warn!("codel {codel}: a C++ exception escaped: {text}"),
            Thrown::Left => tracing::error!("codel {codel} ended early: {text}"),
        }
        self.fail(text)
    }
}
