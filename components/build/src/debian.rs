//! Programs that a machine may lack, from Debian's packages, unpacked under the target directory: a
//! test installs nothing on the machine, and needs no rights.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::python::{made_once, run};
use crate::{BuildError, Paths};

/// Programs that builds with autotools run.
const AUTOTOOLS: [&str; 5] = ["autoreconf", "automake", "libtoolize", "m4", "pkg-config"];

/// Their packages, with the libraries that they load.
const PACKAGES: [&str; 10] = [
    "autoconf",
    "automake",
    "autotools-dev",
    "libltdl-dev",
    "libpkgconf3",
    "libsigsegv2",
    "libtool",
    "m4",
    "pkgconf",
    "pkgconf-bin",
];

/// The `PATH` under which autoconf, automake, libtool and pkg-config are found: that of this
/// process if they are installed, else with a directory before it into which Debian's packages were
/// unpacked.
///
/// # Errors
/// They are not installed and cannot be fetched, for instance because this is no Debian.
pub fn autotools() -> Result<OsString, BuildError> {
    let usual = std::env::var_os("PATH").unwrap_or_default();
    let present = |name: &&str| std::env::split_paths(&usual).any(|path| path.join(name).is_file());
    if AUTOTOOLS.iter().all(present) {
        return Ok(usual);
    }
    let place = made_once("autotools", |place| {
        unpack(place, "autotools", &PACKAGES)?;
        relocate(place).map_err(BuildError::file(place))
    })?;
    let directories = std::iter::once(place.join("usr/bin")).chain(std::env::split_paths(&usual));
    Ok(std::env::join_paths(directories).unwrap_or(usual.clone()))
}

/// The program of Spin, a model checker: the one that is installed, else that of Debian's package.
///
/// # Errors
/// It is not installed and cannot be fetched, for instance because this is no Debian.
pub fn spin() -> Result<PathBuf, BuildError> {
    let usual = std::env::var_os("PATH").unwrap_or_default();
    let mut places = std::env::split_paths(&usual).map(|path| path.join("spin"));
    if let Some(installed) = places.find(|path| path.is_file()) {
        return Ok(installed);
    }
    Ok(made_once("spin", |place| unpack(place, "spin", &["spin"]))?.join("usr/bin/spin"))
}

/// Fetches packages with the lists of an own apt, which needs no rights, and unpacks them.
fn unpack(place: &Path, name: &str, packages: &[&str]) -> Result<(), BuildError> {
    let paths = Paths::of_workspace()?;
    let own = paths.target.join("python").join(name).join("apt");
    for directory in ["lists/partial", "cache/archives/partial", "packages"] {
        let directory = own.join(directory);
        fs::create_dir_all(&directory).map_err(BuildError::file(&directory))?;
    }
    let apt = || {
        let mut command = Command::new("apt-get");
        command.current_dir(own.join("packages"));
        for (name, value) in [("Dir::State::lists", "lists"), ("Dir::Cache", "cache")] {
            command.arg("-o").arg(format!("{name}={}", own.join(value).display()));
        }
        command.args(["-o", "Debug::NoLocking=1", "-o", "APT::Sandbox::User=", "-qq"]);
        command
    };
    run(apt().arg("update"))?;
    run(apt().arg("download").args(packages))?;
    for package in list(&own.join("packages"))? {
        run(Command::new("dpkg-deb").arg("-x").arg(package).arg(place))?;
    }
    Ok(())
}

fn list(directory: &Path) -> Result<Vec<PathBuf>, BuildError> {
    let entries = fs::read_dir(directory)
        .and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect::<Result<_, _>>());
    entries.map_err(BuildError::file(directory))
}

/// The scripts name their data by absolute paths, and automake only by its version.
fn relocate(place: &Path) -> io::Result<()> {
    let (bin, share) = (place.join("usr/bin"), place.join("usr/share"));
    let data =
        ["autoconf", "automake-1.16", "aclocal-1.16", "libtool"].map(|name| share.join(name));
    let mut open: Vec<PathBuf> = data.into_iter().chain([bin.clone()]).collect();
    while let Some(path) = open.pop() {
        if path.is_symlink() {
            continue;
        }
        if path.is_dir() {
            for entry in fs::read_dir(&path)? {
                open.push(entry?.path());
            }
        } else if let Ok(text) = fs::read_to_string(&path)
            && (text.contains("/usr/share/") || text.contains("'/usr/bin/"))
        {
            let text = text.replace("/usr/share/", &format!("{}/", share.display()));
            fs::write(&path, text.replace("'/usr/bin/", &format!("'{}/", bin.display())))?;
        }
    }
    for name in ["automake", "aclocal"] {
        let link = bin.join(name);
        if !link.exists() {
            symlink(format!("{name}-1.16"), link)?;
        }
    }
    let libraries = format!("usr/lib/{}-linux-gnu", std::env::consts::ARCH);
    for name in ["m4", "pkgconf"] {
        let (program, real) = (bin.join(name), bin.join(format!("{name}.real")));
        fs::rename(&program, &real)?;
        let script = format!(
            "#!/bin/sh\nLD_LIBRARY_PATH={} exec {} \"$@\"\n",
            place.join(&libraries).display(),
            real.display()
        );
        fs::write(&program, script)?;
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755))?;
    }
    Ok(())
}
