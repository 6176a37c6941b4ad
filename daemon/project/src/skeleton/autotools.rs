//! The build files of a component with autotools (genom3.md 5.9): the library of codels, its
//! pkg-config file, and its descriptions under `share/idl`.

use genom_description::model::Component;

use super::{Language, Sheet, header_name};
use crate::file::File;

const CONFIGURE: &str = include_str!("../../templates/autotools/configure.ac");
const TOP: &str = include_str!("../../templates/autotools/Makefile.am");
const CODELS: &str = include_str!("../../templates/autotools/codels/Makefile.am");
const PACKAGE: &str = include_str!("../../templates/autotools/component-genom3.pc.in");
const TEMPLATES: &str = include_str!("../../templates/autotools/autoconf/ag_templates.m4");

/// The build files for `component`. `descriptions` are the files at the top of the project that
/// are installed with it: its `.gen`, then those that it includes.
#[must_use]
pub fn autotools(
    component: &Component,
    descriptions: &[String],
    language: Language,
    sheets: &[Sheet],
) -> Vec<File> {
    let name = &component.name;
    let sources: Vec<_> = sheets
        .iter()
        .filter_map(|sheet| sheet.path.file_name())
        .map(|file| format!("lib{name}_codels_la_SOURCES += {}\n", file.to_string_lossy()))
        .collect();
    let version = if component.version == "0" { "0.1" } else { component.version.as_str() };
    let description = descriptions.first().map_or("", String::as_str);
    let fill = |text: &str| {
        text.replace("%NAME%", name)
            .replace("%GEN%", description)
            .replace("%VERSION%", version)
            .replace("%EMAIL%", component.email.as_deref().unwrap_or_default())
            .replace("%HEADER%", &header_name(component))
            .replace("%INTERFACE%", if component.lang == "c++" { "c++" } else { "c" })
            .replace("%LANGUAGE%", if language == Language::Cxx { "c++" } else { "c" })
            .replace("%SOURCES%", sources.concat().trim_end())
            .replace("%REQUIRES%", &requires(component).join(" "))
            .replace("%PKG_REQUIRES%", &requires(component).join(", "))
            .replace("%PKG_PRIVATE%", &component.codels_requires.join(", "))
            .replace("%CODELS_REQUIRES%", &codels_requires(component))
            .replace("%IDL%", &descriptions.join(" "))
    };
    vec![
        File::new("configure.ac", fill(CONFIGURE)),
        File::new("Makefile.am", fill(TOP)),
        File::new("codels/Makefile.am", fill(CODELS)),
        File::new(format!("{name}-genom3.pc.in"), fill(PACKAGE)),
        File::new("autoconf/ag_templates.m4", TEMPLATES),
        File::program(
            "autogen.sh",
            "#!/bin/sh\nset -e\ncd \"$(dirname \"$0\")\"\nautoreconf -vi\n",
        ),
    ]
}

/// The packages that the description needs, GenoM3 itself among them.
fn requires(component: &Component) -> Vec<String> {
    let mut list = component.requires.clone();
    if !list.iter().any(|package| package.split_whitespace().next() == Some("genom3")) {
        list.insert(0, "genom3 >= 2.99.26".to_owned());
    }
    list
}

/// The check for the libraries that codels are linked with, if there are any.
fn codels_requires(component: &Component) -> String {
    if component.codels_requires.is_empty() {
        return String::new();
    }
    let list = component.codels_requires.join(" ");
    format!("\ndnl Libraries that codels use.\nPKG_CHECK_MODULES([codels_requires], [{list}])\n")
}
