//! Other users cannot change what a user has in shared memory.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "helpers of tests fail them"
)]

mod world;

use std::fs::{self, Permissions};
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _, chown};
use std::path::{Path, PathBuf};

use genom_conformance::World;
use genom_conformance::samples::state;
use genom_middleware::{Address, PortSpec, Ports};
use genom_shm::{Options, Shm, ShmError};

use world::ShmWorld;

/// A user that every system has and that owns nothing.
const NOBODY: u32 = 65534;

fn refused(world: &ShmWorld) -> ShmError {
    Shm::open(world.options()).map(drop).expect_err("refused")
}

/// All files of a world.
fn all(world: &ShmWorld) -> Vec<PathBuf> {
    let shared = Path::new("/dev/shm").read_dir().unwrap().flatten().map(|entry| entry.path());
    let own = |path: &PathBuf| path.to_string_lossy().contains(world.prefix());
    shared.filter(own).chain(world.leftovers().into_iter().map(PathBuf::from)).collect()
}

#[test]
fn no_other_user_can_read_or_write_anything() {
    let world = ShmWorld::new();
    let shm = world.open();
    let _port = shm.publisher(&PortSpec::new(&Address::new("demo", "position"), &state())).unwrap();
    assert_eq!(fs::metadata(world.root()).unwrap().mode() & 0o777, 0o700);
    for path in all(&world).iter().filter(|path| path.starts_with("/dev/shm")) {
        let mode = fs::metadata(path).unwrap().mode();
        assert_eq!(mode & 0o077, 0, "{} {mode:o}", path.display());
    }
}

#[test]
fn a_folder_that_others_may_change_is_refused_with_the_way_out() {
    let world = ShmWorld::new();
    fs::create_dir(world.root()).unwrap();
    fs::set_permissions(world.root(), Permissions::from_mode(0o777)).unwrap();
    let told = refused(&world);
    let path = world.root().to_owned();
    assert_eq!(told, ShmError::Open { path, mode: 0o777 });
    assert!(told.to_string().contains("`chmod go-w "), "{told}");
    fs::set_permissions(world.root(), Permissions::from_mode(0o755)).unwrap();
    drop(world.open());
}

#[test]
fn what_belongs_to_another_user_is_refused_with_the_way_out() {
    let world = ShmWorld::new();
    let me = fs::metadata("/proc/self").unwrap().uid();
    if me != 0 {
        // Only the superuser could create a file of another user, so the test uses an existing one.
        let options = Options { root: Some("/usr".into()), ..world.options() };
        let told = Shm::open(options).map(drop).expect_err("refused");
        assert!(matches!(told, ShmError::Foreign { owner: 0, .. }), "{told}");
        return;
    }
    fs::create_dir(world.root()).unwrap();
    chown(world.root(), Some(NOBODY), None).unwrap();
    let told = refused(&world);
    assert!(matches!(told, ShmError::Foreign { owner: NOBODY, user: 0, .. }), "{told}");
    assert!(told.to_string().contains("set `root` and `prefix` in [backends.shm]"), "{told}");
    chown(world.root(), Some(0), None).unwrap();
    drop(world.open());
    let counter = all(&world).into_iter().find(|path| path.starts_with("/dev/shm")).unwrap();
    chown(&counter, Some(NOBODY), None).unwrap();
    let told = refused(&world).to_string();
    assert!(told.starts_with(&format!("{} belongs to user 65534", counter.display())), "{told}");
}

#[test]
fn each_user_has_a_folder_and_a_prefix_of_their_own() {
    let me = fs::metadata("/proc/self").unwrap().uid();
    assert_eq!(genom_shm::default_prefix(), format!("genomd_{me}_"));
    let root = genom_shm::default_root();
    let own = [format!("/run/user/{me}/genomd/iceoryx2"), format!("/dev/shm/genomd-{me}/iceoryx2")];
    assert!(own.iter().any(|own| root == Path::new(own)), "{}", root.display());
}
