//! The same middleware through a gateway: one process more on each side.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::Arc;

use genom_bench::pair::{Receive, Send};
use genom_gateway::{Proxy, Reach, Server};
use genom_middleware::Middleware;

use crate::{Backend, ros2, zenoh};

/// Precedes what a gateway is started with.
pub(crate) const GATEWAY: &str = "--gateway-of";

pub(crate) struct Through {
    bare: Box<dyn Backend>,
    proxy: Option<Proxy>,
    gateway: Child,
}

impl Through {
    /// Starts a gateway for one side.
    pub(crate) fn open(
        name: &'static str,
        place: &Path,
        reads: bool,
        bare: Box<dyn Backend>,
    ) -> Self {
        let side = place.join(if reads { "reads" } else { "writes" });
        let program = std::env::current_exe().unwrap();
        let gateway = Command::new(program).arg(GATEWAY).arg(name).arg(place).arg(&side).spawn();
        let gateway = gateway.unwrap();
        let proxy = Some(Proxy::open(name, Reach::new(&side)).unwrap());
        Self { bare, proxy, gateway }
    }
}

impl Backend for Through {
    fn writer(&self, bytes: usize) -> Box<dyn Send> {
        self.bare.writer(bytes)
    }

    fn reader(&self, bytes: usize) -> Box<dyn Receive> {
        self.bare.reader(bytes)
    }

    fn ours(&self) -> &dyn Middleware {
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
    let open: Arc<dyn Middleware> = match name {
        "zenoh" => zenoh::ours(place),
        _ => ros2::ours(),
    };
    let socket: PathBuf = Reach::new(side).socket(name);
    std::fs::create_dir_all(socket.parent().unwrap())?;
    let listening = Server::listen(&socket, open)?;
    listening.unused()();
    Ok(())
}
