//! Four numbers side by side, in one vector register where the machine has one.
//!
//! A kernel is written once, as its equations on [`Quad`]s, and compiled for each [`VectorUnit`]; [`run`] takes the
//! best one this machine has. No operation is fused or reordered, so that all units give the same bits.

use std::ops::{Add, Div, Mul, Sub};

/// The vector unit that a kernel is compiled for; a value proves that the machine has it.
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

/// A number, or several side by side: the type of numbers in force laws. Operations are element by element.
pub trait Real: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> {
    /// One number in all elements.
    fn all(self, number: f64) -> Self;

    /// Square roots.
    fn sqrt(self) -> Self;

    /// Absolute values.
    fn abs(self) -> Self;

    /// `self` where `sign` is above zero, else 0.
    fn where_positive(self, sign: Self) -> Self;

    /// `self` where `sign` is zero or above, else 0.
    fn where_not_negative(self, sign: Self) -> Self;

    /// `self` where it is above `other`, else `other`.
    fn larger(self, other: Self) -> Self;

    /// `self` where it is below `other`, else `other`.
    fn smaller(self, other: Self) -> Self;

    /// Whether some element is above zero.
    fn any_positive(self) -> bool;
}

impl Real for f64 {
    #[inline(always)]
    fn all(self, number: f64) -> f64 {
        number
    }

    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }

    #[inline(always)]
    fn where_positive(self, sign: f64) -> f64 {
        if sign > 0.0 { self } else { 0.0 }
    }

    #[inline(always)]
    fn where_not_negative(self, sign: f64) -> f64 {
        if sign >= 0.0 { self } else { 0.0 }
    }

    #[inline(always)]
    fn larger(self, other: f64) -> f64 {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn smaller(self, other: f64) -> f64 {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn any_positive(self) -> bool {
        self > 0.0
    }
}

/// Four numbers.
pub trait Quad: Real {
    /// The numbers.
    fn numbers(self) -> [f64; 4];

    /// First, second and third numbers of four records.
    fn columns(rows: [Self; 4]) -> [Self; 3];

    /// Four records from three columns, with zeros as fourth numbers.
    fn rows(columns: [Self; 3]) -> [Self; 4];

    /// First, second and third numbers of four records, record after record.
    fn pack(rows: [Self; 4]) -> [Self; 3];

    /// First, second and third numbers of four records that are packed.
    fn unpack(packed: [Self; 3]) -> [Self; 3];
}

/// A loop that can be compiled for every vector unit.
pub trait Pass {
    /// what it returns
    type Output;

    /// The loop; `#[inline(always)]`, as everything it calls.
    fn run<U: VectorUnit>(self, unit: U) -> Self::Output;
}

/// Runs a loop on the best unit of this machine.
#[inline]
pub fn run<P: Pass>(pass: P) -> P::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = avx2::Avx2::new() {
        return unit.run(pass);
    }
    pass.run(Portable)
}

/// The unit of any machine.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

impl VectorUnit for Portable {
    type Quad = Plain;

    #[inline(always)]
    fn quad(self, numbers: [f64; 4]) -> Plain {
        Plain(numbers)
    }
}

/// Four numbers in an array.
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

impl Real for Plain {
    #[inline(always)]
    fn all(self, number: f64) -> Self {
        Plain([number; 4])
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
        self.zip(sign, f64::where_positive)
    }

    #[inline(always)]
    fn where_not_negative(self, sign: Self) -> Self {
        self.zip(sign, f64::where_not_negative)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        self.zip(other, f64::larger)
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        self.zip(other, f64::smaller)
    }

    #[inline(always)]
    fn any_positive(self) -> bool {
        let [a, b, c, d] = self.0;
        a > 0.0 || b > 0.0 || c > 0.0 || d > 0.0
    }
}

