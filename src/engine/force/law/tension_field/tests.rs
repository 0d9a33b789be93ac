use super::*;
use crate::mesh::random::pseudo_random;
use std::f64::consts::TAU;

/// Isotropic, with and without Poisson's ratio, woven cloth that is soft in shear, and a ribbon much stiffer than its
/// matrix.
fn sheets() -> impl Iterator<Item = Sheet> {
    [(0.0, 2.0), (0.3, 2.6), (0.2, 0.9), (0.1, 60.0), (0.05, 5e3), (0.45, 1.3)]
        .into_iter()
        .map(|(poisson, compliance)| Sheet { poisson, compliance, wrinkles: true })
}

fn strains() -> impl Iterator<Item = Voigt> {
    (0..400).map(|i| [0, 1, 2].map(|j| pseudo_random(3 * i + j) * [1.0, 1.0, 2.0][j]))
}

fn dot(a: Voigt, b: Voigt) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// W as a maximum over many directions, or over all stresses without compression if the sheet is taut.
fn energy_by_search(sheet: &Sheet, e: Voigt) -> f64 {
    let full = sheet.full(e);
    if smallest_principal(full) >= 0.0 {
        return 0.5 * dot(full, e);
    }
    let energy = |phi: f64| {
        let t = [0.5 * (1.0 + phi.cos()), 0.5 * (1.0 - phi.cos()), 0.5 * phi.sin()];
        let c = sheet.a() + sheet.b() * phi.cos().powi(2);
        0.5 * dot(t, e).max(0.0).powi(2) / c
    };
    let best = (0..20_000).map(|i| f64::from(i) * TAU / 20_000.0).max_by(|a, b| energy(*a).total_cmp(&energy(*b)));
    let (mut at, mut width) = (best.unwrap_or_default(), TAU / 20_000.0);
    for _ in 0..60 {
        width *= 0.7;
        at = [at - width, at, at + width].into_iter().fold(at, |a, b| if energy(b) > energy(a) { b } else { a });
    }
    energy(at)
}

#[test]
fn the_energy_is_the_largest_over_all_directions() {
    let mut states = [0; 3];
    for (sheet, e) in sheets().flat_map(|sheet| strains().map(move |e| (sheet, e))) {
        let (found, expected) = (0.5 * dot(sheet.stress(e), e), energy_by_search(&sheet, e));
        assert!((found - expected).abs() < 1e-10 * expected.max(1e-3), "{sheet:?} {e:?}: {found} and not {expected}");
        states[sheet.wrinkling(e) as usize] += 1;
    }
    assert!(states.iter().all(|count| *count > 100), "{states:?}");
}

#[test]
fn stress_and_tangent_are_derivatives() {
    const H: f64 = 1e-6;
    for (sheet, e) in sheets().flat_map(|sheet| strains().map(move |e| (sheet, e))) {
        let moved = |j: usize, by: f64| {
            let mut e = e;
            e[j] += by;
            e
        };
        if (0..3).any(|j| [-H, H].map(|by| sheet.wrinkling(moved(j, by))) != [sheet.wrinkling(e); 2]) {
            continue;
        }
        let tangent = sheet.tangent(e);
        for j in 0..3 {
            let [low, high] = [-H, H].map(|by| sheet.stress(moved(j, by)));
            for i in 0..3 {
                let expected = (high[i] - low[i]) / (2.0 * H);
                let size = 1.0 + expected.abs();
                assert!((tangent[i][j] - expected).abs() < 1e-6 * size, "{sheet:?} {e:?}: {tangent:?}, {expected}");
            }
            let energies = [-H, H].map(|by| 0.5 * dot(sheet.stress(moved(j, by)), moved(j, by)));
            let stress = (energies[1] - energies[0]) / (2.0 * H);
            // The third derivative that the difference leaves out grows with the compliance.
            let tolerance = 1e-8 + 1e-12 * sheet.compliance.powi(2);
            assert!((sheet.stress(e)[j] - stress).abs() < tolerance, "{sheet:?} {e:?}");
        }
    }
}

/// S : (E - E') >= 0 for the differences: damping by this law never makes energy.
#[test]
fn stress_is_monotone() {
    let pairs = || strains().zip(strains().skip(7));
    for (sheet, (a, b)) in sheets().flat_map(|sheet| pairs().map(move |pair| (sheet, pair))) {
        let [s, t] = [sheet.stress(a), sheet.stress(b)];
        let work: f64 = (0..3).map(|i| (s[i] - t[i]) * (a[i] - b[i])).sum();
        assert!(work >= -1e-12, "{sheet:?}: {work}");
    }
}
