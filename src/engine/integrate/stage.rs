//! The stage map that the implicit schemes fill with a few coefficients.

/// Velocity and acceleration at the end of a step as functions of the step's displacement z = x_{n+1} - x_n:
/// ```text
/// v_{n+1} = cv z + vv v_n + va a_n
/// a_{n+1} = ca z + av v_n + aa a_n
/// r = M [(1 - am) a_{n+1} + am a_n] - [(1 - af) f_{n+1} + af f_n]
/// dr/dz = W = (1 - am) ca M + (1 - af) (cv C + K)
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageMap {
    /// [1/s] dv_{n+1}/dz
    pub cv: f64,
    /// [-] share of v_n in v_{n+1}
    pub vv: f64,
    /// [s] share of a_n in v_{n+1}
    pub va: f64,
    /// [1/s^2] da_{n+1}/dz
    pub ca: f64,
    /// [1/s] share of v_n in a_{n+1}
    pub av: f64,
    /// [-] share of a_n in a_{n+1}
    pub aa: f64,
    /// [-] weight of the old inertia (generalised alpha's alpha_m)
    pub am: f64,
    /// [-] weight of the old forces (generalised alpha's alpha_f, HHT's -alpha)
    pub af: f64,
}

impl StageMap {
    /// [-] Share of a step by which the carried acceleration lags behind the true one if that changes linearly: with
    /// a_n = M^-1 (f_n - lag (f_{n+1} - f_n)) both terms of r grow alike.
    pub fn lag(&self) -> f64 {
        self.af - self.am
    }

    /// Newmark's map (thesis Eq. 25-26 solved for v and a):
    /// v = gamma/(beta h) z + (1 - gamma/beta) v_n + h (1 - gamma/(2 beta)) a_n,
    /// a = 1/(beta h^2) z - 1/(beta h) v_n + (1 - 1/(2 beta)) a_n.
    pub fn newmark(NewmarkParameters { beta, gamma }: NewmarkParameters, h: f64) -> Self {
        StageMap {
            cv: gamma / (beta * h),
            vv: 1.0 - gamma / beta,
            va: h * (1.0 - gamma / (2.0 * beta)),
            ca: 1.0 / (beta * h * h),
            av: -1.0 / (beta * h),
            aa: 1.0 - 1.0 / (2.0 * beta),
            am: 0.0,
            af: 0.0,
        }
    }
}

/// Newmark's two parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewmarkParameters {
    /// [-] beta in (0, 1/2]
    pub beta: f64,
    /// [-] gamma in [1/2, 1]
    pub gamma: f64,
}
