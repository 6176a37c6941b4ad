//! `genomctl ros2-package`: writes the messages, services and actions of components as ROS 2
//! packages. No daemon.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::io::{self, IsTerminal as _, Write as _};
use std::path::{Path, PathBuf};

use genom_description::diagnostic::Diagnostic;
use genom_description::diagnostic::render::human;
use genom_description::model::{Component, Direction, ServiceKind, Span, Specification};
use genom_description::source::Disk;
use genom_description_tools::navigate::Navigator;
use genom_rosidl::{
    Interface, Library, MapError, Mapper, MasqueradeError, Message, Ours, Packages, Place, TypeName,
};
use genom_types::ScopedName;
use serde_json::json;

use crate::failure::Failure;
use crate::reading::Reading;
use crate::session::Session;

/// Marks packages that this program wrote, and may overwrite.
const MARK: &str = "made by genomctl ros2-package";

/// Write ROS 2 packages with the types, services and activities of components.
///
/// DIRECTORY receives one folder per package, to be built with colcon: the .msg, .srv and .action
/// files of what the ROS 2 backend transmits. genomd itself does not need them. Each interface is
/// printed with its type hash.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .gen files, read in order as one specification, followed by the directory.
    #[arg(required = true, num_args = 2.., value_names = ["FILE.gen", "DIRECTORY"])]
    paths: Vec<PathBuf>,
    /// One component [default: all].
    #[arg(long, value_name = "NAME")]
    component: Option<String>,
    /// A type or service that is shown under the name of a ROS one, in addition to those of
    /// `#pragma masquerade ros2`; may be repeated.
    #[arg(long, value_name = "::SCOPE::NAME=PACKAGE/KIND/TYPE")]
    masquerade: Vec<String>,
    #[command(flatten)]
    reading: Reading,
}

/// Something that has no equivalent in ROS, and where it is.
struct Refusal {
    span: Span,
    message: String,
    help: Option<String>,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let Some((directory, files)) = args.paths.split_last() else { return Ok(()) };
    // Prints diagnostics of the descriptions, including missing files.
    args.reading.read_sound(files)?;
    let navigator = Navigator::read(files, &args.reading.options(), &Disk);
    let specification = &navigator.analysis.specification;
    let components = chosen(specification, args.component.as_deref())?;
    let mut masquerades = pragmas(specification);
    for given in &args.masquerade {
        let (ours, theirs) = masquerade(given)?;
        masquerades.insert(ours, theirs);
    }
    let library =
        Library::with_ament(Vec::new(), std::env::var("AMENT_PREFIX_PATH").ok().as_deref());
    let (interfaces, refusals) = map(&navigator, &components, masquerades, &library);
    if !refusals.is_empty() {
        let errors = refusals.len();
        let drawn = refusals.into_iter().map(|refusal| {
            let error = Diagnostic::error("ros2", refusal.span, refusal.message);
            match refusal.help {
                Some(help) => error.help(help),
                None => error,
            }
        });
        let drawn: Vec<_> = drawn.collect();
        let told = human(&drawn, &navigator.analysis.sources, io::stderr().is_terminal());
        io::stderr().lock().write_all(told.as_bytes())?;
        return Err(Failure::Description { errors, warnings: 0 });
    }
    let names: Vec<_> = files.iter().filter_map(|file| file.file_name()).collect();
    let source = names.iter().map(|name| name.to_string_lossy()).collect::<Vec<_>>().join(", ");
    let packages = Packages::new(&interfaces, &source)
        .map_err(|error| Failure::refused("ros2-package", error.to_string()))?;
    write(directory, &packages)?;
    let hashed = hashes(&interfaces, &library)?;
    if session.json {
        let hashed: BTreeMap<_, _> = hashed.into_iter().collect();
        let reply = json!({"packages": packages.names, "interfaces": hashed});
        return session.print(&format!("{reply}\n"));
    }
    session.print(&render(&hashed))
}

fn chosen<'a>(
    specification: &'a Specification,
    name: Option<&str>,
) -> Result<Vec<&'a Component>, Failure> {
    let all = &specification.components;
    let chosen: Vec<_> =
        all.iter().filter(|component| name.is_none_or(|name| component.name == name)).collect();
    if chosen.is_empty() {
        let known: Vec<_> = all.iter().map(|component| format!("`{}`", component.name)).collect();
        let message = format!(
            "there is no component{}; those described are: {}",
            name.map(|name| format!(" `{name}`")).unwrap_or_default(),
            if known.is_empty() { "none".to_owned() } else { known.join(", ") }
        );
        return Err(Failure::refused("ros2-package", message));
    }
    Ok(chosen)
}

/// The names given by `#pragma masquerade ros2`.
fn pragmas(specification: &Specification) -> BTreeMap<String, TypeName> {
    let ros2 = specification.masquerades.iter().filter(|one| one.template == "ros2");
    let read = ros2.filter_map(|one| Some((one.name.to_string(), TypeName::parse(&one.data)?)));
    read.collect()
}

fn masquerade(given: &str) -> Result<(String, TypeName), Failure> {
    let read = given.split_once('=').and_then(|(ours, theirs)| {
        Some((ours, TypeName::parse(theirs)?)).filter(|(ours, _)| !ours.is_empty())
    });
    let (ours, theirs) = read.ok_or_else(|| {
        Failure::usage(
            format!("`{given}` is no masquerade"),
            "write for instance --masquerade ::demo::pose=geometry_msgs/msg/Pose",
        )
    })?;
    Ok((format!("::{}", ours.trim_start_matches("::")), theirs))
}

