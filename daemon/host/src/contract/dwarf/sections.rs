//! The debug sections of a library, decompressed if necessary, or the reason why there are none.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Read;

use flate2::read::ZlibDecoder;
use gimli::SectionId;
use object::{CompressionFormat, Object, ObjectSection};

use super::untold::{Damage, Untold};

/// Larger sections are not read: a damaged header may claim any size.
const LARGEST: u64 = 1 << 30;

/// Contents of the debug sections, by name.
pub(super) struct Sections<'a> {
    pub(super) little_endian: bool,
    contents: HashMap<&'static str, Cow<'a, [u8]>>,
}

impl<'a> Sections<'a> {
    /// Reads the sections of the ELF file `bytes`.
    ///
    /// # Errors
    /// There is no usable debug information.
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, Untold> {
        let Ok(file) = object::File::parse(bytes) else { return Err(Untold::Nothing) };
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
                    Untold::Elsewhere { file: String::from_utf8_lossy(name).into_owned() }
                }
                _ => Untold::Nothing,
            });
        }
        Ok(Self { little_endian: file.is_little_endian(), contents })
    }

    /// The contents of a section; empty when the library has none.
    pub(super) fn get(&self, name: &str) -> &[u8] {
        self.contents.get(name).map(AsRef::as_ref).unwrap_or_default()
    }
}

/// The contents of a section, whether it is compressed or not.
fn plain<'a>(
    section: &impl ObjectSection<'a>,
    name: &'static str,
) -> Result<Cow<'a, [u8]>, Untold> {
    let damaged = |why| Untold::Damaged { section: name, why };
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
        _ => Err(Untold::Compressed { section: name }),
    }
}
