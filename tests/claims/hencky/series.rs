//! What Hencky's equations give: by their series under a dead pressure, by shooting under one that follows.

/// Hencky's series for a Poisson ratio.
pub struct Series {
    /// n(rho) in powers of rho^2
    pub n: Vec<f64>,
    /// 1/n in powers of rho^2
    inverse: Vec<f64>,
}

impl Series {
    /// The terms fall like 0.6^k; 60 leave 1e-13.
    const TERMS: usize = 60;

    pub fn of(poisson: f64) -> Self {
        let edge = |s: &Series| s.n.iter().zip(0..).map(|(a, k)| a * (2.0 * f64::from(k) + 1.0 - poisson)).sum::<f64>();
        // A smaller n(0) falls faster towards the edge.
        let (mut low, mut high) = (0.3, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if edge(&Series::from_centre(middle)) < 0.0 { &mut low } else { &mut high }) = middle;
        }
        Series::from_centre(high)
    }

    fn from_centre(n0: f64) -> Self {
        let product = |a: &[f64], b: &[f64], k: usize| (0..=k).map(|i| a[i] * b[k - i]).sum::<f64>();
        let (mut n, mut inverse) = (vec![n0], vec![1.0 / n0]);
        for k in 1..Self::TERMS {
            // n'' + 3 n'/rho has the terms 4 k (k + 1) a_k rho^(2k - 2) and equals -(1/n)^2/8.
            n.push(-product(&inverse, &inverse, k - 1) / (32.0 * (k * (k + 1)) as f64));
            inverse.push(-(1..=k).map(|i| n[i] * inverse[k - i]).sum::<f64>() / n0);
        }
        Series { n, inverse }
    }

    /// w/(R q^(1/3))
    pub fn deflection(&self, rho: f64) -> f64 {
        let term = |(b, k): (&f64, i32)| b * (1.0 - rho.powi(2 * k + 2)) / (4.0 * f64::from(k + 1));
        self.inverse.iter().zip(0..).map(term).sum()
    }
}

/// d ln w(0)/d q^(2/3) that a pressure gains by following the surface: it then also pushes outwards, and acts on the
/// area that has been stretched. By shooting for n(0) with u(1) = 0, e = q^(2/3) being the switch:
/// ```text
/// w' = -(rho/2 + e u)/n,   n_t = u/rho + nu n,   rho n' = n_t - n + e rho w',   u' = n - nu n_t - w'^2/2
/// ```
pub fn follower_gain(poisson: f64) -> f64 {
    let slope = |e: f64, rho: f64, y: [f64; 3]| {
        let [n, u, _] = y;
        let (dw, around) = (-(0.5 * rho + e * u) / n, u / rho + poisson * n);
        [(around - n) / rho + e * dw, n - poisson * around - 0.5 * dw * dw, dw]
    };
    // n, u and w at the edge by the classical Runge-Kutta method
    let edge = |e: f64, n0: f64| {
        let (start, steps) = (1e-3, 2000);
        let h = (1.0 - start) / f64::from(steps);
        let mut y = [n0, (1.0 - poisson) * n0 * start, 0.0];
        for i in 0..steps {
            let rho = start + h * f64::from(i);
            let ahead = |s: f64, k: [f64; 3]| slope(e, rho + s, std::array::from_fn(|c| y[c] + s * k[c]));
            let k1 = slope(e, rho, y);
            let (k2, k3) = (ahead(0.5 * h, k1), ahead(0.5 * h, ahead(0.5 * h, k1)));
            let k4 = ahead(h, k3);
            y = std::array::from_fn(|c| y[c] + h / 6.0 * (k1[c] + 2.0 * (k2[c] + k3[c]) + k4[c]));
        }
        y
    };
    let height = |e: f64| {
        let (mut low, mut high) = (0.3, 1.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            *(if edge(e, middle)[1] < 0.0 { &mut low } else { &mut high }) = middle;
        }
        -edge(e, high)[2]
    };
    let e = 1e-3;
    (height(e) / height(-e)).ln() / (2.0 * e)
}
