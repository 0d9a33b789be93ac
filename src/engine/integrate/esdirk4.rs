//! A diagonally implicit method of order 4, L-stable and stiffly accurate, with an explicit first stage and gamma = 1/4
//! in the five others (Kennedy & Carpenter 2003, ARK4(3)6L[2]SA, the implicit part). Its stages are of order 2, so that
//! it keeps more of its order on stiff scenes than methods without the explicit stage.

use super::PairInfo;
use super::dirk::{Dirk, DirkTableau};
use super::implicit::SolverSpec;
use super::runge_kutta::Stage;
use super::stepper::Scheme;

/// The method.
pub fn scheme(solver: SolverSpec) -> Scheme {
    Scheme::Implicit(Box::new(Dirk::new(&TABLEAU, solver)))
}

pub(super) static TABLEAU: DirkTableau = DirkTableau {
    gamma: 0.25,
    stages: &[
        Stage { c: 0.5, a: &[0.25] },
        Stage { c: 83.0 / 250.0, a: &[8611.0 / 62500.0, -1743.0 / 31250.0] },
        Stage { c: 31.0 / 50.0, a: &[5012029.0 / 34652500.0, -654441.0 / 2922500.0, 174375.0 / 388108.0] },
        Stage {
            c: 17.0 / 20.0,
            a: &[
                15267082809.0 / 155376265600.0,
                -71443401.0 / 120774400.0,
                730878875.0 / 902184768.0,
                2285395.0 / 8070912.0,
            ],
        },
        Stage { c: 1.0, a: &[82889.0 / 524892.0, 0.0, 15625.0 / 83664.0, 69875.0 / 102672.0, -2260.0 / 8211.0] },
    ],
    estimate: &[
        82889.0 / 524892.0 - 4586570599.0 / 29645900160.0,
        0.0,
        15625.0 / 83664.0 - 178811875.0 / 945068544.0,
        69875.0 / 102672.0 - 814220225.0 / 1159782912.0,
        -2260.0 / 8211.0 + 3700637.0 / 11593932.0,
        0.25 - 61727.0 / 225920.0,
    ],
    info: PairInfo { leading: 3.79 },
};
