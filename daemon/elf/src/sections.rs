//! The debug sections of a library, decompressed if necessary, or the reason why there are none.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Read;

use flate2::read::ZlibDecoder;
use gimli::SectionId;
use object::{CompressionFormat, Object, ObjectSection};

/// Why a library has no debug sections to read, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum NoSections {
    /// The library was built without debug information.
    #[error("the library tells no types (build it with -g)")]
    Nothing,
    /// The debug information was stripped into another file.
    #[error(
        "its debug information is in another file, {file} (load the library that was not stripped)"
    )]
    Elsewhere {
        /// Name of that file.
        file: String,
    },
    /// A section cannot be decompressed.
    #[error("its section {section} is damaged: {why}")]
    Damaged {
        /// Name of the section.
        section: &'static str,
        /// The error.
        why: Damage,
    },
    /// A section is compressed by another method.
    #[error(
        "its section {section} is compressed in a way this daemon does not read (compress with \
         -gz=zlib, or not at all)"
    )]
    Compressed {
        /// Name of the section.
        section: &'static str,
    },
}

/// What is wrong with a compressed section.
#[derive(Debug, thiserror::Error)]
pub enum Damage {
    /// Its header is invalid.
    #[error("{0}")]
    Header(#[from] object::Error),
    /// Its content cannot be decompressed.
    #[error("{0}")]
    Contents(#[from] std::io::Error),
    /// Its header claims an unreasonable size.
    #[error("it says it has {0} bytes")]
    Huge(u64),
    /// Its header claims another size.
    #[error("it is shorter or longer than it says")]
    Length,
}

/// Larger sections are not read: a damaged header may claim any size.
const LARGEST: u64 = 1 << 30;

/// Contents of the debug sections, by name.
#[derive(Debug)]
pub struct Sections<'a> {
    /// Their byte order.
    pub little_endian: bool,
    contents: HashMap<&'static str, Cow<'a, [u8]>>,
}

impl<'a> Sections<'a> {
    /// Reads the sections of the ELF file `bytes`.
    ///
    /// # Errors
    /// There is no usable debug information.
    pub fn new(bytes: &'a [u8]) -> Result<Self, NoSections> {
        let Ok(file) = object::File::parse(bytes) else { return Err(NoSections::Nothing) };
        let all = [
            SectionId::DebugAbbrev,
            SectionId::DebugAddr,
            SectionId::DebugInfo,
            SectionId::DebugLine,
            SectionId::DebugLineStr,
            SectionId::DebugLoc,
            SectionId::DebugLocLists,
            SectionId::DebugRanges,
            SectionId::DebugRngLists,
            SectionId::DebugStr,
            SectionId::DebugStrOffsets,
            SectionId::DebugTypes,
        ];
        let mut contents = HashMap::new();
        for id in all {
            if let Some(section) = file.section_by_name(id.name()) {
                contents.insert(id.name(), plain(&section, id.name())?);
            }
        }
        if !contents.contains_key(SectionId::DebugInfo.name()) {
            return Err(match file.gnu_debuglink() {
                Ok(Some((name, _))) => {
                    NoSections::Elsewhere { file: String::from_utf8_lossy(name).into_owned() }
                }
                _ => NoSections::Nothing,
            });
        }
        Ok(Self { little_endian: file.is_little_endian(), contents })
    }

    /// The contents of a section; empty when the library has none.
    #[must_use]
    pub fn get(&self, name: &str) -> &[u8] {
        self.contents.get(name).map(AsRef::as_ref).unwrap_or_default()
    }
}

/// The contents of a section, whether it is compressed or not.
fn plain<'a>(
    section: &impl ObjectSection<'a>,
    name: &'static str,
) -> Result<Cow<'a, [u8]>, NoSections> {
    let damaged = |why| NoSections::Damaged { section: name, why };
    let data = section.compressed_data().map_err(|why| damaged(why.into()))?;
    if data.uncompressed_size > LARGEST {
        return Err(damaged(Damage::Huge(data.uncompressed_size)));
    }
    match data.format {
        CompressionFormat::None => Ok(Cow::Borrowed(data.data)),
        CompressionFormat::Zlib => {
            let mut whole = Vec::new();
            // Reading one byte more than the header says shows that the section is longer.
            let mut decoder = ZlibDecoder::new(data.data).take(data.uncompressed_size + 1);
            decoder.read_to_end(&mut whole).map_err(|why| damaged(why.into()))?;
            if whole.len() as u64 != data.uncompressed_size {
                return Err(damaged(Damage::Length));
            }
            Ok(Cow::Owned(whole))
        }
        _ => Err(NoSections::Compressed { section: name }),
    }
}
