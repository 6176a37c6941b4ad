//! The components of the repository, and what each is built from.

use std::path::{Path, PathBuf};

use crate::BuildError;

/// The language of a component's codels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Language {
    /// C or C++, by the extension of each source.
    C,
    /// Rust: the workspace's package that has the component's name.
    Rust,
    /// A script with this extension, which is run as it is.
    Script(&'static str),
}

/// How one component is built.
#[derive(Debug)]
pub(crate) struct Recipe {
    /// Name of its directory under `target/components/`.
    pub(crate) name: String,
    /// Name of its files there, without extension.
    pub(crate) stem: String,
    /// The language of its codels.
    pub(crate) language: Language,
    /// The directory of its `.gen` file, which is on the include path.
    pub(crate) directory: PathBuf,
    /// The `.gen` file and those beside it; they are copied beside the library.
    pub(crate) descriptions: Vec<PathBuf>,
    /// Files of another directory of `components/` that descriptions include; they are copied to
    /// the directory of the same name under `target/components/`.
    pub(crate) shared: Vec<PathBuf>,
}

impl Recipe {
    /// A component whose `.gen` file is `directory/file.gen`, with codels in `directory/codels`.
    fn new(name: &str, stem: &str, directory: PathBuf) -> Result<Self, BuildError> {
        let descriptions = files(&directory, &["gen", "idl"])?;
        Ok(Self {
            name: name.to_owned(),
            stem: stem.to_owned(),
            language: Language::C,
            directory,
            descriptions,
            shared: Vec::new(),
        })
    }

    /// The same, with files that its description includes from elsewhere.
    fn sharing(mut self, shared: &[PathBuf]) -> Self {
        self.shared = shared.to_vec();
        self
    }

    /// The same, with codels in Rust.
    fn in_rust(mut self) -> Self {
        self.language = Language::Rust;
        self
    }

    /// The same, with codels in Python, in `directory/stem.py`.
    fn in_python(mut self) -> Self {
        self.language = Language::Script("py");
        self
    }

    /// The same, with codels in Lua, in `directory/stem.lua`.
    fn in_lua(mut self) -> Self {
        self.language = Language::Script("lua");
        self
    }

    /// The sources of its codels.
    pub(crate) fn sources(&self) -> Result<Vec<PathBuf>, BuildError> {
        files(&self.directory.join("codels"), &["c", "cc"])
    }

    /// The headers of its codels.
    pub(crate) fn headers(&self) -> Result<Vec<PathBuf>, BuildError> {
        files(&self.directory.join("codels"), &["h"])
    }
}

/// All components under `root`. Each directory of `components/faults` is one.
pub(crate) fn all(root: &Path) -> Result<Vec<Recipe>, BuildError> {
    let components = root.join("components");
    let demo = components.join("demo");
    let images = files(&components.join("images"), &["idl"])?;
    // The simulator itself needs MuJoCo: `genomctl build` makes it (docs/simulators.md).
    let robot = files(&components.join("sim"), &["idl"])?;
    let mut recipes = vec![
        Recipe::new("demo", "demo", demo.clone())?,
        Recipe::new("demo-2010", "demo", demo.join("papers/2010"))?,
        Recipe::new("demo-2011", "demo", demo.join("papers/2011"))?,
        Recipe::new("demo-rs", "demo-rs", demo)?.in_rust(),
        Recipe::new("demo-cpp", "demo-cpp", components.join("demo-cpp"))?,
        Recipe::new("demo-py", "demo-py", components.join("demo-py"))?.in_python(),
        Recipe::new("demo-lua", "demo-lua", components.join("demo-lua"))?.in_lua(),
        Recipe::new("mission", "mission", components.join("mission"))?,
        Recipe::new("camera", "camera", components.join("camera"))?.sharing(&images),
        Recipe::new("stereo", "stereo", components.join("stereo"))?.sharing(&images).in_rust(),
        Recipe::new("viewer", "viewer", components.join("viewer"))?.sharing(&images).in_rust(),
        Recipe::new("servo", "servo", components.join("servo"))?.sharing(&robot),
        Recipe::new("hover", "hover", components.join("hover"))?.sharing(&robot),
        Recipe::new("planner", "planner", components.join("planner"))?.sharing(&robot).in_python(),
    ];
    for directory in folders(&components.join("faults"))? {
        let name = directory.file_name().unwrap_or_default().to_string_lossy().into_owned();
        recipes.push(Recipe::new(&name, &name, directory)?);
    }
    Ok(recipes)
}

/// Files of a directory with one of these extensions, sorted by name.
pub(crate) fn files(directory: &Path, extensions: &[&str]) -> Result<Vec<PathBuf>, BuildError> {
    let mut files = entries(directory)?;
    files.retain(|path| {
        path.is_file()
            && path
                .extension()
                .is_some_and(|found| extensions.iter().any(|wanted| found == *wanted))
    });
    Ok(files)
}

fn folders(directory: &Path) -> Result<Vec<PathBuf>, BuildError> {
    if !directory.exists() {
        return Ok(Vec::new());
    }
    let mut folders = entries(directory)?;
    folders.retain(|path| path.is_dir());
    Ok(folders)
}

fn entries(directory: &Path) -> Result<Vec<PathBuf>, BuildError> {
    let list = std::fs::read_dir(directory)
        .and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>, _>>());
    let mut list = list.map_err(BuildError::file(directory))?;
    list.sort();
    Ok(list)
}
