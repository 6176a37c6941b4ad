//! The template `genomd/server`: a directory that the build of a component with autotools recurses
//! into, and that installs the program `NAME-genomd`.

use genom_description::model::Component;

use crate::file::File;

const CONFIGURE: &str = include_str!("../templates/server/configure");
const MARKER: &str = include_str!("../templates/server/configure.ac");
const MAKEFILE: &str = include_str!("../templates/server/Makefile.in");

/// The files of the directory.
#[must_use]
pub fn server(component: &Component) -> Vec<File> {
    let fill = |text: &str| text.replace("%NAME%", &component.name);
    vec![
        File::program("configure", fill(CONFIGURE)),
        File::new("configure.ac", MARKER),
        File::new("Makefile.in", fill(MAKEFILE)),
    ]
}
