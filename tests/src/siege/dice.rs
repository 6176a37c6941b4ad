//! Bytes by chance, the same for the same seed.

/// Numbers by chance (SplitMix64).
#[derive(Debug)]
pub(super) struct Dice(u64);

/// What lengths, counts and numbers are set to.
const EXTREMES: [u64; 8] =
    [0, 1, 0x7f, 0xff, 0x7fff_ffff, 0x8000_0000, u32::MAX as u64, i64::MAX as u64];

impl Dice {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn number(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number below this one.
    pub(super) fn below(&mut self, most: usize) -> usize {
        usize::try_from(self.number() >> 1).unwrap_or(0) % most.max(1)
    }

    fn byte(&mut self) -> u8 {
        self.number().to_le_bytes()[0]
    }

    /// So many bytes.
    pub(super) fn bytes(&mut self, count: usize) -> Vec<u8> {
        (0..count).map(|_| self.byte()).collect()
    }

    /// Changes some of these bytes, from the given place on.
    pub(super) fn spoil(&mut self, bytes: &mut Vec<u8>, from: usize) {
        for _ in 0..=self.below(6) {
            if bytes.len() <= from + 8 {
                return bytes.extend(self.bytes(16));
            }
            let at = from + self.below(bytes.len() - from - 8);
            let extreme = EXTREMES[self.below(EXTREMES.len())].to_le_bytes();
            match self.below(7) {
                0 => bytes[at] ^= 1 << self.below(8),
                1 => bytes[at] = self.byte(),
                2 => bytes[at..at + 2].copy_from_slice(&extreme[..2]),
                3 => bytes[at..at + 4].copy_from_slice(&extreme[..4]),
                4 => bytes[at..at + 8].copy_from_slice(&extreme),
                5 => bytes.truncate(at + 1),
                _ => {
                    let again = bytes[at..].to_vec();
                    bytes.extend(again);
                    bytes.truncate(60_000);
                }
            }
        }
    }
}
