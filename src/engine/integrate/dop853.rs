//! The method of order 8 of Dormand & Prince (Prince & Dormand 1981) with the two estimates of Hairer, Norsett & Wanner
//! (1993, section II.10 and its code DOP853). Twelve evaluations a step: eleven stages beyond the first, and the new
//! point, which is the first of the next.
//!
//! The estimate joins solutions of order 5 and 3, e = |e5|^2 / sqrt(|e5|^2 + 0.01 |e3|^2): as e5 falls as h^6 and e3 as
//! h^4, it falls as h^8, and does not vanish where either does by chance. Norms are taken separately over all positions
//! and over all velocities, since the two have different units; the estimate of a degree of freedom is its part of e5
//! times |e5| / sqrt(|e5|^2 + 0.01 |e3|^2).
//!
//! Coefficients are those of that code, rounded to doubles. On linear problems a step is R(z) = sum over k <= 8 of
//! z^k/k! + 0.9768 z^9/9! + 0.8496 z^10/10! + 0.5967 z^11/11! + 0.1731 z^12/12!, which damps undamped oscillations a
//! little up to w h = 5.96.

use super::PairInfo;
use super::runge_kutta::{Estimate, Pair, Stage, Tableau};

/// [-] R - e^z over e and over z: 6.404e-8 z^9; e5 = 1.350e-5 z^6 and e3 = 4.202e-3 z^4, so e = 4.334e-7 z^8. Steps get
/// ten times as much, by measurement (`tests/claims/tolerance.rs`): a controller of order 8 settles at a quarter of the
/// error of one of order 4. For nonlinear forces e5 overestimates the error.
pub(super) const LINEAR: f64 = 6.404e-8 / 4.334e-7;

pub(super) static TABLEAU: Tableau = Tableau {
    stages: &[
        Stage { c: 0.05260015195876773, a: &[0.05260015195876773] },
        Stage { c: 0.0789002279381516, a: &[0.0197250569845379, 0.0591751709536137] },
        Stage { c: 0.1183503419072274, a: &[0.02958758547680685, 0.0, 0.08876275643042054] },
        Stage { c: 0.2816496580927726, a: &[0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792] },
        Stage { c: 1.0 / 3.0, a: &[0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242] },
        Stage { c: 1.0 / 4.0, a: &[0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125] },
        Stage {
            c: 4.0 / 13.0,
            a: &[
                0.03709200011850479,
                0.0,
                0.0,
                0.17038392571223998,
                0.10726203044637328,
                -0.015319437748624402,
                0.008273789163814023,
            ],
        },
        Stage {
            c: 127.0 / 195.0,
            a: &[
                0.6241109587160757,
                0.0,
                0.0,
                -3.3608926294469414,
                -0.868219346841726,
                27.59209969944671,
                20.154067550477894,
                -43.48988418106996,
            ],
        },
        Stage {
            c: 3.0 / 5.0,
            a: &[
                0.47766253643826434,
                0.0,
                0.0,
                -2.4881146199716677,
                -0.590290826836843,
                21.230051448181193,
                15.279233632882423,
                -33.28821096898486,
                -0.020331201708508627,
            ],
        },
        Stage {
            c: 6.0 / 7.0,
            a: &[
                -0.9371424300859873,
                0.0,
                0.0,
                5.186372428844064,
                1.0914373489967295,
                -8.149787010746927,
                -18.52006565999696,
                22.739487099350505,
                2.4936055526796523,
                -3.0467644718982196,
            ],
        },
        Stage {
            c: 1.0,
            a: &[
                2.273310147516538,
                0.0,
                0.0,
                -10.53449546673725,
                -2.0008720582248625,
                -17.9589318631188,
                27.94888452941996,
                -2.8589982771350235,
                -8.87285693353063,
                12.360567175794303,
                0.6433927460157636,
            ],
        },
    ],
    b: &[
        0.054293734116568765,
        0.0,
        0.0,
        0.0,
        0.0,
        4.450312892752409,
        1.8915178993145003,
        -5.801203960010585,
        0.3111643669578199,
        -0.1521609496625161,
        0.20136540080403034,
        0.04471061572777259,
    ],
    pair: Some(Pair {
        estimate: Estimate::Two {
            fine: &[
                0.01312004499419488,
                0.0,
                0.0,
                0.0,
                0.0,
                -1.2251564463762044,
                -0.4957589496572502,
                1.6643771824549864,
                -0.35032884874997366,
                0.3341791187130175,
                0.08192320648511571,
                -0.022355307863886294,
            ],
            coarse: &[
                -0.18980075407240762,
                0.0,
                0.0,
                0.0,
                0.0,
                4.450312892752409,
                1.8915178993145003,
                -5.801203960010585,
                -0.42268232132379197,
                -0.1521609496625161,
                0.20136540080403034,
                0.022651792198360825,
            ],
        },
        info: PairInfo { leading: LINEAR / 10.0 },
    }),
};
