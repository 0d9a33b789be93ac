//! The stream: wind over time and height, and the density of the air.

use super::Series;
use std::f64::consts::TAU;

/// A one-minus-cosine gust: velocity/2 (1 - cos(2 pi (t - start)/duration)) within its duration.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct GustSpec {
    /// [m/s] at its peak
    pub velocity: [f64; 3],
    /// [s] start
    pub start: f64,
    /// [s] duration, > 0
    pub duration: f64,
}

impl GustSpec {
    /// [m/s] Its velocity at time `t` [s].
    pub fn at(&self, t: f64) -> [f64; 3] {
        let share = self.share(t);
        self.velocity.map(|v| share * v)
    }

    /// [-] Share of the velocity at its peak at time `t` [s].
    pub fn share(&self, t: f64) -> f64 {
        Self::shape((t - self.start) / self.duration)
    }

    fn shape(phase: f64) -> f64 {
        if (0.0..=1.0).contains(&phase) { 0.5 * (1.0 - (TAU * phase).cos()) } else { 0.0 }
    }

    /// [s] Its begin, peak and end. The peak is there for steps as long as a gust.
    pub fn corners(&self) -> [f64; 3] {
        [0.0, 0.5, 1.0].map(|share| self.start + share * self.duration)
    }

    /// [-] The share as a table: as trapezoidal sums of a period are exact, it has the integral of the gust.
    pub fn rows(&self) -> Series<[f64; 1]> {
        const ROWS: u32 = 32;
        let phases = || (0..=ROWS).map(|row| f64::from(row) / f64::from(ROWS));
        Series {
            t: phases().map(|phase| self.start + phase * self.duration).collect(),
            value: phases().map(|phase| [Self::shape(phase)]).collect(),
        }
    }
}

/// The density of the air over the height above sea level.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub enum AtmosphereSpec {
    /// The same at all heights.
    Constant {
        /// [kg/m^3]
        density: f64,
    },
    /// density exp(-height/scale_height)
    Exponential {
        /// [kg/m^3] at sea level
        density: f64,
        /// [m]
        scale_height: f64,
    },
    /// The standard atmosphere (ISO 2533).
    Isa,
}

/// A wind that begins with an event; there is none of it before.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct EventWind {
    /// the event
    pub event: usize,
    /// over the time from the event on
    pub over_time: WindOverTime,
}

/// A wind over the time from its event on.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub enum WindOverTime {
    /// [m/s] rows
    Table(Series<[f64; 3]>),
    /// a gust
    Gust(GustSpec),
}

impl WindOverTime {
    /// [m/s] Its velocity so long [s] after its event.
    pub fn at(&self, since: f64) -> [f64; 3] {
        match self {
            WindOverTime::Table(table) => table.at(since),
            WindOverTime::Gust(gust) => gust.at(since),
        }
    }

    /// [s] Times after its event at which it has a corner: rows of a table; begin, peak and end of a gust.
    pub fn corners(&self) -> Vec<f64> {
        match self {
            WindOverTime::Table(table) => table.t.clone(),
            WindOverTime::Gust(gust) => gust.corners().to_vec(),
        }
    }

    fn fastest(&self) -> f64 {
        match self {
            WindOverTime::Table(table) => fastest(table),
            WindOverTime::Gust(gust) => speed(&gust.velocity),
        }
    }
}

/// The stream that canopies, lines and payloads meet.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct StreamSpec {
    /// [m/s] wind over time, at all heights
    pub wind: Series<[f64; 3]>,
    /// gusts, added to it
    pub gusts: Vec<GustSpec>,
    /// [m, m/s] wind over the height above sea level, added to it
    pub profile: Option<Series<[f64; 3]>>,
    /// winds that begin with events, added to it
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub by_event: Vec<EventWind>,
    /// density of the air
    pub atmosphere: AtmosphereSpec,
    /// [m] height of z = 0 above sea level
    pub altitude: f64,
}

impl StreamSpec {
    /// [m/s] The wind at time `t` [s] and a height `z` [m] of the scene, without those that begin with events.
    pub fn wind_at(&self, t: f64, z: f64) -> [f64; 3] {
        let profile = self.profile.as_ref().map(|profile| profile.at(self.altitude + z));
        let parts = self.gusts.iter().map(|gust| gust.at(t)).chain(profile);
        parts.fold(self.wind.at(t), |sum, part| std::array::from_fn(|i| sum[i] + part[i]))
    }

    /// A wind over time [m/s] at all heights, in air of 1.225 kg/m^3 (sea level, standard atmosphere).
    pub fn of_wind(wind: Series<[f64; 3]>) -> Self {
        let atmosphere = AtmosphereSpec::Constant { density: 1.225 };
        StreamSpec { wind, gusts: Vec::new(), profile: None, by_event: Vec::new(), atmosphere, altitude: 0.0 }
    }

    /// [m/s] A bound on the speed of the wind.
    pub fn fastest_wind(&self) -> f64 {
        let StreamSpec { wind, gusts, profile, by_event, .. } = self;
        let gusts: f64 = gusts.iter().map(|gust| speed(&gust.velocity)).sum();
        let by_event: f64 = by_event.iter().map(|one| one.over_time.fastest()).sum();
        fastest(wind) + gusts + profile.as_ref().map_or(0.0, fastest) + by_event
    }
}

/// [m/s] The largest speed of a table.
pub(super) fn fastest(table: &Series<[f64; 3]>) -> f64 {
    table.value.iter().map(speed).fold(0.0, f64::max)
}

fn speed([x, y, z]: &[f64; 3]) -> f64 {
    x.hypot(*y).hypot(*z)
}
