//! Packages that ROS can build: folders with `package.xml`, `CMakeLists.txt` and interfaces.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use crate::interface::{Base, Interface};
use crate::names::TypeName;

/// The interfaces cannot be split into packages.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PackageError {
    /// Two packages depend on each other.
    #[error(
        "packages {0} need each other, and ROS cannot build that: put the types into one scope"
    )]
    Circle(String),
}

/// Packages as files.
#[derive(Clone, Debug)]
pub struct Packages {
    /// Contents by path, relative to the folder of all packages: `demo/msg/State.msg`.
    pub files: BTreeMap<String, String>,
    /// Names of the packages; each comes after those it depends on.
    pub names: Vec<String>,
}

impl Packages {
    /// Distributes the interfaces to the packages in their names. `source` is mentioned in the
    /// files.
    ///
    /// # Errors
    /// Two packages depend on each other.
    pub fn new(interfaces: &[Interface], source: &str) -> Result<Self, PackageError> {
        let mut packages: BTreeMap<&str, Vec<&Interface>> = BTreeMap::new();
        for interface in interfaces {
            packages.entry(&interface.name().package).or_default().push(interface);
        }
        let needs: BTreeMap<&str, BTreeSet<&str>> =
            packages.iter().map(|(name, all)| (*name, needs(name, all))).collect();
        let names = in_order(&needs)?;
        let mut files = BTreeMap::new();
        for (package, interfaces) in &packages {
            let depends = &needs[package];
            files.insert(format!("{package}/package.xml"), manifest(package, depends, source));
            let cmake = cmake(package, interfaces, depends);
            files.insert(format!("{package}/CMakeLists.txt"), cmake);
            for interface in interfaces {
                let name = interface.name();
                files.insert(format!("{package}/{}", path(name)), interface.to_string());
            }
        }
        Ok(Self { files, names })
    }
}

fn path(name: &TypeName) -> String {
    format!("{0}/{1}.{0}", name.folder, name.name)
}

fn needs<'a>(package: &str, interfaces: &[&'a Interface]) -> BTreeSet<&'a str> {
    let mut needs = BTreeSet::new();
    for interface in interfaces {
        if matches!(interface, Interface::Action(_)) {
            needs.insert("action_msgs");
        }
        for field in interface.parts().flat_map(|part| &part.fields) {
            if let Base::Message(TypeName { package: other, .. }) = &field.base
                && other != package
            {
                needs.insert(other.as_str());
            }
        }
    }
    needs
}

/// Sorts packages so that each comes after those it depends on.
fn in_order(needs: &BTreeMap<&str, BTreeSet<&str>>) -> Result<Vec<String>, PackageError> {
    let mut order: Vec<&str> = Vec::new();
    while order.len() < needs.len() {
        let left = || needs.iter().filter(|(name, _)| !order.contains(name));
        let ready = |all: &BTreeSet<&str>| {
            all.iter().all(|other| !needs.contains_key(other) || order.contains(other))
        };
        match left().find(|(_, all)| ready(all)) {
            Some((name, _)) => order.push(name),
            None => {
                let circle: Vec<&str> = left().map(|(name, _)| *name).collect();
                return Err(PackageError::Circle(circle.join(", ")));
            }
        }
    }
    Ok(order.into_iter().map(str::to_owned).collect())
}

fn manifest(package: &str, depends: &BTreeSet<&str>, source: &str) -> String {
    let mut out = format!(
        "<?xml version=\"1.0\"?>\n\
         <package format=\"3\">\n  \
           <name>{package}</name>\n  \
           <version>0.0.0</version>\n  \
           <description>Interfaces of {source}, made by genomctl ros2-package.</description>\n  \
           <maintainer email=\"nobody@localhost\">nobody</maintainer>\n  \
           <license>unknown</license>\n\n  \
           <buildtool_depend>ament_cmake</buildtool_depend>\n  \
           <buildtool_depend>rosidl_default_generators</buildtool_depend>\n",
        source = escape(source),
    );
    for other in depends {
        _ = writeln!(out, "  <depend>{other}</depend>");
    }
    out.push_str(
        "  <exec_depend>rosidl_default_runtime</exec_depend>\n  \
           <member_of_group>rosidl_interface_packages</member_of_group>\n\n  \
           <export>\n    <build_type>ament_cmake</build_type>\n  </export>\n</package>\n",
    );
    out
}

fn cmake(package: &str, interfaces: &[&Interface], depends: &BTreeSet<&str>) -> String {
    let mut out = format!(
        "cmake_minimum_required(VERSION 3.8)\nproject({package})\n\n\
         find_package(ament_cmake REQUIRED)\nfind_package(rosidl_default_generators REQUIRED)\n"
    );
    for other in depends {
        _ = writeln!(out, "find_package({other} REQUIRED)");
    }
    out.push_str("\nrosidl_generate_interfaces(${PROJECT_NAME}\n");
    for interface in interfaces {
        _ = writeln!(out, "  \"{}\"", path(interface.name()));
    }
    if !depends.is_empty() {
        let depends: Vec<&str> = depends.iter().copied().collect();
        _ = writeln!(out, "  DEPENDENCIES {}", depends.join(" "));
    }
    out.push_str(")\n\nament_export_dependencies(rosidl_default_runtime)\nament_package()\n");
    out
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