impl Quad for Plain {
    #[inline(always)]
    fn numbers(self) -> [f64; 4] {
        self.0
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

    #[inline(always)]
    fn pack(rows: [Self; 4]) -> [Self; 3] {
        let [a, b, c, d] = rows.map(Quad::numbers);
        [[a[0], a[1], a[2], b[0]], [b[1], b[2], c[0], c[1]], [c[2], d[0], d[1], d[2]]].map(Plain)
    }

    #[inline(always)]
    fn unpack(packed: [Self; 3]) -> [Self; 3] {
        let [a, b, c] = packed.map(Quad::numbers);
        [[a[0], a[3], b[2], c[1]], [a[1], b[0], b[3], c[2]], [a[2], b[1], c[0], c[3]]].map(Plain)
    }
}

// Below the macro it uses.
#[cfg(target_arch = "x86_64")]
mod avx2;

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation on the same numbers.
    struct Everything([[f64; 4]; 4]);

    impl Pass for Everything {
        type Output = Vec<[f64; 4]>;

        #[inline(always)]
        fn run<U: VectorUnit>(self, unit: U) -> Vec<[f64; 4]> {
            let [a, b, c, d] = self.0.map(|numbers| unit.quad(numbers));
            let single = [a + b, a - b, a * b, a / b, a * b + c * d, a.sqrt(), a.abs(), a.where_positive(b)];
            let others = [a.where_not_negative(b), a.larger(b), a.smaller(b), a.all(3.0)];
            let any = a.all(if a.any_positive() { 1.0 } else { 0.0 });
            let single = single.into_iter().chain(others).chain([any]);
            let (columns, pack) = (U::Quad::columns([a, b, c, d]), U::Quad::pack([a, b, c, d]));
            let pack = pack.into_iter().chain(U::Quad::unpack([a, b, c]));
            let splat = unit.splat(c.numbers()[2]);
            let all = single.chain(columns).chain(U::Quad::rows(columns)).chain(pack).chain([splat]);
            all.map(Quad::numbers).collect()
        }
    }

    #[test]
    fn all_units_give_the_same_bits() {
        let special = [0.0, -0.0, 1.0, -1.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 5e-324, 1e-310, f64::MAX];
        let mut seed = 1u64;
        let mut next = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let bits = seed >> 33;
            if bits.is_multiple_of(3) { special[bits as usize / 3 % special.len()] } else { bits as f64 * 1e-6 - 1e3 }
        };
        for _ in 0..10_000 {
            let numbers = [[0.0; 4]; 4].map(|q| q.map(|_| next()));
            // The sum of two NaN values may be either of them.
            let bits = |n: f64| if n.is_nan() { f64::NAN.to_bits() } else { n.to_bits() };
            let best: Vec<_> = run(Everything(numbers)).into_iter().map(|q| q.map(bits)).collect();
            let plain: Vec<_> = Everything(numbers).run(Portable).into_iter().map(|q| q.map(bits)).collect();
            assert_eq!(best, plain, "{numbers:?}");
        }
    }

    #[test]
    fn records_become_columns_and_rows_again() {
        let rows =
            [[1.0, 2.0, 3.0, 9.0], [4.0, 5.0, 6.0, 9.0], [7.0, 8.0, 10.0, 9.0], [11.0, 12.0, 13.0, 9.0]].map(Plain);
        let columns = Plain::columns(rows);
        assert_eq!(columns.map(Quad::numbers), [[1.0, 4.0, 7.0, 11.0], [2.0, 5.0, 8.0, 12.0], [3.0, 6.0, 10.0, 13.0]]);
        let again = Plain::rows(columns).map(Quad::numbers);
        assert_eq!(again, rows.map(|r| [r.0[0], r.0[1], r.0[2], 0.0]));
        let packed = Plain::pack(rows).map(Quad::numbers);
        assert_eq!(packed, [[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0], [10.0, 11.0, 12.0, 13.0]]);
        assert_eq!(Plain::unpack(Plain::pack(rows)).map(Quad::numbers), columns.map(Quad::numbers));
    }
}
