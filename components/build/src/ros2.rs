//! ROS 2 Jazzy for tests: nodes, and Python types of packages.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{BuildError, Paths, python};

/// Its client library, its default middleware, some message packages, and what its generators of
/// types need.
const JAZZY: [&str; 8] = [
    "ros-jazzy-rclpy==7.1.6",
    "ros-jazzy-rmw-fastrtps-cpp==8.4.3",
    "ros-jazzy-std-msgs==5.3.6",
    "ros-jazzy-geometry-msgs==5.3.6",
    "ros-jazzy-std-srvs==5.3.6",
    "ros-jazzy-test-msgs==2.0.3",
    "ros-jazzy-diagnostic-msgs==5.3.6",
    "catkin-pkg==1.1.1",
];

/// A process that runs node `peer` in the given domain, for [`Peer`](crate::peer::Peer);
/// `ros2/node.py` lists its commands. `types` is a result of [`types`].
///
/// # Errors
/// ROS cannot be installed.
pub fn node(domain: u32, types: Option<&Path>) -> Result<Command, BuildError> {
    script(&Paths::of_workspace()?.root.join("components/build/ros2/node.py"), domain, types)
}

/// A process that runs a script with `rclpy` in the given domain. `types` is a result of [`types`].
///
/// # Errors
/// ROS cannot be installed.
pub fn script(file: &Path, domain: u32, types: Option<&Path>) -> Result<Command, BuildError> {
    let mut command = Command::new(python::environment(&JAZZY)?);
    command
        .arg(file)
        .env("ROS_DOMAIN_ID", domain.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .env("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
        .env("ROS_LOG_DIR", std::env::temp_dir())
        // Shared memory would remain after a peer is killed.
        .env("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4")
        .env_remove("ROS_LOCALHOST_ONLY");
    if let Some(types) = types {
        command.env("PYTHONPATH", types);
    }
    Ok(command)
}

/// Builds the Python types of a ROS package with ROS's own generators. Returns a `PYTHONPATH`.
///
/// # Errors
/// ROS cannot be installed, this is not a package, or there is no compiler.
pub fn types(package: &Path) -> Result<PathBuf, BuildError> {
    let script = Paths::of_workspace()?.root.join("components/build/ros2/build_types.py");
    let mut hash = DefaultHasher::new();
    digest(&script, &mut hash)?;
    digest(package, &mut hash)?;
    let python = python::environment(&JAZZY)?;
    python::made_once(&format!("ros2-types-{:016x}", hash.finish()), |place| {
        python::run(Command::new(&python).arg(&script).arg(package).arg(place))
    })
}

/// Hashes the names and contents of all files.
fn digest(path: &Path, hash: &mut DefaultHasher) -> Result<(), BuildError> {
    path.file_name().hash(hash);
    if !path.is_dir() {
        std::fs::read(path).map_err(BuildError::file(path))?.hash(hash);
        return Ok(());
    }
    let entries = std::fs::read_dir(path).map_err(BuildError::file(path))?;
    let mut all: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    all.sort();
    all.iter().try_for_each(|path| digest(path, hash))
}
