//! A script without genomd: for measurements of this crate.

use serde_json::Value as Json;

use crate::foreign::{self, Context, Log, Memory, Scripts as _};
use crate::loader::Loader;

/// A codel of a script, called as genomd calls it.
#[derive(Debug)]
pub struct Called {
    function: foreign::Function,
    memory: Memory,
    context: Context,
    /// The event of errors.
    unkex: usize,
    _loader: Loader,
}

impl Called {
    /// Loads a request, and finds one of its codels; its memory has that many bytes.
    ///
    /// # Errors
    /// The script is refused.
    pub fn new(request: &Json, codel: &str, memory: usize) -> Result<Self, String> {
        let loader = Loader::new(Log::standard());
        let answer = loader.load(request.to_string().as_bytes());
        let answer: Json = serde_json::from_slice(&answer).map_err(|why| why.to_string())?;
        let function = loader.function(codel).ok_or_else(|| answer.to_string())?;
        let unkex = loader.unkex().unwrap_or_default();
        let (memory, context) = (Memory::new(memory), Context::default());
        Ok(Self { function, memory, context, unkex, _loader: loader })
    }

    /// Calls the codel, which has one parameter, the address of its memory; returns whether it returned
    /// an event that is no error.
    pub fn with_memory(&mut self) -> bool {
        let event = foreign::codel(self.function, Some(self.memory.at()), self.context.at());
        event.is_some_and(|event| event.address() != self.unkex)
    }

    /// Calls the codel, which has no parameters.
    pub fn without_arguments(&mut self) -> bool {
        let event = foreign::codel(self.function, None, self.context.at());
        event.is_some_and(|event| event.address() != self.unkex)
    }
}
