//! Four numbers side by side, in one vector register where the machine has one.
//!
//! A kernel is written once, as its equations on [`Quad`]s, and compiled for each [`VectorUnit`]; [`run`] takes the best one this machine has.
//! No operation is fused or reordered, so that all units give the same bits.

use std::ops::{Add, Div, Mul, Sub};

/// A vector and a number that means nothing, where one load takes all four.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Padded(pub [f64; 4]);

impl Padded {
    /// In a register.
    #[inline(always)]
    pub fn quad<U: VectorUnit>(&self, unit: U) -> U::Quad {
        unit.quad(self.0)
    }
}

/// What a kernel is compiled for; a proof that the machine has it.
pub trait VectorUnit: Copy {
    /// its register of four numbers
    type Quad: Quad;

    /// The four numbers.
    fn quad(self, numbers: [f64; 4]) -> Self::Quad;

    /// One number four times.
    #[inline(always)]
    fn splat(self, number: f64) -> Self::Quad {
        self.quad([number; 4])
    }
}

/// Four numbers; operations go number by number.
pub trait Quad: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> {
    /// The numbers.
    fn numbers(self) -> [f64; 4];

    /// Square roots.
    fn sqrt(self) -> Self;

    /// Without signs.
    fn abs(self) -> Self;

    /// `self` where `sign` is above zero, else 0.
    fn where_positive(self, sign: Self) -> Self;

    /// `self` where it is at least `least`, else `least`.
    fn at_least(self, least: Self) -> Self;

    /// First, second and third numbers of four records.
    fn columns(rows: [Self; 4]) -> [Self; 3];

    /// Four records of three columns, and zeros.
    fn rows(columns: [Self; 3]) -> [Self; 4];
}

/// A loop that can be compiled for every unit.
pub trait Pass {
    /// what it returns
    type Output;

    /// The loop; `#[inline(always)]`, as everything it calls.
    fn run<U: VectorUnit>(self, unit: U) -> Self::Output;
}

/// Runs a loop on the best unit this machine has.
#[inline]
pub fn run<P: Pass>(pass: P) -> P::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = avx2::Avx2::new() {
        return unit.run(pass);
    }
    pass.run(Portable)
}

/// Any machine.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

impl VectorUnit for Portable {
    type Quad = Plain;

    #[inline(always)]
    fn quad(self, numbers: [f64; 4]) -> Plain {
        Plain(numbers)
    }
}

/// Four numbers and nothing more.
#[derive(Clone, Copy, Debug)]
pub struct Plain([f64; 4]);

impl Plain {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let (a, b) = (self.0, other.0);
        Plain([f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])])
    }
}

macro_rules! operators {
    ($quad:ty: $($operator:ident $name:ident |$a:ident, $b:ident| $result:expr;)*) => {
        $(impl $operator for $quad {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                $result
            }
        })*
    };
}

operators! { Plain:
    Add add |a, b| a.zip(b, |a, b| a + b);
    Sub sub |a, b| a.zip(b, |a, b| a - b);
    Mul mul |a, b| a.zip(b, |a, b| a * b);
    Div div |a, b| a.zip(b, |a, b| a / b);
}

impl Quad for Plain {
    #[inline(always)]
    fn numbers(self) -> [f64; 4] {
        self.0
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.zip(self, |a, _| a.sqrt())
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.zip(self, |a, _| a.abs())
    }

    #[inline(always)]
    fn where_positive(self, sign: Self) -> Self {
        self.zip(sign, |a, sign| if sign > 0.0 { a } else { 0.0 })
    }

    #[inline(always)]
    fn at_least(self, least: Self) -> Self {
        self.zip(least, |a, least| if a >= least { a } else { least })
    }

    #[inline(always)]
    fn columns(rows: [Self; 4]) -> [Self; 3] {
        let [a, b, c, d] = rows.map(Quad::numbers);
        [0, 1, 2].map(|i| Plain([a[i], b[i], c[i], d[i]]))
    }

    #[inline(always)]
    fn rows(columns: [Self; 3]) -> [Self; 4] {
        let [x, y, z] = columns.map(Quad::numbers);
        [0, 1, 2, 3].map(|i| Plain([x[i], y[i], z[i], 0.0]))
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::*;
    use pulp::x86::V3;
    use std::arch::x86_64::{__m256d, _CMP_GE_OQ, _CMP_GT_OQ};

    /// Processors with AVX2.
    #[derive(Clone, Copy, Debug)]
    pub struct Avx2(V3);

    /// A register, with the proof that there are such.
    #[derive(Clone, Copy, Debug)]
    pub struct Register(V3, __m256d);

    impl Avx2 {
        #[inline]
        pub fn new() -> Option<Self> {
            V3::try_new().map(Avx2)
        }

        #[inline(always)]
        pub fn run<P: Pass>(self, pass: P) -> P::Output {
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

    impl Quad for Register {
        #[inline(always)]
        fn numbers(self) -> [f64; 4] {
            bytemuck::cast(self.1)
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
        fn at_least(self, least: Self) -> Self {
            let avx = self.0.avx;
            let above = avx._mm256_cmp_pd::<_CMP_GE_OQ>(self.1, least.1);
            Register(self.0, avx._mm256_blendv_pd(least.1, self.1, above))
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
    }
}
