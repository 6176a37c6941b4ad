//! The same middleware through a gateway: one process more on each side.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::Arc;

use genom_gateway::{Proxy, Reach, Server};
use genom_middleware::Middleware;

use crate::ours;

/// Precedes what a gateway is started with.
pub(crate) const GATEWAY: &str = "--gateway-of";

/// Folder of the reading side's gateway.
const READS: &str = "reads";

pub(crate) struct Through {
    proxy: Option<Proxy>,
    gateway: Child,
}

impl Through {
    /// Starts a gateway for one side.
    pub(crate) fn open(name: &'static str, place: &Path, reads: bool) -> Self {
        let side = place.join(if reads { READS } else { "writes" });
        let program = std::env::current_exe().unwrap();
        let gateway = Command::new(program).arg(GATEWAY).arg(name).arg(place).arg(&side).spawn();
        let gateway = gateway.unwrap();
        let proxy = Some(Proxy::open(name, Reach::new(&side)).unwrap());
        Self { proxy, gateway }
    }
}

impl Through {
    pub(crate) fn ours(&self) -> &dyn Middleware {
        self.proxy.as_ref().unwrap()
    }
}

impl Drop for Through {
    fn drop(&mut self) {
        // The gateway ends when nobody uses it any more.
        self.proxy = None;
        self.gateway.wait().unwrap();
    }
}

/// The process of a gateway.
pub(crate) fn serve(name: &str, place: &Path, side: &Path) -> Result<(), Box<dyn Error>> {
    let open: Arc<dyn Middleware> = ours::open(name, place, side.ends_with(READS));
    let door: PathBuf = Reach::new(side).door(name);
    std::fs::create_dir_all(door.parent().unwrap())?;
    let listening = Server::listen(&door, open)?;
    listening.unused()();
    Ok(())
}
