//! Missing files: omits the errors about names that they would have declared.

use crate::diagnostic::{Diagnostic, Diagnostics, Severity};

/// Codes for a file or package that cannot be read.
const ABSENT: [&str; 4] = ["E0120", "E0121", "E0131", "E0133"];
/// Code for a package that is not found.
const PACKAGE: &str = "E0131";
/// Code for a file that is not found.
const FILE: &str = "E0121";
/// Codes for a name, or an interface, that nothing declares.
const UNKNOWN: [&str; 2] = ["E0206", "E0402"];

/// Omits consequential errors: a missing file makes names unknown, and a missing package makes
/// files missing. The first error says how many others are omitted for that reason.
pub(crate) fn leave_out(preprocess: &mut Diagnostics, rest: &mut Diagnostics) {
    let is_error = |one: &Diagnostic| one.severity == Severity::Error;
    if preprocess.iter().any(|one| one.code == PACKAGE) {
        preprocess.retain(|one| one.code != FILE);
    }
    let absent = |one: &&mut Diagnostic| is_error(one) && ABSENT.contains(&one.code);
    let Some(first) = preprocess.iter_mut().find(absent) else { return };
    let before = rest.found();
    rest.retain(|one| !UNKNOWN.contains(&one.code));
    let left_out = match before - rest.found() {
        0 => return,
        1 => "1 error about a name that is unknown without it is left out".to_owned(),
        many => format!("{many} errors about names that are unknown without it are left out"),
    };
    first.help = Some(match first.help.take() {
        Some(help) => format!("{help}; {left_out}"),
        None => left_out,
    });
}
