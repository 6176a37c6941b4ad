//! How long a script may take when it is run to define its codels.

use std::time::{Duration, Instant};

use mlua::{Error, HookTriggers, Lua, Result, VmState};

/// Instructions between two looks at the clock.
const SELDOM: u32 = 10_000;

/// Until it is dropped, what runs in a state is ended by an error when its time is over.
pub(crate) struct Limit<'a>(&'a Lua);

impl<'a> Limit<'a> {
    /// The limit counts instructions of Lua, also of coroutines that begin under it: a function of
    /// the system that waits is not ended.
    pub(crate) fn set(lua: &'a Lua, seconds: f64) -> Result<Self> {
        let allowed = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        let began = Instant::now();
        lua.set_global_hook(HookTriggers::new().every_nth_instruction(SELDOM), move |lua, _| {
            if began.elapsed() < allowed {
                return Ok(VmState::Continue);
            }
            // Where `pcall` catches the error, the next instruction raises it again.
            lua.set_global_hook(HookTriggers::new().every_nth_instruction(1), move |_, _| {
                Err(late(seconds))
            })?;
            Err(late(seconds))
        })?;
        Ok(Self(lua))
    }
}

impl Drop for Limit<'_> {
    fn drop(&mut self) {
        self.0.remove_global_hook();
        self.0.remove_hook();
    }
}

fn late(seconds: f64) -> Error {
    Error::runtime(format!(
        "the script is here after {seconds} s (start_timeout), and has not run through: what takes \
         longer, or goes on, belongs into a codel"
    ))
}
