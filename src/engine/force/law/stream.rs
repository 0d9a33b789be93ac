//! The stream that canopies, lines and payloads meet: wind over time and height, density over height.
//!
//! ```text
//! w(t, z) = table(t) + sum of gusts(t) + profile(altitude + z) + sum of winds(t - t_e) from their events t_e on
//! gust(t) = A/2 (1 - cos(2 pi (t - t0)/T))
//! ```
//! Profile and atmosphere are functions of the height above sea level. Fixed steps would miss a short gust, or take it
//! for a longer one, so it is then a table that is treated as any other (`step_samples`). Steps end at the corners of a
//! wind that has begun with an event.

use crate::force::Copies;
use crate::force::law::atmosphere::density;
use crate::force::law::series::{SampledTable, Table};
use crate::force::law::step_samples::sampled_by_steps;
use crate::model::spec::{AtmosphereSpec, EventWind, GustSpec, Series, StreamSpec};
use nalgebra::Vector3;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};

/// A stream in a run.
#[derive(Debug)]
pub struct Stream {
    /// [m/s] wind over time
    table: Table<3>,
    /// whether the wind is held at a velocity, which stands in the table
    held: AtomicBool,
    gusts: Vec<Gust>,
    /// [m, m/s] over the height above sea level
    profile: Option<Arc<Series<[f64; 3]>>>,
    by_event: Vec<BegunWind>,
    atmosphere: AtmosphereSpec,
    /// [m] height of z = 0 above sea level
    altitude: f64,
}

/// A wind that begins with an event.
#[derive(Debug)]
struct BegunWind {
    given: Arc<EventWind>,
    /// [s] when its event has happened, infinite until then
    begun: AtomicU64,
}

impl Clone for BegunWind {
    fn clone(&self) -> Self {
        BegunWind { given: self.given.clone(), begun: AtomicU64::new(self.begun.load(Ordering::Relaxed)) }
    }
}

impl BegunWind {
    fn new(given: EventWind) -> Self {
        BegunWind { given: Arc::new(given), begun: AtomicU64::new(f64::INFINITY.to_bits()) }
    }

    /// [s] When it has begun.
    fn begun(&self) -> Option<f64> {
        Some(f64::from_bits(self.begun.load(Ordering::Relaxed))).filter(|t| t.is_finite())
    }

    /// [m/s] Its velocity, if it has begun.
    fn at(&self, t: f64) -> Option<Vector3<f64>> {
        let since = t - self.begun()?;
        (since >= 0.0).then(|| self.given.over_time.at(since).into())
    }
}

/// [-] A gust of fewer steps is replaced by a table. The samples of a longer one have its integral to 0.2 %: they miss
/// two thirds of the cube of a step over the gust.
const SHORT: f64 = 8.0;

/// A gust, and its replacement in a run of fixed steps in which it is short.
#[derive(Debug)]
struct Gust {
    given: GustSpec,
    /// [-] share of the velocity at its peak
    sampled: RwLock<Option<Series<[f64; 1]>>>,
}

impl Clone for Gust {
    fn clone(&self) -> Self {
        let sampled = self.sampled.read().unwrap_or_else(PoisonError::into_inner).clone();
        Gust { given: self.given, sampled: RwLock::new(sampled) }
    }
}

impl Gust {
    fn new(given: GustSpec) -> Self {
        Gust { given, sampled: RwLock::new(None) }
    }

    /// [m/s]
    fn at(&self, t: f64) -> Vector3<f64> {
        let sampled = self.sampled.read().unwrap_or_else(PoisonError::into_inner);
        let share = sampled.as_ref().map_or_else(|| self.given.share(t), |table| table.at(t)[0]);
        share * Vector3::from(self.given.velocity)
    }
}

impl Gust {
    fn sample(&self, h: Option<f64>) {
        let short = h.filter(|h| self.given.duration < SHORT * h);
        let made = short.and_then(|h| sampled_by_steps(&self.given.rows(), h));
        *self.sampled.write().unwrap_or_else(PoisonError::into_inner) = made;
    }
}

/// The air at a place and time.
#[derive(Clone, Copy, Debug)]
pub struct AirState {
    /// [m/s] wind, and [1/s] its slope over height
    pub wind: [Vector3<f64>; 2],
    /// [kg/m^3] density, and [kg/m^4] its slope over height
    pub density: [f64; 2],
}

impl Clone for Stream {
    /// Another stream like it; what a run replaces in one of them it does not replace in the other.
    fn clone(&self) -> Self {
        let Stream { table, gusts, profile, by_event, .. } = self;
        let (table, gusts, held) = (table.clone(), gusts.clone(), AtomicBool::new(self.is_held()));
        Stream { table, held, gusts, profile: profile.clone(), by_event: by_event.clone(), ..*self }
    }
}

