//! The files whose code a process ran: names of functions, and build ids.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

use genom_protocol::CrashFrame;
use rustix::fs::OFlags;

use super::note::{Mapping, Note};
use super::reader::{Offsets, look_up};
use super::symbols::Contents;

/// Most files that are opened for one report.
const MOST: usize = 64;

/// The files of a process that has ended, held open: its private copies of libraries are removed
/// by the next process.
#[derive(Debug)]
pub(super) struct Images(Vec<Image>);

#[derive(Debug)]
struct Image {
    /// `None` for a library of a process that told nothing of its memory.
    mapping: Option<Mapping>,
    /// The library that it is a copy of, or itself.
    shown: String,
    file: Option<File>,
    contents: Contents,
}

impl Images {
    /// Opens the files of a note. `libraries`: those of the components, by the paths users know.
    pub(super) fn open(note: Option<&Note>, libraries: &[PathBuf]) -> Self {
        let mapped = |note: &Note| {
            let addresses = || note.pc.iter().chain(&note.callers).chain(&note.guesses);
            let is_library = |path: &str| libraries.iter().any(|one| original(path, one));
            let wanted = note.mappings.iter().filter(|one| {
                is_library(&one.path) || addresses().any(|address| one.holds(*address))
            });
            let image = |mapping: &Mapping| {
                let library = libraries.iter().find(|one| original(&mapping.path, one));
                let file = regular(Path::new(&mapping.path));
                // Loaded from beside the library, and removed since: a copy of its content.
                let file = file.or_else(|| regular(library?));
                let shown = library.map_or(mapping.path.clone(), |one| one.display().to_string());
                let contents = Contents::default();
                Image { mapping: Some(mapping.clone()), shown, file, contents }
            };
            wanted.take(MOST).map(image).collect()
        };
        let mut images: Vec<Image> = note.map(mapped).unwrap_or_default();
        for library in libraries.iter().take(MOST) {
            let shown = library.display().to_string();
            if !images.iter().any(|one| one.shown == shown) {
                let contents = Contents::default();
                images.push(Image { mapping: None, shown, file: regular(library), contents });
            }
        }
        Self(images)
    }

    /// Reads in them what is told of these addresses, and their build ids.
    pub(super) fn look_up(&mut self, program: &Path, told: &[(u64, bool)]) -> io::Result<()> {
        let asked = |image: &Image| image.own(told).map(|(_, offset)| offset).collect();
        let (of, asked): (Vec<usize>, Vec<(&File, Offsets)>) = self
            .0
            .iter()
            .enumerate()
            .filter_map(|(at, image)| Some((at, (image.file.as_ref()?, asked(image)))))
            .unzip();
        let read = look_up(program, &asked)?;
        for (at, contents) in of.into_iter().zip(read) {
            if let Some(image) = self.0.get_mut(at) {
                image.contents = contents;
            }
        }
        Ok(())
    }

    /// The build id of a library that was loaded.
    pub(super) fn build_id(&self, library: &Path) -> Option<String> {
        let shown = library.display().to_string();
        self.0.iter().find(|image| image.shown == shown)?.contents.build_id.clone()
    }

    /// Names frames: each with whether it is a return address, behind the call that it is of.
    pub(super) fn name(&self, told: &[(u64, bool)]) -> Vec<CrashFrame> {
        let mut frames: Vec<_> = told
            .iter()
            .map(|(address, _)| CrashFrame {
                address: format!("{address:#x}"),
                ..Default::default()
            })
            .collect();
        for image in &self.0 {
            for (at, (rank, _)) in image.own(told).enumerate() {
                let Some(frame) = frames.get_mut(rank) else { continue };
                frame.file = Some(image.shown.clone());
                if let Some((address, name)) = image.contents.functions.get(at) {
                    frame.file_address = Some(format!("{address:#x}"));
                    frame.function.clone_from(name);
                }
            }
        }
        frames
    }
}

impl Image {
    /// The addresses in it: their ranks, and where they are in the file.
    fn own(&self, told: &[(u64, bool)]) -> impl Iterator<Item = (usize, u64)> {
        let in_file = move |(rank, (at, returns)): (usize, &(u64, bool))| {
            let mapping = self.mapping.as_ref().filter(|mapping| mapping.holds(*at))?;
            Some((rank, mapping.in_file(at - u64::from(*returns))))
        };
        told.iter().enumerate().filter_map(in_file)
    }
}

/// Whether a mapped file is this library, or a copy of it: `DIRECTORY/NUMBER-NAME`, or
/// `.NAME.genomd-...` beside it.
fn original(mapped: &str, library: &Path) -> bool {
    let Some(name) = library.file_name().and_then(|name| name.to_str()) else { return false };
    let mapped = Path::new(mapped);
    let file = mapped.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let shelf = mapped.parent().and_then(Path::file_name).and_then(|name| name.to_str());
    let copied = shelf.is_some_and(|shelf| shelf.starts_with("genomd-library-"))
        && file.split_once('-').is_some_and(|(_, rest)| rest == name);
    let beside = file.strip_prefix('.').and_then(|rest| rest.strip_prefix(name));
    mapped == library || copied || beside.is_some_and(|rest| rest.starts_with(".genomd-"))
}

/// Opens a regular file. The process chose the names in its note: opening a pipe would wait, and
/// opening a device may do something.
pub(super) fn regular(path: &Path) -> Option<File> {
    let is_file = fs::metadata(path).is_ok_and(|found| found.is_file());
    let mut options = OpenOptions::new();
    options.read(true).custom_flags(OFlags::NONBLOCK.bits().cast_signed());
    let file = is_file.then(|| options.open(path).ok())??;
    file.metadata().is_ok_and(|found| found.is_file()).then_some(file)
}

#[cfg(test)]
mod tests {
    use super::super::symbols;
    use super::*;

    #[test]
    fn a_private_copy_is_known_as_its_library() {
        let library = Path::new("/opt/robot/demo.so");
        for (mapped, is) in [
            ("/opt/robot/demo.so", true),
            ("/tmp/genomd-library-Xy/12-demo.so", true),
            ("/opt/robot/.demo.so.genomd-Xy (deleted)", true),
            ("/tmp/genomd-library-Xy/12-other.so", false),
            ("/tmp/12-demo.so", false),
            ("/usr/lib/libc.so.6", false),
        ] {
            assert_eq!(original(mapped, library), is, "{mapped}");
        }
    }

    #[test]
    fn an_address_of_this_program_is_named() {
        let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
        let code = maps.lines().filter(|line| line.contains(" r-xp "));
        let text: String = code.map(|line| format!("map {line}\n")).collect();
        let address = an_address_of_this_program_is_named as fn() as usize as u64 + 1;
        let note =
            super::super::note::read(format!("what x\n{text}caller {address:#x}").as_bytes());
        let mut images = Images::open(note.as_ref(), &[]);
        let told = [(address, true)];
        for image in &mut images.0 {
            let offsets: Vec<u64> = image.own(&told).map(|(_, offset)| offset).collect();
            image.contents = symbols::read(image.file.as_ref().unwrap(), &offsets);
        }
        let frame = &images.name(&told)[0];
        let function = frame.function.as_deref().unwrap();
        let own = "genom_cells::crashes::images::tests::an_address_of_this_program_is_named+0x0";
        assert_eq!(function, own, "{frame:?}");
    }
}
