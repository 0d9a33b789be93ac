//! A small pseudo-random generator whose numbers never change between versions, so that a seed keeps its mesh.

/// SplitMix64 (Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators", figure 1).
#[derive(Clone, Debug)]
pub(super) struct SplitMix64(u64);

impl SplitMix64 {
    /// Numbers for the given attempt at a mesh with the given seed.
    pub fn new(seed: u64, attempt: u64) -> Self {
        let mut mixed = Self(seed);
        Self(mixed.next().wrapping_add(attempt))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// [-] evenly spread in [-1, 1)
    pub fn signed(&mut self) -> f64 {
        // The upper 53 bits fill a double's mantissa exactly.
        (self.next() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}
