//! Reads ELF files without loading them, so that no code of them runs.

use std::ops::Range;
use std::path::Path;

use object::read::elf::{Dyn as _, ElfFile, FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSegment, ObjectSymbol, elf};

use crate::error::OpenError;

/// A description embedded in a library.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EmbeddedDescription {
    /// The text of the `.gen` file.
    pub text: String,
    /// File name to show in messages, if the library has one.
    pub name: Option<String>,
}

/// Reads the whole file.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, OpenError> {
    std::fs::read(path).map_err(|why| match why.kind() {
        std::io::ErrorKind::NotFound => OpenError::NotFound { path: path.to_owned() },
        _ => OpenError::Unreadable { path: path.to_owned(), why },
    })
}

/// Refuses files that the dynamic linker would crash on, or refuse without a helpful message.
pub(crate) fn check(path: &Path, bytes: &[u8]) -> Result<(), OpenError> {
    let ident = bytes.get(..20).filter(|head| head.starts_with(&elf::ELFMAG));
    let Some(ident) = ident else {
        return Err(OpenError::NotElf { path: path.to_owned(), looks: looks_like(bytes) });
    };
    let class = ident[4];
    let data = ident[5];
    let half = |at: usize| {
        let pair = [ident[at], ident[at + 1]];
        if data == elf::ELFDATA2MSB.0 { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) }
    };
    let theirs = machine(half(18), class, data);
    let ours = this_machine();
    if theirs != ours {
        return Err(OpenError::Architecture { path: path.to_owned(), theirs, ours });
    }
    let kind = match elf::FileType(half(16)) {
        elf::ET_DYN => None,
        elf::ET_REL => Some("an object file (.o)"),
        elf::ET_EXEC => Some("a program"),
        elf::ET_CORE => Some("a core dump"),
        _ => Some("an ELF file of unknown kind"),
    };
    if let Some(kind) = kind {
        return Err(OpenError::NotShared { path: path.to_owned(), kind });
    }
    let wanted = extent(bytes)
        .map_err(|why| OpenError::Damaged { path: path.to_owned(), why: why.to_string() })?;
    let size = bytes.len() as u64;
    if wanted > size {
        return Err(OpenError::Truncated { path: path.to_owned(), bytes: size, wanted });
    }
    let disorder = disorder(bytes).unwrap_or_else(|error| Some(error.to_string()));
    if let Some(why) = disorder {
        return Err(OpenError::Damaged { path: path.to_owned(), why });
    }
    Ok(())
}

/// The description in `bytes`, a file that passed the checks of [`Contents::read`](crate::Contents::read).
///
/// # Errors
/// The symbol exists but is not text.
pub fn description_of(path: &Path, bytes: &[u8]) -> Result<Option<EmbeddedDescription>, OpenError> {
    let Ok(file) = object::File::parse(bytes) else { return Ok(None) };
    let Some(text) = text_symbol(&file, "genom_description") else { return Ok(None) };
    let text = String::from_utf8(text.to_vec())
        .map_err(|_| OpenError::Description { path: path.to_owned() })?;
    let name = text_symbol(&file, "genom_description_name")
        .map(|name| String::from_utf8_lossy(name).into_owned());
    Ok(Some(EmbeddedDescription { text, name }))
}

/// Whether the file searches its dependencies relative to its own directory (`$ORIGIN`).
#[must_use]
pub fn uses_origin(bytes: &[u8]) -> bool {
    run_paths(bytes).unwrap_or_default().iter().any(|path| {
        path.windows(7).any(|word| word == b"$ORIGIN")
            || path.windows(9).any(|word| word == b"${ORIGIN}")
    })
}

#[cfg(target_pointer_width = "64")]
type Header = elf::FileHeader64<Endianness>;
#[cfg(target_pointer_width = "32")]
type Header = elf::FileHeader32<Endianness>;

/// A word of the header, of 32 or 64 bits.
fn word(word: impl Into<u64>) -> u64 {
    word.into()
}

/// End of the last byte of the file that a loadable segment uses.
fn extent(bytes: &[u8]) -> object::Result<u64> {
    let header = Header::parse(bytes)?;
    let endian = header.endian()?;
    let segments = header.program_headers(endian, bytes)?.iter();
    let loadable = segments.filter(|segment| segment.p_type(endian) == elf::PT_LOAD);
    let ends = loadable.map(|segment| {
        word(segment.p_offset(endian)).saturating_add(word(segment.p_filesz(endian)))
    });
    Ok(ends.max().unwrap_or(0))
}

/// A loadable segment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Its addresses, relative to where the library is loaded.
    pub range: Range<u64>,
    /// It may be written to.
    pub writable: bool,
    /// It holds code.
    pub executable: bool,
}

