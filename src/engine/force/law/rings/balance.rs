//! The balance of the air at the rings of a canopy, in numbers: the pressure on each band of cloth between two rings.
//!
//! ```text
//! ring j, from the vent or apex (0) to the skirt (N); band b between rings b and b + 1
//! u_j = [R_j + A_0 w_v + sum_b<j s_b w_b(dp_b)]/A_j        air that passes the disc of a ring, u_0 = w_v
//! P_b = q - H_b - L_b+1 - Cb q + t_b Cb (q/|q|) (K_N+ - L_N),      dp_b = P_b+
//! K_j = rho/2 u_j|u_j|,   H_b the same of (u_b + u_b+1)/2,   L_j = L_j+1 + (K_j - |q| - L_j+1)+,   L_N+1 = 0
//! w_b = 2 dp/(a + sqrt(a^2 + 4 b dp)) + 0.65 l_b sqrt(2 dp/rho),   w_v = 0.6 sqrt(2 dp_0/rho)
//! ```
//! y+ is the positive part, a parabola for |y| < E, E = 0.01 sqrt(q^2 + (1 Pa)^2), so that it has a slope; K_N+ has one
//! as it is. The corners of L_j are N times sharper, so that all of them add up to no more. The root is bent below E
//! too. Above it both are exact.
//!
//! dp = D(u(dp)) is solved by Newton's method in the N pressures. Its Jacobian J also gives the slopes:
//! ```text
//! J = I + D' M du/d(dp),   M_bj = -dP_b/du_j,       d(dp_b) = sum_c y_c dD_c,   J^T y = e_b
//! ```
//! D is homogeneous of degree 1 in q, K, H and E, which gives its slope by E without more formulas.

/// Bands at most.
pub(in crate::force) const MOST_BANDS: usize = 32;
/// A number by band; beyond the last band 0.
pub(in crate::force) type ByBand = [f64; MOST_BANDS];
/// A number by ring; beyond the last ring 0.
pub(in crate::force) type ByRing = [f64; MOST_BANDS + 1];

/// [-] E over q.
const CORNER: f64 = 0.01;
/// [Pa] Dynamic pressure below which E does not fall further.
const STILL: f64 = 1.0;
/// [-] Residual over q at which the pressures are found.
const FOUND: f64 = 1e-13;
/// [-] The same where rounding stops the iteration.
const NEARLY: f64 = 1e-10;
/// Newton's iterations at most. Most states take three to six, a tube of porous cloth whose bands fold and open up to
/// thirty.
const ITERATIONS: usize = 100;
/// [-] Least part of a step of Newton's that is tried.
const LEAST_SHARE: f64 = 1e-2;
/// [-] Half widths of corners, over E, on the way to those of 1.
const WIDER_CORNERS: [f64; 9] = [100.0, 50.0, 25.0, 12.0, 6.0, 3.0, 2.0, 1.4, 1.0];

/// A value and its slope.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slope {
    pub value: f64,
    pub by: f64,
}

/// The positive part of y, a parabola for |y| < e.
pub(super) fn positive(y: f64, e: f64) -> Slope {
    if y >= e {
        Slope { value: y, by: 1.0 }
    } else if y > -e {
        Slope { value: (y + e) * (y + e) / (4.0 * e), by: (y + e) / (2.0 * e) }
    } else {
        Slope::default()
    }
}

/// The root of y, a parabola for y < e; odd, for iterates below 0.
fn root(y: f64, e: f64) -> Slope {
    let size = y.abs();
    if size >= e {
        Slope { value: y.signum() * size.sqrt(), by: 0.5 / size.sqrt() }
    } else {
        let (share, unit) = (size / e, e.sqrt());
        Slope { value: unit * y / e * (1.5 - 0.5 * share), by: (1.5 - share) / unit }
    }
}

/// How air passes the bands and the vent.
#[derive(Clone, Debug)]
pub(crate) struct Passage {
    /// [Pa s/m, Pa s^2/m^2] a and b of the cloth; none lets no air through
    pub cloth: Option<[f64; 2]>,
    /// [-] discharge coefficient times the share of each band that is open as slots
    pub slots: Vec<f64>,
    /// [-] discharge coefficient of the vent
    pub vent: f64,
}