impl Stream {
    /// A stream whose wind has at least one row and increasing times.
    pub fn new(spec: StreamSpec) -> Self {
        let StreamSpec { wind, gusts, profile, by_event, atmosphere, altitude } = spec;
        let (table, held) = (Table::new(wind), AtomicBool::new(false));
        let (gusts, profile) = (gusts.into_iter().map(Gust::new).collect(), profile.map(Arc::new));
        let by_event = by_event.into_iter().map(BegunWind::new).collect();
        Stream { table, held, gusts, profile, by_event, atmosphere, altitude }
    }

    /// Says when events have happened, by their number: [s], infinite where one has not.
    pub fn set_happened(&self, at: impl Fn(usize) -> f64) {
        self.by_event.iter().for_each(|wind| wind.begun.store(at(wind.given.event).to_bits(), Ordering::Relaxed));
    }

    /// [s] Corners of the winds that have begun with an event.
    pub fn corners_begun(&self) -> impl Iterator<Item = f64> {
        self.by_event.iter().flat_map(|wind| {
            let begun = wind.begun();
            let corners = begun.map_or_else(Vec::new, |_| wind.given.over_time.corners());
            corners.into_iter().map(move |t| t + begun.unwrap_or(f64::INFINITY))
        })
    }

    /// [s] Corners of the winds that begin with an event, from its time on.
    pub fn corners_after(&self, event: usize) -> impl Iterator<Item = f64> {
        let of_event = self.by_event.iter().filter(move |wind| wind.given.event == event);
        of_event.flat_map(|wind| wind.given.over_time.corners())
    }

    /// Replaces the wind by a constant velocity [m/s] at all heights, or goes back to it.
    pub fn hold(&self, wind: Option<[f64; 3]>) {
        self.held.store(wind.is_some(), Ordering::Relaxed);
        self.table.hold(wind);
    }

    /// Whether wind and density are the same at all heights.
    pub fn is_uniform(&self) -> bool {
        self.profile.is_none() && matches!(self.atmosphere, AtmosphereSpec::Constant { .. })
    }

    fn is_held(&self) -> bool {
        self.held.load(Ordering::Relaxed)
    }

    /// [m/s] The part of the wind that is the same at all heights.
    pub fn uniform_wind(&self, t: f64) -> Vector3<f64> {
        let (gusts, by_event) = if self.is_held() { (&[][..], &[][..]) } else { (&self.gusts[..], &self.by_event[..]) };
        let parts = gusts.iter().map(|gust| gust.at(t)).chain(by_event.iter().filter_map(|wind| wind.at(t)));
        parts.fold(Vector3::from(self.table.at(t)), |sum, one| sum + one)
    }

    /// [m/s] The winds at time `t` [s] at the rows of the profile; between two rows the wind is between theirs.
    pub fn winds(&self, t: f64) -> Vec<Vector3<f64>> {
        let everywhere = self.uniform_wind(t);
        match self.profile.as_ref().filter(|_| !self.is_held()) {
            Some(profile) => profile.value.iter().map(|wind| everywhere + Vector3::from(*wind)).collect(),
            None => vec![everywhere],
        }
    }

    /// The air at time `t` [s] and the height `z` [m] of the scene.
    pub fn at(&self, t: f64, z: f64) -> AirState {
        let height = self.altitude + z;
        let (mut wind, mut slope) = (self.uniform_wind(t), Vector3::zeros());
        if let Some(profile) = self.profile.as_ref().filter(|_| !self.is_held()) {
            wind += Vector3::from(profile.at(height));
            slope = Vector3::from(slope_of(profile, height));
        }
        AirState { wind: [wind, slope], density: density(self.atmosphere, height) }
    }
}

impl SampledTable for Stream {
    /// Rows of the wind, and begin, peak and end of gusts.
    fn corners(&self) -> Vec<f64> {
        let gusts = self.gusts.iter().flat_map(|gust| gust.given.corners());
        self.table.corners().into_iter().chain(gusts).collect()
    }

    fn changing(&self) -> Vec<[f64; 2]> {
        let gusts = self.gusts.iter().map(|Gust { given, .. }| [given.start, given.start + given.duration]);
        self.table.changing().into_iter().chain(gusts).collect()
    }

    fn sample(&self, h: Option<f64>) {
        self.table.sample(h);
        self.gusts.iter().for_each(|gust| gust.sample(h));
    }

    fn for_run(self: Arc<Self>, copies: &mut Copies) -> Arc<dyn SampledTable> {
        let copy: Arc<Self> = copies.of(&self);
        copy
    }
}

/// The slope of a table that is linear between its rows, constant outside them; at a row that of the rows above.
fn slope_of(series: &Series<[f64; 3]>, at: f64) -> [f64; 3] {
    match series.t.partition_point(|&t| t <= at) {
        0 => [0.0; 3],
        n if n == series.t.len() => [0.0; 3],
        n => {
            let width = series.t[n] - series.t[n - 1];
            std::array::from_fn(|i| (series.value[n][i] - series.value[n - 1][i]) / width)
        }
    }
}
