//! Pseudo-random numbers that never change between versions, so that they change neither meshes nor results.

/// SplitMix64 (Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators", figure 1).
#[derive(Clone, Debug)]
pub struct SplitMix64(u64);

impl SplitMix64 {
    /// The numbers of a seed.
    pub fn of_seed(seed: u64) -> Self {
        Self(seed)
    }

    /// Numbers for the given attempt, as at a mesh, with the given seed; other attempts have other numbers.
    pub fn new(seed: u64, attempt: u64) -> Self {
        let mut mixed = Self::of_seed(seed);
        Self(mixed.draw().wrapping_add(attempt))
    }

    /// The next 64 bits.
    pub fn draw(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// [-] evenly spread, above 0 and below 1
    pub fn uniform(&mut self) -> f64 {
        ((self.draw() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    /// [-] evenly spread in [-1, 1)
    pub(crate) fn signed(&mut self) -> f64 {
        // The upper 53 bits fill a double's mantissa exactly.
        (self.draw() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// [-] A fixed number in [-1, 1) for every index: a multiplicative hash (Fibonacci hashing, Knuth 1973, section 6.4).
/// Test vectors made of it have a part of every mode.
pub fn pseudo_random(i: usize) -> f64 {
    let hash = (i as u64).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 11;
    2.0 * (hash as f64 / (1u64 << 53) as f64) - 1.0
}

/// The linear congruential generator of Knuth's MMIX (1999), from one fixed seed. The choice between Cholesky and
/// conjugate gradients follows its numbers, and so do the bits of results.
pub struct Lcg(u64);

impl Default for Lcg {
    fn default() -> Self {
        Lcg(0x9E37_79B9_7F4A_7C15)
    }
}

impl Lcg {
    /// [-] evenly spread in [-0.5, 1.5)
    pub fn draw(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 0.5) as f32
    }
}