/// Speeds through a band or the vent.
#[derive(Clone, Copy, Debug, Default)]
struct Through {
    /// [m/s] w
    speed: f64,
    /// [m/(s Pa)] dw/d(dp)
    slope: f64,
    /// [m/s] E dw/dE
    by_corner: f64,
    /// [m/s] the part that goes with 1/sqrt(rho)
    orifice: f64,
}

impl Through {
    fn new(cloth: Option<[f64; 2]>, discharge: f64, dp: f64, [e, density]: [f64; 2]) -> Self {
        let bent = root(dp, e);
        let unit = discharge * (2.0 / density).sqrt();
        let (viscous, inertial) = match cloth {
            None | Some([0.0, 0.0]) => (Slope::default(), 0.0),
            Some([0.0, b]) => (Slope::default(), 1.0 / b.sqrt()),
            Some([a, b]) => {
                let slope = (a * a + 4.0 * b * dp.abs()).sqrt();
                (Slope { value: 2.0 * dp / (a + slope), by: 1.0 / slope }, 0.0)
            }
        };
        let coefficient = unit + inertial;
        Through {
            speed: viscous.value + coefficient * bent.value,
            slope: viscous.by + coefficient * bent.by,
            by_corner: coefficient * (0.5 * bent.value - dp * bent.by),
            orifice: unit * bent.value,
        }
    }
}

/// What the balance depends on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flow {
    /// number of bands, N
    pub bands: usize,
    /// [Pa] q, with the sign of the air speed
    pub q: f64,
    /// [kg/m^3]
    pub density: f64,
    /// [-] Cb, pressure outside over q
    pub outer: f64,
    /// [m^3/s] R, rates of the volumes above the rings
    pub rate: ByRing,
    /// [m^2] A; 0 at an apex
    pub area: ByRing,
    /// [m^2] s, areas of the bands that let air through
    pub open: ByBand,
    /// [-] t, from 0 above the widest ring to 1 below it
    pub below: ByBand,
}

/// How the pressure on a band depends on all of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FlowGradient {
    pub q: f64,
    pub density: f64,
    pub rate: ByRing,
    pub area: ByRing,
    pub open: ByBand,
    pub below: ByBand,
}

/// The air with given pressures on the bands.
struct Discs {
    through: [Through; MOST_BANDS],
    vent: Through,
    /// [m/s] u
    speed: ByRing,
    /// [-] slopes of L_j by K_j - |q| - L_j+1
    losing: ByRing,
    /// K_N+ and L_N
    mouth: [Slope; 2],
    /// D, and its slope by P
    pressure: [Slope; MOST_BANDS],
}

type Matrix = [ByRing; MOST_BANDS];

impl Flow {
    /// [Pa] E
    fn corner(&self) -> f64 {
        CORNER * self.q.hypot(STILL)
    }

    fn head(&self, speed: f64) -> f64 {
        0.5 * self.density * speed * speed.abs()
    }

    fn discs(&self, passage: &Passage, dp: &ByBand, e: f64) -> Discs {
        let (n, sign) = (self.bands, self.q.signum());
        let mut through = [Through::default(); MOST_BANDS];
        for b in 0..n {
            through[b] = Through::new(passage.cloth, passage.slots[b], dp[b], [e, self.density]);
        }
        let vent = Through::new(None, if self.area[0] > 0.0 { passage.vent } else { 0.0 }, dp[0], [e, self.density]);
        let mut speed: ByRing = [0.0; MOST_BANDS + 1];
        speed[0] = vent.speed;
        let mut leaving = self.area[0] * vent.speed;
        for b in 0..n {
            leaving += self.open[b] * through[b].speed;
            speed[b + 1] = (self.rate[b + 1] + leaving) / self.area[b + 1];
        }
        // u|u| has a slope at 0 as it is.
        let entering = self.head(speed[n]);
        let recovering = Slope { value: entering.max(0.0), by: f64::from(entering > 0.0) };
        let mouth = [recovering, positive(entering - self.q.abs(), e)];
        let recovered = self.outer * sign * (mouth[0].value - mouth[1].value);
        let (mut losing, mut lost) = ([0.0; MOST_BANDS + 1], 0.0);
        let mut pressure = [Slope::default(); MOST_BANDS];
        for b in (0..n).rev() {
            let more = positive(self.head(speed[b + 1]) - self.q.abs() - lost, e / n as f64);
            losing[b + 1] = more.by;
            lost += more.value;
            let inside = self.q - self.head(0.5 * (speed[b] + speed[b + 1])) - lost;
            pressure[b] = positive(inside - self.outer * self.q + self.below[b] * recovered, e);
        }
        Discs { through, vent, speed, losing, mouth, pressure }
    }

