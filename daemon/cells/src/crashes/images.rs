//! The files whose code a process ran: names of functions, and build ids.

use std::fs::{self, File, OpenOptions};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

use genom_protocol::CrashFrame;
use object::read::ReadCache;
use object::{Object as _, ObjectSegment as _, ObjectSymbol as _, SymbolKind};
use rustix::fs::OFlags;

use super::names::plain;
use super::note::{Mapping, Note};

/// Most files that are opened for one report.
const MOST: usize = 64;

/// The files of a process that has ended, held open: its private copies of libraries are removed
/// by the next process.
#[derive(Debug)]
pub(super) struct Images(Vec<Image>);

#[derive(Debug)]
struct Image {
    mapping: Mapping,
    /// The library that it is a copy of, or itself.
    shown: String,
    file: Option<File>,
}

impl Images {
    /// Opens the files of a note. `libraries`: those of the components, by the paths users know.
    pub(super) fn open(note: &Note, libraries: &[PathBuf]) -> Self {
        let addresses = || note.pc.iter().chain(&note.callers).chain(&note.guesses);
        let is_library = |path: &str| libraries.iter().any(|one| original(path, one));
        let wanted = note
            .mappings
            .iter()
            .filter(|one| is_library(&one.path) || addresses().any(|address| one.holds(*address)));
        let image = |mapping: &Mapping| {
            let library = libraries.iter().find(|one| original(&mapping.path, one));
            let file = regular(Path::new(&mapping.path));
            // Loaded from beside the library, and removed since: a copy of the library's content.
            let file = file.or_else(|| regular(library?));
            let shown = library.map_or(mapping.path.clone(), |one| one.display().to_string());
            Image { mapping: mapping.clone(), shown, file }
        };
        Self(wanted.take(MOST).map(image).collect())
    }

    /// The build id of a library that was loaded.
    pub(super) fn build_id(&self, library: &Path) -> Option<String> {
        let image = self.0.iter().find(|image| original(&image.mapping.path, library));
        match image {
            Some(image) => build_id(image.file.as_ref()?),
            // The process told nothing of its memory.
            None => build_id_of(library),
        }
    }

    /// Names frames: each with whether it is a return address, behind the call that it is of.
    pub(super) fn name(&self, addresses: &[(u64, bool)]) -> Vec<CrashFrame> {
        let mut frames: Vec<_> = addresses
            .iter()
            .map(|(address, _)| CrashFrame {
                address: format!("{address:#x}"),
                ..Default::default()
            })
            .collect();
        for image in &self.0 {
            let own = addresses.iter().enumerate().filter(|(_, (at, _))| image.mapping.holds(*at));
            let own: Vec<(usize, u64)> = own
                .map(|(rank, (at, returns))| {
                    (rank, image.mapping.in_file(at - u64::from(*returns)))
                })
                .collect();
            if own.is_empty() {
                continue;
            }
            let offsets: Vec<u64> = own.iter().map(|(_, offset)| *offset).collect();
            let names = image.file.as_ref().and_then(|file| functions(file, &offsets));
            for (at, (rank, _)) in own.iter().enumerate() {
                let Some(frame) = frames.get_mut(*rank) else { continue };
                frame.file = Some(image.shown.clone());
                if let Some((address, name)) = names.as_ref().and_then(|names| names.get(at)) {
                    frame.file_address = Some(format!("{address:#x}"));
                    frame.function.clone_from(name);
                }
            }
        }
        frames
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
    open(path, OFlags::NONBLOCK)
}

/// The same of the last part of a path that is no link.
pub(super) fn regular_itself(path: &Path) -> Option<File> {
    open(path, OFlags::NONBLOCK | OFlags::NOFOLLOW)
}

fn open(path: &Path, flags: OFlags) -> Option<File> {
    let is_file = fs::metadata(path).is_ok_and(|found| found.is_file());
    let mut options = OpenOptions::new();
    options.read(true).custom_flags(flags.bits().cast_signed());
    let file = is_file.then(|| options.open(path).ok())??;
    file.metadata().is_ok_and(|found| found.is_file()).then_some(file)
}

/// The build id of a library of which nothing else is known.
pub(super) fn build_id_of(library: &Path) -> Option<String> {
    build_id(&regular(library)?)
}

fn build_id(file: &File) -> Option<String> {
    let cache = ReadCache::new(file);
    let file = object::File::parse(&cache).ok()?;
    let id = file.build_id().ok()??;
    Some(id.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// For each offset in a file, its address there, and the function with the offset in it.
fn functions(file: &File, offsets: &[u64]) -> Option<Vec<(u64, Option<String>)>> {
    let cache = ReadCache::new(file);
    let file = object::File::parse(&cache).ok()?;
    let address_of = |offset: u64| {
        let within = file.segments().find(|segment| {
            let (start, size) = segment.file_range();
            offset >= start && offset - start < size
        });
        within.map_or(offset, |segment| {
            segment.address().wrapping_add(offset - segment.file_range().0)
        })
    };
    let addresses: Vec<u64> = offsets.iter().map(|offset| address_of(*offset)).collect();
    let mut best: Vec<Option<(u64, String)>> = vec![None; addresses.len()];
    let (low, high) = (*addresses.iter().min()?, *addresses.iter().max()?);
    for symbol in file.symbols().chain(file.dynamic_symbols()) {
        // Most are far from all of them, and there may be a million.
        let start = symbol.address();
        if start > high {
            continue;
        }
        let size = symbol.size();
        if size == 0 || start.saturating_add(size) <= low || symbol.kind() != SymbolKind::Text {
            continue;
        }
        for (address, best) in addresses.iter().zip(&mut best) {
            let nearer = best.as_ref().is_none_or(|(before, _)| *before < start);
            if *address >= start && *address - start < size && nearer {
                let Ok(name) = symbol.name() else { continue };
                *best = Some((start, plain(name)));
            }
        }
    }
    let told = addresses.into_iter().zip(best).map(|(address, best)| {
        (address, best.map(|(start, name)| format!("{name}+{:#x}", address - start)))
    });
    Some(told.collect())
}

#[cfg(test)]
mod tests {
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
        let images = Images::open(&note.unwrap(), &[]);
        let frame = &images.name(&[(address, true)])[0];
        let function = frame.function.as_deref().unwrap();
        let own = "genom_cells::crashes::images::tests::an_address_of_this_program_is_named+0x0";
        assert_eq!(function, own, "{frame:?}");
    }
}