/// The loadable segments of a file that passed the checks of
/// [`Contents::read`](crate::Contents::read).
#[must_use]
pub fn segments(bytes: &[u8]) -> Vec<Segment> {
    let read = || -> object::Result<Vec<Segment>> {
        let header = Header::parse(bytes)?;
        let endian = header.endian()?;
        let segments = header.program_headers(endian, bytes)?.iter();
        let loadable = segments.filter(|segment| segment.p_type(endian) == elf::PT_LOAD);
        let segment = loadable.map(|segment| {
            let start = word(segment.p_vaddr(endian));
            let flags = segment.p_flags(endian);
            Segment {
                range: start..start.saturating_add(word(segment.p_memsz(endian))),
                writable: flags.contains(elf::PF_W),
                executable: flags.contains(elf::PF_X),
            }
        });
        Ok(segment.collect())
    };
    read().unwrap_or_default()
}

/// The functions that run when a library is closed, as addresses in the file.
#[derive(Clone, Copy, Debug)]
pub struct Finishers {
    /// Address of their table (`DT_FINI_ARRAY`). The first one is generated by the compiler, and
    /// destroys C++ objects.
    pub at: u64,
    /// Their number.
    pub count: usize,
    /// Address of the word with the table's size in bytes (`DT_FINI_ARRAYSZ`).
    pub size_at: u64,
}

/// The functions that run when the library is closed.
#[must_use]
pub fn finishers(bytes: &[u8]) -> Option<Finishers> {
    let header = Header::parse(bytes).ok()?;
    let endian = header.endian().ok()?;
    let segments = header.program_headers(endian, bytes).ok()?;
    let dynamic = segments.iter().find(|one| one.p_type(endian) == elf::PT_DYNAMIC)?;
    let entries = dynamic.dynamic(endian, bytes).ok()??;
    let entry = |tag| {
        let rank = entries.iter().position(|entry| entry.tag(endian) == tag)?;
        Some((rank, word(entries[rank].d_val(endian))))
    };
    let (_, at) = entry(elf::DT_FINI_ARRAY)?;
    let (rank, size) = entry(elf::DT_FINI_ARRAYSZ)?;
    let count = usize::try_from(size).ok()? / size_of::<usize>();
    // An entry consists of a tag and a value, one word each.
    let size_at = word(dynamic.p_vaddr(endian)) + ((2 * rank + 1) * size_of::<usize>()) as u64;
    Some(Finishers { at, count, size_at })
}

/// Tags of the dynamic table whose values are addresses that the dynamic linker uses without
/// checks.
const FOLLOWED: [elf::DynamicTag; 12] = [
    elf::DT_HASH,
    elf::DT_GNU_HASH,
    elf::DT_STRTAB,
    elf::DT_SYMTAB,
    elf::DT_RELA,
    elf::DT_JMPREL,
    elf::DT_VERSYM,
    elf::DT_VERNEED,
    elf::DT_INIT,
    elf::DT_FINI,
    elf::DT_INIT_ARRAY,
    elf::DT_FINI_ARRAY,
];

/// An error in the tables that the dynamic linker uses without checks, if there is one.
fn disorder(bytes: &[u8]) -> object::Result<Option<String>> {
    let header = Header::parse(bytes)?;
    let endian = header.endian()?;
    let segments = header.program_headers(endian, bytes)?;
    let mut loaded: Vec<(u64, u64)> = Vec::new();
    for segment in segments.iter().filter(|segment| segment.p_type(endian) == elf::PT_LOAD) {
        let start = word(segment.p_vaddr(endian));
        let in_file = start.saturating_add(word(segment.p_filesz(endian)));
        let end = start.saturating_add(word(segment.p_memsz(endian)));
        if in_file > end || loaded.last().is_some_and(|(_, before)| start < *before) {
            return Ok(Some(format!("its segment at {start:#x} is out of order")));
        }
        loaded.push((start, end));
    }
    let inside = |at: u64| loaded.iter().any(|(start, end)| (*start..*end).contains(&at));
    let Some(dynamic) = segments.iter().find(|one| one.p_type(endian) == elf::PT_DYNAMIC) else {
        return Ok(Some("it has no dynamic table".to_owned()));
    };
    if !inside(word(dynamic.p_vaddr(endian))) {
        return Ok(Some("its dynamic table is in none of its segments".to_owned()));
    }
    let entries = dynamic.dynamic(endian, bytes)?.unwrap_or_default().iter();
    let mut entries = entries.take_while(|entry| entry.tag(endian) != elf::DT_NULL);
    let astray =
        entries.find(|entry| FOLLOWED.contains(&entry.tag(endian)) && !inside(entry.val(endian)));
    Ok(astray.map(|entry| {
        let (tag, at) = (entry.tag(endian).0, entry.val(endian));
        format!("entry {tag:#x} of its dynamic table leads to {at:#x}, where nothing is")
    }))
}