/// All interfaces of these components, and what has no equivalent.
fn map(
    navigator: &Navigator,
    components: &[&Component],
    masquerades: BTreeMap<String, TypeName>,
    library: &Library,
) -> (Vec<Interface>, Vec<Refusal>) {
    let specification = &navigator.analysis.specification;
    let types = &*specification.types;
    let ours = Ours { masquerades: &masquerades, library };
    let mut mapper = Mapper::new(types, masquerades.clone());
    let mut refusals: Vec<Refusal> = Vec::new();
    for component in components {
        for port in &component.ports {
            let foreign = genom_rosidl::masqueraded(types, port.ty, &masquerades);
            let fits = foreign.map(|foreign| ours.message((types, port.ty), foreign)).transpose();
            refusals
                .extend(fits.err().map(|error| refused(navigator, component, port.span, error)));
            let mapped = mapper.port(port.ty).map_err(MasqueradeError::Map);
            let wrong = mapped.err();
            refusals.extend(wrong.map(|error| refused(navigator, component, port.span, error)));
        }
        for service in &component.services {
            let name = component.scope().join(&service.name);
            let types_of = ((types, service.input), (types, service.output));
            let activity = service.kind == ServiceKind::Activity;
            let mapped = match (masquerades.get(&name.to_string()), activity) {
                (Some(foreign), false) => {
                    ours.service(&name.to_string(), types_of, foreign).map(|_| ())
                }
                (Some(foreign), true) => {
                    ours.action(&name.to_string(), types_of, foreign).map(|_| ())
                }
                (None, _) => {
                    let folder = if activity { "action" } else { "srv" };
                    let ros = genom_rosidl::service(types, service.input, &service.name, folder);
                    let mapped = if activity {
                        mapper.action(&ros, service.input, service.output)
                    } else {
                        mapper.service(&ros, service.input, service.output)
                    };
                    mapped.map_err(MasqueradeError::Map)
                }
            };
            let wrong = mapped.err();
            refusals.extend(wrong.map(|error| refused(navigator, component, service.span, error)));
        }
    }
    refusals.sort_by_key(|refusal| (refusal.span.file, refusal.span.start));
    refusals.dedup_by(|a, b| a.span == b.span && a.message == b.message);
    (mapper.finish(), refusals)
}

/// Reports a refusal at the member or type itself if it has a position, otherwise where it is used.
fn refused(
    navigator: &Navigator,
    component: &Component,
    user: Span,
    error: MasqueradeError,
) -> Refusal {
    let MasqueradeError::Map(MapError { place, problem }) = error else {
        return Refusal { span: user, message: error.to_string(), help: None };
    };
    let span = match &place {
        Place::Type(name) => navigator.declared(name, None),
        Place::Member(of, name) => navigator
            .declared(of, Some(name))
            .or_else(|| parameter(component, of, name))
            .or_else(|| navigator.declared(of, None)),
        Place::Nameless => None,
    };
    let message = format!("{place}: {problem}");
    Refusal { span: span.unwrap_or(user), message, help: Some(problem.help().to_owned()) }
}

/// Position of a parameter, which is a member of `::component::service::input` or `output`.
fn parameter(component: &Component, of: &ScopedName, name: &str) -> Option<Span> {
    let [owner, service, part] = of.segments() else { return None };
    if *owner != component.name {
        return None;
    }
    let service = component.services.iter().find(|one| one.name == *service)?;
    let goes = |direction| match direction {
        Direction::In => part == "input",
        Direction::Out => part == "output",
        Direction::InOut => true,
    };
    let found = service.parameters.iter().find(|one| one.name == name && goes(one.direction))?;
    Some(found.span)
}

/// The interfaces with their hashes.
fn hashes(interfaces: &[Interface], library: &Library) -> Result<Vec<(String, String)>, Failure> {
    let made: BTreeMap<&TypeName, &Message> = interfaces
        .iter()
        .filter_map(|interface| match interface {
            Interface::Message(message) => Some((&message.name, message)),
            _ => None,
        })
        .collect();
    let find = |name: &TypeName| match made.get(name) {
        Some(message) => Some((*message).clone()),
        None => library.message(name).ok(),
    };
    let one = |interface: &Interface| {
        let hash = genom_rosidl::hash(interface, &find)
            .map_err(|error| Failure::refused("ros2-package", error.to_string()))?;
        Ok((interface.name().to_string(), hash))
    };
    interfaces.iter().map(one).collect()
}

fn render(hashed: &[(String, String)]) -> String {
    let width = hashed.iter().map(|(name, _)| name.len()).max().unwrap_or_default();
    let mut out = String::new();
    for (name, hash) in hashed {
        _ = writeln!(out, "{name:width$}  {hash}");
    }
    out
}

/// Writes the packages; replaces only packages written by this program.
fn write(directory: &Path, packages: &Packages) -> Result<(), Failure> {
    for name in &packages.names {
        let package = directory.join(name);
        let told = |error: io::Error| {
            io::Error::new(error.kind(), format!("{}: {error}", package.display()))
        };
        match fs::read_to_string(package.join("package.xml")) {
            Ok(text) if !text.contains(MARK) => {
                let message = format!(
                    "{} is a package of somebody else's: name another directory",
                    package.display()
                );
                return Err(Failure::refused("ros2-package", message));
            }
            Ok(_) => {
                for folder in ["msg", "srv", "action"] {
                    let folder = package.join(folder);
                    if folder.is_dir() {
                        fs::remove_dir_all(folder).map_err(told)?;
                    }
                }
            }
            Err(_) => {}
        }
    }
    for (path, text) in &packages.files {
        let path = directory.join(path);
        let told =
            |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(told)?;
        }
        fs::write(&path, text).map_err(told)?;
    }
    Ok(())
}