    /// M
    fn heads(&self, discs: &Discs) -> Matrix {
        let (n, sign) = (self.bands, self.q.signum());
        let mut heads = [[0.0; MOST_BANDS + 1]; MOST_BANDS];
        let by_speed = |j: usize| self.density * discs.speed[j].abs();
        let [recovered, lost] = discs.mouth;
        for (b, row) in heads.iter_mut().enumerate().take(n) {
            let half = 0.25 * self.density * (discs.speed[b] + discs.speed[b + 1]).abs();
            row[b] += half;
            row[b + 1] += half;
            let mut passed = 1.0;
            for (j, entry) in row.iter_mut().enumerate().take(n + 1).skip(b + 1) {
                *entry += passed * discs.losing[j] * by_speed(j);
                passed *= 1.0 - discs.losing[j];
            }
            row[n] -= self.outer * sign * self.below[b] * (recovered.by - lost.by) * by_speed(n);
        }
        heads
    }

    /// J
    fn jacobian(&self, discs: &Discs, heads: &Matrix) -> Matrix {
        let n = self.bands;
        let mut jacobian = [[0.0; MOST_BANDS + 1]; MOST_BANDS];
        for (b, (row, of_speed)) in jacobian.iter_mut().zip(heads).enumerate().take(n) {
            let by_speed = discs.pressure[b].by;
            let mut below = 0.0;
            for c in (0..n).rev() {
                below += of_speed[c + 1] / self.area[c + 1];
                row[c] = by_speed * below * self.open[c] * discs.through[c].slope;
            }
            row[0] += by_speed * (of_speed[0] + below * self.area[0]) * discs.vent.slope;
            row[b] += 1.0;
        }
        jacobian
    }

    /// [Pa] dp
    ///
    /// Where Newton's method stops, because many corners are near, they are rounded off more and then less again.
    pub(in crate::force) fn pressures(&self, passage: &Passage) -> ByBand {
        let mut dp = [0.0; MOST_BANDS];
        dp[..self.bands].fill((1.0 - self.outer) * self.q.max(0.0));
        if self.iterate(passage, &mut dp, self.corner()) {
            return dp;
        }
        for wider in WIDER_CORNERS {
            self.iterate(passage, &mut dp, wider * self.corner());
        }
        dp
    }

    /// Newton's method with corners of the half width `e` [Pa]; whether it has found dp.
    fn iterate(&self, passage: &Passage, dp: &mut ByBand, e: f64) -> bool {
        let n = self.bands;
        let residual = |dp: &ByBand, discs: &Discs| {
            let mut r: ByRing = [0.0; MOST_BANDS + 1];
            (0..n).for_each(|b| r[b] = dp[b] - discs.pressure[b].value);
            r
        };
        let size = |r: &ByRing| r[..n].iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let mut discs = self.discs(passage, dp, e);
        let mut r = residual(dp, &discs);
        let scale = self.q.hypot(STILL);
        for _ in 0..ITERATIONS {
            let before = size(&r);
            if before.is_nan() || before <= FOUND * scale {
                return true;
            }
            let mut step = r;
            solve(&mut self.jacobian(&discs, &self.heads(&discs)), &mut step, n);
            let mut share = 1.0;
            let taken = loop {
                let mut next = *dp;
                (0..n).for_each(|b| next[b] -= share * step[b]);
                let discs = self.discs(passage, &next, e);
                let r = residual(&next, &discs);
                if size(&r) < before {
                    break Some((next, discs, r));
                }
                share *= 0.5;
                if share < LEAST_SHARE {
                    break None;
                }
            };
            // Rounding stops the fall, too.
            let Some(next) = taken else { return before <= NEARLY * scale };
            (*dp, discs, r) = next;
        }
        false
    }

