//! Finds definitions of foreign types: built in, or in folders of packages.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::interface::{Interface, Message};
use crate::names::TypeName;
use crate::parse::{ParseError, parse};
use crate::standard;

/// A definition cannot be found or read.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LibraryError {
    /// There is no definition of that name.
    #[error(
        "{name} is not known: it is none of ROS's common types, and no {file} is in {folders}; \
         name the folder of its package"
    )]
    Unknown {
        /// Name of the type.
        name: Box<TypeName>,
        /// File that was searched for.
        file: String,
        /// Folders that were searched.
        folders: String,
    },
    /// The file exists but cannot be read.
    #[error("{path}: {why}", path = .path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// The system's message.
        why: String,
    },
    /// The file exists but does not define an interface.
    #[error("{path}: {error}", path = .path.display())]
    Text {
        /// Path of the file.
        path: PathBuf,
        /// What is wrong.
        error: Box<ParseError>,
    },
}

/// Definitions by name.
#[derive(Debug, Default)]
pub struct Library {
    folders: Vec<PathBuf>,
    read: Mutex<BTreeMap<TypeName, Interface>>,
}

impl Library {
    /// Searches what is built in, then folders that contain packages: `FOLDER/geometry_msgs/msg`.
    #[must_use]
    pub fn new(folders: Vec<PathBuf>) -> Self {
        Self { folders, read: Mutex::default() }
    }

    /// The same as [`new`](Library::new), and also searches the folders of a sourced ROS workspace
    /// (`AMENT_PREFIX_PATH`).
    #[must_use]
    pub fn with_ament(mut folders: Vec<PathBuf>, ament_prefix_path: Option<&str>) -> Self {
        let prefixes = ament_prefix_path.unwrap_or_default().split(':');
        let prefixes = prefixes.filter(|prefix| !prefix.is_empty());
        folders.extend(prefixes.map(|prefix| Path::new(prefix).join("share")));
        Self::new(folders)
    }

    /// The definition of a type.
    ///
    /// # Errors
    /// It is neither built in nor in one of the folders, or its file cannot be read.
    pub fn find(&self, name: &TypeName) -> Result<Interface, LibraryError> {
        if let Some(known) = standard::all().get(name) {
            return Ok(known.clone());
        }
        let mut read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = read.get(name) {
            return Ok(known.clone());
        }
        let file = format!("{}/{}/{}.{}", name.package, name.folder, name.name, name.folder);
        let paths = self.folders.iter().map(|folder| folder.join(&file));
        let Some(path) = paths.into_iter().find(|path| path.is_file()) else {
            let folders: Vec<_> = self.folders.iter().map(|f| f.display().to_string()).collect();
            let folders =
                if folders.is_empty() { "any folder given".to_owned() } else { folders.join(", ") };
            return Err(LibraryError::Unknown { name: Box::new(name.clone()), file, folders });
        };
        let text = std::fs::read_to_string(&path)
            .map_err(|error| LibraryError::File { path: path.clone(), why: error.to_string() })?;
        let interface = parse(name, &text)
            .map_err(|error| LibraryError::Text { path, error: Box::new(error) })?;
        read.insert(name.clone(), interface.clone());
        Ok(interface)
    }

    /// The definition of a message.
    ///
    /// # Errors
    /// The same as [`find`](Library::find).
    pub fn message(&self, name: &TypeName) -> Result<Message, LibraryError> {
        match self.find(name)? {
            Interface::Message(message) => Ok(message),
            // Does not happen: services and actions are in other folders.
            other => Ok(Message::new(other.name().clone())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_are_found_in_folders_and_what_is_missing_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("share/arm_msgs/srv");
        std::fs::create_dir_all(&place).unwrap();
        std::fs::write(place.join("Go.srv"), "float64 goal\n---\n").unwrap();
        std::fs::write(place.join("Bad.srv"), "float64\n").unwrap();
        let library = Library::with_ament(Vec::new(), folder.path().to_str());
        let name = TypeName::new("arm_msgs", "srv", "Go");
        assert_eq!(library.find(&name).unwrap().to_string(), "float64 goal\n---\n");
        let bad = library.find(&TypeName::new("arm_msgs", "srv", "Bad")).unwrap_err().to_string();
        assert!(bad.ends_with("Bad.srv: arm_msgs/srv/Bad, line 1: `float64` has no name"), "{bad}");
        let none = library.find(&TypeName::new("leg_msgs", "msg", "Leg")).unwrap_err().to_string();
        assert!(none.contains("leg_msgs/msg/Leg.msg") && none.contains("share"), "{none}");
    }
}
