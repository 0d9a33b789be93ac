//! Sobol' points: the same share of every box whose sides are powers of one half, as far as their number allows.
//!
//! The k-th point is the exclusive or of the direction numbers v_j at the digits j of the Gray code of k (Antonov and
//! Saleev 1979, USSR Comput. Math. Math. Phys. 19, 252-256; the order of SciPy). The numbers follow a recurrence along
//! a primitive polynomial, from first numbers that make pairs of coordinates even too: S. Joe and F. Y. Kuo 2008, SIAM
//! J. Sci. Comput. 30, 2635-2654, file new-joe-kuo-6.21201, Copyright (c) 2008 Frances Y. Kuo and Stephen Joe, which
//! may be used, copied and changed under the BSD licence of its page (three clauses, without any warranty).

/// Most coordinates of a point.
pub(super) const MOST: usize = DIRECTIONS.len();
/// Digits of a coordinate.
const DIGITS: usize = 32;

/// The direction numbers of a coordinate.
pub(super) struct Coordinate([u32; DIGITS]);

impl Coordinate {
    /// The coordinate with this number, from 0; `None` beyond [`MOST`].
    pub(super) fn new(number: usize) -> Option<Self> {
        let &(polynomial, first) = DIRECTIONS.get(number)?;
        let degree = polynomial.ilog2() as usize;
        let mut v = [0_u32; DIGITS];
        for k in 0..DIGITS {
            v[k] = match first.get(k) {
                // The first coordinate is the reversed number of the point.
                _ if degree == 0 => 1 << (DIGITS - 1 - k),
                Some(m) => m << (DIGITS - 1 - k),
                None => {
                    let terms = (1..degree).filter(|j| polynomial >> (degree - j) & 1 == 1).map(|j| v[k - j]);
                    terms.fold(v[k - degree] ^ (v[k - degree] >> degree), |sum, term| sum ^ term)
                }
            };
        }
        Some(Coordinate(v))
    }

    /// The coordinate of a point, times 2^32.
    pub(super) fn of(&self, point: u32) -> u32 {
        let gray = point ^ (point >> 1);
        self.0.iter().enumerate().filter(|(j, _)| gray >> j & 1 == 1).fold(0, |sum, (_, v)| sum ^ v)
    }
}

/// Primitive polynomials, as their coefficients in binary, and the first direction numbers.
const DIRECTIONS: [(u32, &[u32]); 40] = [
    (1, &[1]),
    (3, &[1]),
    (7, &[1, 3]),
    (11, &[1, 3, 1]),
    (13, &[1, 1, 1]),
    (19, &[1, 1, 3, 3]),
    (25, &[1, 3, 5, 13]),
    (37, &[1, 1, 5, 5, 17]),
    (41, &[1, 1, 5, 5, 5]),
    (47, &[1, 1, 7, 11, 19]),
    (55, &[1, 1, 5, 1, 1]),
    (59, &[1, 1, 1, 3, 11]),
    (61, &[1, 3, 5, 5, 31]),
    (67, &[1, 3, 3, 9, 7, 49]),
    (91, &[1, 1, 1, 15, 21, 21]),
    (97, &[1, 3, 1, 13, 27, 49]),
    (103, &[1, 1, 1, 15, 7, 5]),
    (109, &[1, 3, 1, 15, 13, 25]),
    (115, &[1, 1, 5, 5, 19, 61]),
    (131, &[1, 3, 7, 11, 23, 15, 103]),
    (137, &[1, 3, 7, 13, 13, 15, 69]),
    (143, &[1, 1, 3, 13, 7, 35, 63]),
    (145, &[1, 3, 5, 9, 1, 25, 53]),
    (157, &[1, 3, 1, 13, 9, 35, 107]),
    (167, &[1, 3, 1, 5, 27, 61, 31]),
    (171, &[1, 1, 5, 11, 19, 41, 61]),
    (185, &[1, 3, 5, 3, 3, 13, 69]),
    (191, &[1, 1, 7, 13, 1, 19, 1]),
    (193, &[1, 3, 7, 5, 13, 19, 59]),
    (203, &[1, 1, 3, 9, 25, 29, 41]),
    (211, &[1, 3, 5, 13, 23, 1, 55]),
    (213, &[1, 3, 7, 3, 13, 59, 17]),
    (229, &[1, 3, 1, 3, 5, 53, 69]),
    (239, &[1, 1, 5, 5, 23, 33, 13]),
    (241, &[1, 1, 7, 7, 1, 61, 123]),
    (247, &[1, 1, 7, 9, 13, 61, 49]),
    (253, &[1, 3, 3, 5, 3, 55, 33]),
    (285, &[1, 3, 1, 15, 31, 13, 49, 245]),
    (299, &[1, 3, 5, 15, 31, 59, 63, 97]),
    (301, &[1, 3, 1, 11, 11, 11, 77, 249]),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Those of SciPy 1.17.1, `scipy.stats.qmc.Sobol(40, scramble=False, bits=32).random(64)`, times 2^32.
    #[test]
    fn points_are_those_of_scipy() {
        for (point, number, expected) in [
            (1, 0, 2147483648),
            (1, 39, 2147483648),
            (5, 1, 3758096384),
            (13, 4, 1879048192),
            (37, 11, 335544320),
            (63, 39, 738197504),
            (50, 20, 2885681152),
            (42, 7, 2617245696),
        ] {
            let coordinate = Coordinate::new(number).expect("one of them");
            assert_eq!(coordinate.of(point), expected, "coordinate {number} of point {point}");
        }
        assert!(Coordinate::new(MOST).is_none());
    }

    /// Of 2^k points every interval of length 2^-k holds one, in each coordinate.
    #[test]
    fn every_interval_holds_its_share() {
        for number in 0..MOST {
            let coordinate = Coordinate::new(number).expect("one of them");
            let mut counts = [0; 256];
            (0..256).for_each(|point| counts[(coordinate.of(point) >> 24) as usize] += 1);
            assert!(counts.iter().all(|count| *count == 1), "coordinate {number}");
        }
    }
}
