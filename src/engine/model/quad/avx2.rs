//! Four numbers in a register of a processor with AVX2. `pulp` proves that it has them, so that its instructions are
//! safe to call; none is fused.

use super::{Pass, Quad, Real, VectorUnit};
use pulp::x86::V3;
use std::arch::x86_64::{__m256d, _CMP_GE_OQ, _CMP_GT_OQ};
use std::ops::{Add, Div, Mul, Sub};

/// Processors with AVX2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2(V3);

/// A register, with the proof that there are such.
#[derive(Clone, Copy, Debug)]
pub(super) struct Register(V3, __m256d);

impl Avx2 {
    #[inline]
    pub(super) fn new() -> Option<Self> {
        V3::try_new().map(Avx2)
    }

    #[inline(always)]
    pub(super) fn run<P: Pass>(self, pass: P) -> P::Output {
        self.0.vectorize(Compiled { pass, unit: self })
    }
}

struct Compiled<P> {
    pass: P,
    unit: Avx2,
}

impl<P: Pass> pulp::NullaryFnOnce for Compiled<P> {
    type Output = P::Output;

    #[inline(always)]
    fn call(self) -> P::Output {
        self.pass.run(self.unit)
    }
}

impl VectorUnit for Avx2 {
    type Quad = Register;

    #[inline(always)]
    fn quad(self, numbers: [f64; 4]) -> Register {
        Register(self.0, bytemuck::cast(numbers))
    }

    #[inline(always)]
    fn splat(self, number: f64) -> Register {
        Register(self.0, self.0.avx._mm256_set1_pd(number))
    }
}

operators! { Register:
    Add add |a, b| Register(a.0, a.0.avx._mm256_add_pd(a.1, b.1));
    Sub sub |a, b| Register(a.0, a.0.avx._mm256_sub_pd(a.1, b.1));
    Mul mul |a, b| Register(a.0, a.0.avx._mm256_mul_pd(a.1, b.1));
    Div div |a, b| Register(a.0, a.0.avx._mm256_div_pd(a.1, b.1));
}

impl Real for Register {
    #[inline(always)]
    fn all(self, number: f64) -> Self {
        Register(self.0, self.0.avx._mm256_set1_pd(number))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Register(self.0, self.0.avx._mm256_sqrt_pd(self.1))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        let avx = self.0.avx;
        Register(self.0, avx._mm256_andnot_pd(avx._mm256_set1_pd(-0.0), self.1))
    }

    #[inline(always)]
    fn where_positive(self, sign: Self) -> Self {
        let avx = self.0.avx;
        let positive = avx._mm256_cmp_pd::<_CMP_GT_OQ>(sign.1, avx._mm256_setzero_pd());
        Register(self.0, avx._mm256_and_pd(self.1, positive))
    }

    #[inline(always)]
    fn where_not_negative(self, sign: Self) -> Self {
        let avx = self.0.avx;
        let not_negative = avx._mm256_cmp_pd::<_CMP_GE_OQ>(sign.1, avx._mm256_setzero_pd());
        Register(self.0, avx._mm256_and_pd(self.1, not_negative))
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Register(self.0, self.0.avx._mm256_max_pd(self.1, other.1))
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        Register(self.0, self.0.avx._mm256_min_pd(self.1, other.1))
    }

    #[inline(always)]
    fn any_positive(self) -> bool {
        let avx = self.0.avx;
        avx._mm256_movemask_pd(avx._mm256_cmp_pd::<_CMP_GT_OQ>(self.1, avx._mm256_setzero_pd())) != 0
    }
}

impl Quad for Register {
    #[inline(always)]
    fn numbers(self) -> [f64; 4] {
        bytemuck::cast(self.1)
    }

    #[inline(always)]
    fn columns([a, b, c, d]: [Self; 4]) -> [Self; 3] {
        let avx = a.0.avx;
        let (low, high) = (avx._mm256_unpacklo_pd(a.1, b.1), avx._mm256_unpackhi_pd(a.1, b.1));
        let (low2, high2) = (avx._mm256_unpacklo_pd(c.1, d.1), avx._mm256_unpackhi_pd(c.1, d.1));
        [
            avx._mm256_permute2f128_pd::<0x20>(low, low2),
            avx._mm256_permute2f128_pd::<0x20>(high, high2),
            avx._mm256_permute2f128_pd::<0x31>(low, low2),
        ]
        .map(|r| Register(a.0, r))
    }

    #[inline(always)]
    fn rows([x, y, z]: [Self; 3]) -> [Self; 4] {
        let avx = x.0.avx;
        let zero = avx._mm256_setzero_pd();
        let (xy, xy2) = (avx._mm256_unpacklo_pd(x.1, y.1), avx._mm256_unpackhi_pd(x.1, y.1));
        let (z, z2) = (avx._mm256_unpacklo_pd(z.1, zero), avx._mm256_unpackhi_pd(z.1, zero));
        [
            avx._mm256_permute2f128_pd::<0x20>(xy, z),
            avx._mm256_permute2f128_pd::<0x20>(xy2, z2),
            avx._mm256_permute2f128_pd::<0x31>(xy, z),
            avx._mm256_permute2f128_pd::<0x31>(xy2, z2),
        ]
        .map(|r| Register(x.0, r))
    }

    #[inline(always)]
    fn pack([a, b, c, d]: [Self; 4]) -> [Self; 3] {
        let (avx, avx2) = (a.0.avx, a.0.avx2);
        let (b0, b12) = (avx2._mm256_permute4x64_pd::<0x00>(b.1), avx2._mm256_permute4x64_pd::<0x09>(b.1));
        let (c01, c2) = (avx2._mm256_permute4x64_pd::<0x40>(c.1), avx2._mm256_permute4x64_pd::<0x02>(c.1));
        let d012 = avx2._mm256_permute4x64_pd::<0x90>(d.1);
        [
            avx._mm256_blend_pd::<0b1000>(a.1, b0),
            avx._mm256_blend_pd::<0b1100>(b12, c01),
            avx._mm256_blend_pd::<0b1110>(c2, d012),
        ]
        .map(|r| Register(a.0, r))
    }

    #[inline(always)]
    fn unpack([a, b, c]: [Self; 3]) -> [Self; 3] {
        let avx = a.0.avx;
        let xy = avx._mm256_blend_pd::<0b1100>(a.1, b.1);
        let zx = avx._mm256_permute2f128_pd::<0x21>(a.1, c.1);
        let yz = avx._mm256_blend_pd::<0b1100>(b.1, c.1);
        [
            avx._mm256_shuffle_pd::<0b1010>(xy, zx),
            avx._mm256_shuffle_pd::<0b0101>(xy, yz),
            avx._mm256_shuffle_pd::<0b1010>(zx, yz),
        ]
        .map(|r| Register(a.0, r))
    }
}
