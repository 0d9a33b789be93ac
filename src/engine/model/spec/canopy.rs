//! Canopies that the air fills: their parts, and what sets the pressure in them.

use super::GlideSpec;
use serde::Serialize;

/// The air in a canopy: a pressure along the normals of its triangles.
///
/// V is the axial air speed: the mean velocity of the confluence's nodes, or of the skirt's where stages tell the drag
/// area, minus the wind there, along the axis from the middle of the apex nodes to the middle of the confluence nodes;
/// q = rho V|V|/2.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CanopySpec {
    /// triangles, ascending; neighbours turn the same way. None of a canopy that is a point
    pub triangles: Vec<u32>,
    /// [-] dCp of each of them
    pub pressure_coefficient: Vec<f64>,
    /// nodes of the skirt, at least one
    pub skirt: Vec<u32>,
    /// nodes around the apex, at least one
    pub apex: Vec<u32>,
    /// nodes where the lines meet, at least one
    pub confluence: Vec<u32>,
    /// what sets the pressure
    pub air: CanopyAir,
    /// [-] k of the air that the canopy takes along, k rho times its volume
    pub apparent_mass: Option<f64>,
    /// [-] k, > 0, of the pressure k rho u|u|/2 that a canopy with a coefficient or with stages loses while its volume
    /// grows by u times the area of its mouth
    pub inflow_loss: Option<f64>,
    /// lift of a canopy that glides, which is a point
    #[serde(skip_serializing_if = "Option::is_none")]
    pub glide: Option<GlideSpec>,
    /// [m^2] S0 of cloth, gaps and vents, for coefficients in results and warnings
    pub nominal_area: f64,
}

/// What sets the pressure in a canopy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum CanopyAir {
    /// q dCp
    Coefficient,
    /// q dCp, scaled to a drag area that grows in stages: at least one, rising in time
    Filling(Vec<FillingSpec>),
    /// the same drag area on the only node of the skirt, against its motion through the air: a canopy that is a point
    Point(Vec<FillingSpec>),
    /// the balance of the air inside; dCp is then 1
    Cavity(CavitySpec),
    /// the balance of the air ring by ring; dCp is then 1, and V is the speed of the confluence
    Rings(RingsSpec),
}

impl CanopyAir {
    /// The stages of the drag area; none where it is not given.
    pub fn stages(&self) -> &[FillingSpec] {
        match self {
            CanopyAir::Filling(stages) | CanopyAir::Point(stages) => stages,
            CanopyAir::Coefficient | CanopyAir::Cavity(_) | CanopyAir::Rings(_) => &[],
        }
    }
}

/// A stage of the drag area of a canopy that fills: from what it was before to `drag_area`, by
/// ((t - start)/duration)^exponent. The pressure is dCp times what makes the force along the axis q times this area.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FillingSpec {
    /// [m^2] at the end of the stage
    pub drag_area: f64,
    /// [s] line stretch, or the cut of a reefing line; no pressure before the first. Infinite until its event happens
    pub start: f64,
    /// the event at which it starts, if there is one
    #[serde(skip_serializing_if = "Option::is_none")]
    pub event: Option<usize>,
    /// [s] filling time, > 0
    pub duration: f64,
    /// whether `duration` is a length [m], which the speed against the air at the event is to divide
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub by_speed: bool,
    /// [-] exponent, > 0
    pub exponent: f64,
}

impl FillingSpec {
    /// [m^2] The drag area at time `t` [s] of a canopy with these stages.
    pub fn area_at(stages: &[Self], t: f64) -> f64 {
        let grown = |before: f64, stage: &FillingSpec| {
            let share = ((t - stage.start) / stage.duration).clamp(0.0, 1.0).powf(stage.exponent);
            before + share * (stage.drag_area - before)
        };
        stages.iter().fold(0.0, grown)
    }

    /// [m^2/s] The rate of change of that drag area.
    pub fn growth_at(stages: &[Self], t: f64) -> f64 {
        let grown = |[before, rate]: [f64; 2], stage: &FillingSpec| {
            let share = (t - stage.start) / stage.duration;
            let [share, slope] = match share {
                s if s <= 0.0 => [0.0; 2],
                s if s >= 1.0 => [1.0, 0.0],
                s => [s.powf(stage.exponent), stage.exponent * s.powf(stage.exponent - 1.0) / stage.duration],
            };
            let left = stage.drag_area - before;
            [before + share * left, rate * (1.0 - share) + slope * left]
        };
        stages.iter().fold([0.0; 2], grown)[1]
    }

    /// Whether a canopy with these stages has at least half of the drag area at which the stage at time `t` [s] ends.
    pub fn half_filled(stages: &[Self], t: f64) -> bool {
        let stage = stages.iter().rev().find(|stage| stage.start <= t);
        stage.is_some_and(|stage| Self::area_at(stages, t) >= 0.5 * stage.drag_area)
    }
}

/// A canopy with a mouth: one pressure by the balance of the air that flows through mouth and cloth. The mouth is the
/// loop of the boundary with the nodes of the skirt, the only one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CavitySpec {
    /// [-] eta, > 0: speed in the mouth over that of the free stream, where the pressure inside is that outside
    pub inflow: f64,
    /// [-] pressure on the outside over q, < 1
    pub outer_pressure_coefficient: f64,
    /// if given, how the cloth lets air through
    pub cloth: Option<ClothSpec>,
}

/// A canopy that fills by a balance of the air at each of its rings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RingsSpec {
    /// rows of cloth from the vent edge or the apex to the skirt: the nodes of each, all turning the same way; the
    /// triangles of the canopy lie between neighbours
    pub rows: Vec<Vec<u32>>,
    /// [-] Cb, pressure on the outside over q, < 1
    pub outer_pressure_coefficient: f64,
    /// [-] kd and kv, >= 0: what cloth that moves outwards takes from the pressure, rho w (kd |V| + kv |w|)
    pub damping: [f64; 2],
    /// if given, how the cloth lets air through
    pub cloth: Option<ClothSpec>,
    /// [-] share of the cloth that is open as slots, 0 to 1
    pub geometric_porosity: f64,
    /// [-] discharge coefficient of slots and gaps, > 0
    pub slot_discharge: f64,
    /// [-] discharge coefficient of the vent, >= 0; at 0 it is closed
    pub vent_discharge: f64,
}

/// The pressure difference over a cloth, linear w + quadratic w|w| with the speed w of the air through it. Neither is
/// negative, one is positive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClothSpec {
    /// [Pa s/m] viscous coefficient
    pub linear: f64,
    /// [Pa s^2/m^2] inertial coefficient
    pub quadratic: f64,
}

impl ClothSpec {
    /// [m/s] The speed of the air through it at a pressure difference [Pa] of 0 or more.
    pub fn speed_at(&self, pressure: f64) -> f64 {
        let ClothSpec { linear, quadratic } = *self;
        // Without a difference of nearly equal numbers.
        2.0 * pressure / (linear + (linear * linear + 4.0 * quadratic * pressure).sqrt())
    }
}
