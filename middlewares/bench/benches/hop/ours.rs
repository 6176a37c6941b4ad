//! The backends of genomd, each in a place of its own.

use std::path::Path;
use std::sync::Arc;

use genom_bench::bare::ros2::DOMAIN;
use genom_middleware::Middleware;
use genom_ros2::Ros2;
use genom_shm::Shm;
use genom_zenoh::Zenoh;

/// Both processes use the same folder, which nothing else uses.
pub(crate) fn open(name: &str, place: &Path) -> Arc<dyn Middleware> {
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
        _ => {
            let domain = Some(DOMAIN);
            Ros2::open(&genom_ros2::Options { domain, ..Default::default() }).unwrap()
        }
    }
}
