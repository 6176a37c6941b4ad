//! Flags of the packages that codels need, by pkg-config.

use genom_description::pkg_config::{PkgConfig, PkgConfigError};

use super::error::BuildError;

/// Flags for the compiler and for the linker.
#[derive(Debug, Default)]
pub(super) struct Flags {
    pub(super) compile: Vec<String>,
    pub(super) link: Vec<String>,
}

/// The flags for these packages, written as in `codels-require`: `opencv4 >= 4.2`. Packages of
/// GenoM3 itself are left out: what they give is here.
pub(super) fn flags(packages: &[String]) -> Result<Flags, BuildError> {
    let own = |package: &&String| {
        !matches!(package.split_whitespace().next(), None | Some("genom3" | "genom" | "genomd"))
    };
    let wanted: Vec<&String> = packages.iter().filter(own).collect();
    if wanted.is_empty() {
        return Ok(Flags::default());
    }
    let ask = |question: &str| {
        let answer = PkgConfig::default().flags(question, &wanted);
        answer.map_err(|error| refused(&wanted, &error))
    };
    Ok(Flags { compile: ask("--cflags")?, link: ask("--libs")? })
}

fn refused(packages: &[&String], error: &PkgConfigError) -> BuildError {
    let list: Vec<_> = packages.iter().map(|package| package.as_str()).collect();
    let list = list.join(", ");
    let help = match error {
        PkgConfigError::Absent { .. } | PkgConfigError::Unusable { .. } => {
            "install pkg-config, or name it by PKG_CONFIG"
        }
        PkgConfigError::Option(_) => "write names as `opencv4` or `opencv4 >= 4.2`",
        _ => "install the missing one for development, or add its directory to PKG_CONFIG_PATH",
    };
    BuildError::Package(format!("packages {list} that the description requires: {error}; {help}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_option_in_the_place_of_a_package_is_refused() {
        let refused = flags(&["genom3 >= 2.99".to_owned(), "--print-provides".to_owned()]);
        let told = refused.unwrap_err().to_string();
        assert!(told.contains("`--print-provides` is no name of a package"), "{told}");
        assert!(flags(&["genom3 >= 2.99".to_owned()]).is_ok(), "its own packages are here");
    }
}