    /// How the pressure on a band depends on everything, where the pressures are `dp` [Pa]; `None` where it does not,
    /// because the cloth is folded.
    pub(in crate::force) fn gradient(&self, passage: &Passage, dp: &ByBand, band: usize) -> Option<FlowGradient> {
        let (n, sign) = (self.bands, self.q.signum());
        let discs = self.discs(passage, dp, self.corner());
        if discs.pressure[band].by == 0.0 {
            return None;
        }
        let heads = self.heads(&discs);
        let jacobian = self.jacobian(&discs, &heads);
        let mut transposed = [[0.0; MOST_BANDS + 1]; MOST_BANDS];
        for (b, row) in transposed.iter_mut().enumerate().take(n) {
            (0..n).for_each(|c| row[c] = jacobian[c][b]);
        }
        let mut y: ByRing = [0.0; MOST_BANDS + 1];
        y[band] = 1.0;
        solve(&mut transposed, &mut y, n);
        // By u_j, and by it over A_j.
        let (mut by_speed, mut by_flow) = ([0.0; MOST_BANDS + 1], [0.0; MOST_BANDS + 1]);
        for j in 0..=n {
            by_speed[j] = -(0..n).map(|c| y[c] * discs.pressure[c].by * heads[c][j]).sum::<f64>();
            by_flow[j] = if self.area[j] > 0.0 { by_speed[j] / self.area[j] } else { 0.0 };
        }
        let mut g = FlowGradient {
            q: 0.0,
            density: 0.0,
            rate: by_flow,
            area: [0.0; MOST_BANDS + 1],
            open: [0.0; MOST_BANDS],
            below: [0.0; MOST_BANDS],
        };
        g.rate[0] = 0.0;
        let (mut by_orifice, mut by_corner, mut flow_below) = (0.0, 0.0, 0.0);
        for b in (0..n).rev() {
            flow_below += by_flow[b + 1];
            g.open[b] = flow_below * discs.through[b].speed;
            by_orifice += flow_below * self.open[b] * discs.through[b].orifice;
            by_corner += flow_below * self.open[b] * discs.through[b].by_corner;
            g.area[b + 1] = -by_flow[b + 1] * discs.speed[b + 1];
        }
        g.area[0] = flow_below * discs.vent.speed;
        let by_vent = by_speed[0] + flow_below * self.area[0];
        by_orifice += by_vent * discs.vent.orifice;
        by_corner += by_vent * discs.vent.by_corner;
        let by_heads = (0..=n).map(|j| 0.5 * by_speed[j] * discs.speed[j]).sum::<f64>();
        g.density = (by_heads - 0.5 * by_orifice) / self.density;
        // L_N and L_b+1 by |q|.
        let [recovered, lost] = discs.mouth;
        let mut loss = 0.0;
        for b in (0..n).rev() {
            loss = loss * (1.0 - discs.losing[b + 1]) - discs.losing[b + 1];
            let by_q = 1.0 - self.outer - sign * loss + self.outer * self.below[b] * lost.by;
            let Slope { value, by } = discs.pressure[b];
            g.q += y[b] * by * by_q;
            g.below[b] = y[b] * by * self.outer * sign * (recovered.value - lost.value);
            by_corner += y[b] * (value - by * self.q * by_q);
        }
        by_corner -= by_heads;
        g.q += by_corner * self.q / (self.q * self.q + STILL * STILL);
        Some(g)
    }
}

/// Solves a x = b of n unknowns in place, by elimination with pivots.
fn solve(a: &mut Matrix, b: &mut ByRing, n: usize) {
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap_or(k);
        a.swap(k, pivot);
        b.swap(k, pivot);
        let (above, below) = a.split_at_mut(k + 1);
        let row = &above[k];
        for (i, other) in below.iter_mut().enumerate().take(n - k - 1) {
            let share = other[k] / row[k];
            if share != 0.0 {
                (k + 1..n).for_each(|j| other[j] -= share * row[j]);
                b[k + 1 + i] -= share * b[k];
            }
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
}

#[cfg(test)]
mod tests;
