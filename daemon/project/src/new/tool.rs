//! The tools that build a component in C or C++, with the files and words of each.

use genom_description::{Options, read_text};

use crate::file::File;
use crate::skeleton::{Language, Sheet, autotools};

const CMAKE: &str = include_str!("../../templates/new/cmake/CMakeLists.txt");
const MESON: &str = include_str!("../../templates/new/meson/meson.build");
const CLANGD: &str = include_str!("../../templates/new/clangd");
/// What `make check` does, at the end of the `Makefile.am` that all projects have.
const CHECK: &str = include_str!("../../templates/new/autotools/check.am");

/// What builds a component in C or C++.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tool {
    /// CMake, with the package that `genomctl sdk` installs.
    CMake,
    /// Meson, with the pkg-config file.
    Meson,
    /// autoconf, automake and libtool, as GenoM3's components have them (genom3.md 5.9).
    Autotools,
}

impl Tool {
    /// The library that a build of `genomctl build` makes, below the project's directory.
    pub(super) fn library(self, name: &str) -> String {
        match self {
            Self::CMake | Self::Meson => format!("build/{name}.so"),
            Self::Autotools => format!("build/codels/.libs/lib{name}_codels.so"),
        }
    }

    /// The command that tests what was built.
    pub(super) fn test(self) -> &'static str {
        match self {
            Self::CMake => "ctest --test-dir build",
            Self::Meson => "meson test -C build",
            Self::Autotools => "make -C build check",
        }
    }

    /// What of a build does not belong into a repository, a line each.
    pub(super) fn built(self) -> &'static str {
        match self {
            Self::CMake | Self::Meson => "build/",
            Self::Autotools => {
                "build/\nautom4te.cache/\nconfigure\naclocal.m4\nMakefile.in\nautoconf/*\n\
                 !autoconf/ag_templates.m4"
            }
        }
    }

    /// The build files, for codels in `sheet` and the description `gen_text`.
    pub(super) fn files(
        self,
        name: &str,
        gen_text: &str,
        language: Language,
        sheet: Sheet,
    ) -> Vec<File> {
        let ending = language.extension();
        let fill = |text: &str, c: &str, cxx: &str| {
            let (compilers, header) = match language {
                Language::C => (c, "c"),
                Language::Cxx => (cxx, "cxx"),
            };
            text.replace("%NAME%", name)
                .replace("%ENDING%", ending)
                // No compiler is asked for that the component does not need.
                .replace("%COMPILERS%", compilers)
                .replace("%HEADER%", &format!("{name}_{header}_types.h"))
                .replace("%INTERFACE%", if language == Language::Cxx { "c++" } else { "c" })
        };
        let compile_commands = || File::new(".clangd", CLANGD);
        match self {
            Self::CMake => {
                vec![File::new("CMakeLists.txt", fill(CMAKE, "C", "CXX")), compile_commands()]
            }
            Self::Meson => {
                vec![File::new("meson.build", fill(MESON, "'c'", "'cpp'")), compile_commands()]
            }
            Self::Autotools => {
                let description = format!("{name}.gen");
                let analysis = read_text(&description, gen_text, &Options::default());
                let components = &analysis.specification.components;
                let mut files: Vec<File> = components
                    .iter()
                    .flat_map(|component| {
                        let sheets = std::slice::from_ref(&sheet);
                        autotools(component, std::slice::from_ref(&description), language, sheets)
                    })
                    .collect();
                for file in files.iter_mut().filter(|file| file.path.as_os_str() == "Makefile.am") {
                    file.text.push_str(&fill(CHECK, "", ""));
                }
                files
            }
        }
    }
}