/// Whether the file needs a library whose name begins with `name`.
#[must_use]
pub fn needs(bytes: &[u8], name: &str) -> bool {
    let needed = dynamic(bytes, &[elf::DT_NEEDED]).unwrap_or_default();
    needed.iter().any(|library| library.starts_with(name.as_bytes()))
}

/// `DT_RUNPATH` and `DT_RPATH`.
fn run_paths(bytes: &[u8]) -> object::Result<Vec<&[u8]>> {
    dynamic(bytes, &[elf::DT_RUNPATH, elf::DT_RPATH])
}

/// The strings of the dynamic table for one of these tags.
fn dynamic<'a>(bytes: &'a [u8], tags: &[elf::DynamicTag]) -> object::Result<Vec<&'a [u8]>> {
    let file = ElfFile::<Header>::parse(bytes)?;
    let table = file.elf_section_table().dynamic_table(file.endian(), bytes)?;
    let entries = table.iter().filter(|entry| tags.contains(&entry.tag));
    entries.map(|entry| table.string(entry)).collect()
}

/// The bytes of the string in exported symbol `name`, its NUL excluded.
fn text_symbol<'data>(file: &object::File<'data>, name: &str) -> Option<&'data [u8]> {
    let symbol = file.dynamic_symbols().find(|s| s.is_definition() && s.name() == Ok(name))?;
    let segment = file.segments().find(|segment| {
        symbol.address().checked_sub(segment.address()).is_some_and(|at| at < segment.size())
    })?;
    let start = usize::try_from(symbol.address() - segment.address()).ok()?;
    let bytes = segment.data().ok()?.get(start..)?;
    let bytes = match usize::try_from(symbol.size()) {
        Ok(size) if size > 0 => bytes.get(..size)?,
        _ => bytes,
    };
    bytes.split(|byte| *byte == 0).next()
}

/// Mangled symbols of the exported C++ functions with the name `function`.
#[must_use]
pub fn mangled(bytes: &[u8], function: &str) -> Vec<String> {
    let Ok(file) = object::File::parse(bytes) else { return Vec::new() };
    let prefix = format!("_Z{}{function}", function.len());
    let symbols = file.dynamic_symbols().filter(|symbol| symbol.is_definition());
    let found = symbols.filter_map(|s| s.name().ok().filter(|name| name.starts_with(&prefix)));
    found.map(str::to_owned).collect()
}

/// A machine in one word, from ELF class, byte order and number.
fn machine(number: u16, class: u8, data: u8) -> String {
    let wide = class == elf::ELFCLASS64.0;
    let big = data == elf::ELFDATA2MSB.0;
    let name = match (elf::Machine(number), wide, big) {
        (elf::EM_X86_64, true, _) => "x86_64",
        (elf::EM_X86_64, false, _) => "x32",
        (elf::EM_386, ..) => "x86",
        (elf::EM_AARCH64, _, false) => "aarch64",
        (elf::EM_ARM, _, false) => "arm",
        (elf::EM_RISCV, true, _) => "riscv64",
        (elf::EM_RISCV, false, _) => "riscv32",
        (elf::EM_PPC64, _, true) => "powerpc64",
        (elf::EM_PPC64, _, false) => "powerpc64le",
        (elf::EM_S390, true, _) => "s390x",
        (elf::EM_LOONGARCH, true, _) => "loongarch64",
        (elf::EM_MIPS, ..) => "mips",
        _ => return format!("ELF machine {number}"),
    };
    name.to_owned()
}

/// The machine that this daemon was built for, as [`machine`] writes it.
fn this_machine() -> String {
    match (std::env::consts::ARCH, cfg!(target_endian = "little")) {
        ("powerpc64", true) => "powerpc64le".to_owned(),
        ("x86_64", _) if cfg!(target_pointer_width = "32") => "x32".to_owned(),
        (arch, _) => arch.to_owned(),
    }
}

/// What kind of file it seems to be, when it is not ELF.
fn looks_like(bytes: &[u8]) -> &'static str {
    match bytes {
        [] => "is empty",
        [b'#', b'!', ..] => "looks like a script",
        [b'!', b'<', b'a', b'r', ..] => "looks like a static library (.a)",
        [b'M', b'Z', ..] => "looks like a Windows library",
        [0xcf, 0xfa, 0xed, 0xfe, ..] => "looks like a macOS library",
        _ if std::str::from_utf8(&bytes[..bytes.len().min(64)]).is_ok() => "looks like text",
        _ => "does not begin like one",
    }
}
