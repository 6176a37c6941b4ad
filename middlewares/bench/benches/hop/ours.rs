//! The backends of genomd, each in a place of its own.

use std::path::Path;
use std::sync::Arc;

use genom_bench::bare::ros2::DOMAIN;
use genom_middleware::Middleware;
use genom_ros2::{Rmw, Ros2, ZenohOptions};
use genom_shm::Shm;
use genom_zenoh::Zenoh;

/// ROS 2 over zenoh.
pub(crate) const RMW_ZENOH: &str = "rmw_zenoh";

/// The middleware that carries another one, or itself.
pub(crate) fn carrier(name: &str) -> &str {
    if name == RMW_ZENOH { "zenoh" } else { name }
}

/// Both processes use the same folder, which nothing else uses.
pub(crate) fn open(name: &str, place: &Path, reads: bool) -> Arc<dyn Middleware> {
    match name {
        "shm" => {
            let name = place.file_name().unwrap_or_default().to_string_lossy().replace('.', "");
            let (prefix, root) = (Some(format!("bench{name}_")), Some(place.join("ours")));
            let options = genom_shm::Options { prefix, root, ..Default::default() };
            Arc::new(Shm::open(options).unwrap())
        }
        "zenoh" => {
            let rendezvous = Some(place.join("ours"));
            Zenoh::open(&genom_zenoh::Options { rendezvous, ..Default::default() }).unwrap()
        }
        // By a socket between the two, as bare zenoh.
        RMW_ZENOH => {
            let socket = vec![format!("unixsock-stream/{}", place.join("ours.sock").display())];
            let (connect, listen) = if reads { (socket, vec![]) } else { (vec![], socket) };
            let zenoh =
                ZenohOptions { router: false, connect: Some(connect), listen: Some(listen) };
            let options = genom_ros2::Options {
                rmw: Some(Rmw::Zenoh),
                domain: Some(DOMAIN),
                zenoh,
                ..Default::default()
            };
            Ros2::open(&options).unwrap()
        }
        _ => {
            let rmw = Some(Rmw::Dds);
            let domain = Some(DOMAIN);
            Ros2::open(&genom_ros2::Options { rmw, domain, ..Default::default() }).unwrap()
        }
    }
}
