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

/// Cyclone DDS for programs in C and C++, and the libraries that it loads.
const CYCLONEDDS: [&str; 8] = [
    "cyclonedds-dev",
    "cyclonedds-tools",
    "libcycloneddsidl0",
    "libddsc0debian",
    "libiceoryx-binding-c2",
    "libiceoryx-hoofs2",
    "libiceoryx-platform2",
    "libiceoryx-posh2",
];

/// Cyclone DDS in C, a peer that is not genomd, from Debian's packages.
#[derive(Clone, Debug)]
pub struct CycloneDds {
    usr: PathBuf,
}

impl CycloneDds {
    /// Unpacks it where it was not unpacked before.
    ///
    /// # Errors
    /// It cannot be fetched, for instance because this is no Debian.
    pub fn get() -> Result<Self, BuildError> {
        let place = made_once("cyclonedds", |place| unpack(place, "cyclonedds", &CYCLONEDDS))?;
        Ok(Self { usr: place.join("usr") })
    }

    /// The directory of its libraries, for `LD_LIBRARY_PATH`.
    #[must_use]
    pub fn libraries(&self) -> PathBuf {
        self.usr.join(multiarch("lib"))
    }

    /// Builds a program in C++, with the types of an IDL file beside it, in the directory `to`.
    ///
    /// # Errors
    /// A compiler says why.
    pub fn program(&self, source: &Path, types: &Path, to: &Path) -> Result<PathBuf, BuildError> {
        let libraries = self.libraries();
        let idlc = self.usr.join("bin/idlc");
        run(Command::new(idlc).arg(types).current_dir(to).env("LD_LIBRARY_PATH", &libraries))?;
        let include = |directory: &Path| format!("-I{}", directory.display());
        let includes = [
            include(&self.usr.join("include")),
            include(&self.usr.join(multiarch("include"))),
            include(to),
        ];
        let generated = to.join(types.with_extension("c").file_name().unwrap_or_default());
        let (object, program) = (generated.with_extension("o"), to.join("program"));
        run(Command::new("cc").args(&includes).arg("-c").arg(generated).arg("-o").arg(&object))?;
        run(Command::new("c++")
            .args(&includes)
            .args([source, &object])
            .arg("-o")
            .arg(&program)
            .arg(format!("-L{}", libraries.display()))
            .arg(format!("-Wl,-rpath-link,{}", libraries.display()))
            .arg("-lddsc"))?;
        Ok(program)
    }
}

/// Debian's directory for this architecture, below `lib` or `include`.
fn multiarch(directory: &str) -> String {
    format!("{directory}/{}-linux-gnu", std::env::consts::ARCH)
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
    let libraries = format!("usr/{}", multiarch("lib"));
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
