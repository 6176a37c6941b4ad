//! Chunks that are compressed with Zstandard (RFC 8878), as those of ROS's bags are by default.

use mcap::sans_io::decompressor::{DecompressResult, Decompressor};
use mcap::{McapError, McapResult};
use ruzstd::decoding::FrameDecoder;

/// Unpacks a whole chunk at once; a chunk that has more than it says is damaged.
pub(super) struct Zstd;

impl Decompressor for Zstd {
    fn next_read_size(&self) -> usize {
        0
    }

    fn decompress(&mut self, src: &[u8], dst: &mut [u8]) -> McapResult<DecompressResult> {
        let unpacked = FrameDecoder::new().decode_all(src, dst);
        let wrote = unpacked.map_err(|why| McapError::DecompressionError(why.to_string()))?;
        Ok(DecompressResult { consumed: src.len(), wrote })
    }

    fn reset(&mut self) -> McapResult<()> {
        Ok(())
    }

    fn name(&self) -> &'static str {
        "zstd"
    }
}

#[cfg(test)]
mod tests {
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    use super::*;

    #[test]
    fn what_was_packed_comes_back_and_what_is_damaged_is_told() {
        let bytes: Vec<u8> = (0..10_000_u32).flat_map(|n| (n / 7).to_le_bytes()).collect();
        let packed = compress_to_vec(&bytes[..], CompressionLevel::Fastest);
        let mut room = vec![0; bytes.len()];
        let done = Zstd.decompress(&packed, &mut room).unwrap();
        assert_eq!((done.consumed, done.wrote), (packed.len(), bytes.len()));
        assert_eq!(room, bytes);
        // Less room than it says, or less of it than there was.
        assert!(Zstd.decompress(&packed, &mut room[1..]).is_err());
        assert!(Zstd.decompress(&packed[..packed.len() / 2], &mut room).is_err());
        assert!(Zstd.decompress(b"no frame at all", &mut room).is_err());
    }
}
