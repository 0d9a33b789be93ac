//! Canopies whose numbers do not belong together: drag area and size, filling time and run, reefing line and stages;
//! and air above the standard atmosphere.

use crate::format_number::figures;
use crate::model::spec::{AtmosphereSpec, CanopyAir, CanopySpec, ClothSpec, FillingSpec, NetworkSpec, SpringGroup};
use crate::warning::{Warning, WarningCode};
use std::collections::BTreeSet;
use std::fmt;

/// [-] Least and largest drag coefficient on the nominal area: guide surface canopies have 0.28, triconical ones 0.96
/// (Knacke 1991, tables 5-1 and 5-2).
const COEFFICIENTS: [f64; 2] = [0.3, 1.2];
/// [-] Filling time over the rest of the run above which the canopy hardly begins to fill.
const LONG: f64 = 30.0;
/// [s] Filling time that no canopy needs: a shorter one is no fault of the case, however short the run.
const SLOW: f64 = 20.0;
/// [-] Relative difference of two times that are meant to be one.
const APART: f64 = 0.01;
/// [Pa] Pressure difference of half an inch of water, at which data sheets state the air through a cloth.
const STATED: f64 = 124.5;
/// [m/s] Air through a cloth at that pressure up to which it is tight: 20 ft^3/min through a square foot. Rescue
/// parachutes have 5 and less, the C-9 has 128.
const TIGHT: f64 = 0.1;
/// [-] Share of the nominal area without cloth from which on a canopy is slotted.
const SLOTTED: f64 = 0.1;
/// [-] K of 25 load tests of rescue parachutes (EN 12491), single spikes of the accelerometer included.
const MEASURED: f64 = 0.6;
/// [m] Height above sea level at which the standard atmosphere ends.
const STANDARD: f64 = 86e3;

/// What words call a canopy.
pub(super) fn name(spec: &NetworkSpec, canopy: usize) -> String {
    if spec.canopies.len() == 1 { "the canopy".to_owned() } else { format!("canopy {canopy}") }
}

/// A drag area that no canopy of its size has.
#[derive(Clone, Debug, PartialEq)]
pub struct ImplausibleDrag {
    /// which one, in words
    pub canopy: String,
    /// [m^2] drag area of the full canopy
    pub drag_area: f64,
    /// [m^2] S0
    pub nominal_area: f64,
    /// [-] force of the air over that drag, above 1 where the canopy glides
    pub lifted: f64,
}

/// Compares the drag areas at the ends of schedules with the nominal areas; of canopies that glide, lift and drag.
pub fn drag_coefficients(spec: &NetworkSpec) -> Vec<ImplausibleDrag> {
    let [least, most] = COEFFICIENTS;
    let implausible = |(i, canopy): (usize, &CanopySpec)| {
        let (drag_area, nominal_area) = (canopy.air.stages().last()?.drag_area, canopy.nominal_area);
        let lifted = canopy.glide.as_ref().map_or(1.0, |glide| 1.0_f64.hypot(glide.ratio));
        let fits = (least..=most).contains(&(lifted * drag_area / nominal_area));
        (!fits).then(|| ImplausibleDrag { canopy: name(spec, i), drag_area, nominal_area, lifted })
    };
    spec.canopies.iter().enumerate().filter_map(implausible).collect()
}

impl fmt::Display for ImplausibleDrag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ImplausibleDrag { canopy, drag_area, nominal_area, lifted } = self;
        let [coefficient, area, nominal] =
            [lifted * drag_area / nominal_area, *drag_area, *nominal_area].map(|number| figures(number, 3));
        let of = if *lifted > 1.0 { "coefficient of lift and drag together" } else { "drag coefficient" };
        write!(
            f,
            "{canopy} has a {of} of {coefficient}: a drag area of {area} m^2 on S0 = {nominal} m^2; canopies have \
             0.3 to 1.2: is the drag area that of another canopy? drag_coefficient gives it by S0"
        )
    }
}

impl From<ImplausibleDrag> for Warning {
    fn from(found: ImplausibleDrag) -> Self {
        Warning::new(WarningCode::DragCoefficient, found.to_string())
    }
}

/// A stage that a run sees only the beginning of.
#[derive(Clone, Debug, PartialEq)]
pub struct LongFilling {
    /// which one, in words
    pub canopy: String,
    /// [s] filling time
    pub duration: f64,
    /// [s] start of the stage, and end of the run
    pub times: [f64; 2],
    /// [-] share of its drag area at the end
    pub share: f64,
}

/// Finds stages that need far longer than a run until `end` [s] has.
pub fn filling(spec: &NetworkSpec, end: f64) -> Vec<LongFilling> {
    let long = |(i, canopy): (usize, &CanopySpec)| {
        let found = canopy
            .air
            .stages()
            .iter()
            .find(|stage| stage.start < end && stage.duration > (LONG * (end - stage.start)).max(SLOW))?;
        let FillingSpec { start, duration, exponent, .. } = *found;
        let share = ((end - start) / duration).powf(exponent);
        Some(LongFilling { canopy: name(spec, i), duration, times: [start, end], share })
    };
    spec.canopies.iter().enumerate().filter_map(long).collect()
}

impl fmt::Display for LongFilling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LongFilling { canopy, duration, times: [start, end], share } = self;
        let [duration, start, end, share] = [*duration, *start, *end, 100.0 * share].map(|number| figures(number, 3));
        write!(
            f,
            "{canopy} needs {duration} s to fill from t = {start} s on, but the run ends at {end} s, when it has {share} % of its drag \
             area; a filling time by filling_constant is n D0 over the speed at line stretch: give that speed, or filling_time"
        )
    }
}

impl From<LongFilling> for Warning {
    fn from(found: LongFilling) -> Self {
        Warning::new(WarningCode::FillingBeyondEnd, found.to_string())
    }
}

/// A reefing line and the stages of the canopy that it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct ReefingLine {
    /// which one, in words
    pub canopy: String,
    /// [s] when it is cut, if it is
    pub cut: Option<f64>,
    /// [s] when the last of several stages begins
    pub stage: Option<f64>,
    /// whether these agree, but the air does not slow the opening after the cut
    pub snaps: bool,
}

/// Finds reefing lines that are never cut and do not grow, those whose cut is not the start of the last stage, and
/// those whose cut no air slows: edges of the group `reefing` with springs, between nodes of the skirt. Those that an
/// event cuts are not meant.
pub fn reefing_lines(spec: &NetworkSpec) -> Vec<ReefingLine> {
    let Some(lines) = spec.mesh.groups.get("reefing") else { return Vec::new() };
    let of_canopy = |(i, canopy): (usize, &CanopySpec)| {
        let skirt: BTreeSet<u32> = canopy.skirt.iter().copied().collect();
        let around = |edge: &&u32| {
            spec.mesh.edges.get(**edge as usize).is_some_and(|ends| ends.iter().all(|node| skirt.contains(node)))
        };
        let first = lines.edges.iter().find(around)?;
        // Cloth has the edges of its sides too.
        let only = |edges: &[u32]| edges.iter().all(|edge| lines.edges.binary_search(edge).is_ok());
        let has = |group: &&SpringGroup| group.edges.binary_search(first).is_ok() && only(&group.edges);
        // Where the skirt has no nodes between the lines, its tape has the same edges.
        let with_tape = spec.mesh.groups.get("skirt").is_some_and(|skirt| skirt.edges.binary_search(first).is_ok());
        let groups: Vec<&SpringGroup> = spec.springs.iter().filter(has).collect();
        if groups.len() < if with_tape { 2 } else { 1 } {
            return None;
        }
        // Whether these agree shows in the run.
        let by_event = canopy.air.stages().last().is_some_and(|stage| stage.event.is_some());
        if by_event || groups.iter().any(|group| group.cut_by.is_some()) {
            return None;
        }
        let grows = groups.iter().any(|group| group.rest_scale.is_some());
        let cut = groups.iter().find_map(|group| group.cut);
        let stage = canopy.air.stages().get(1..).and_then(<[_]>::last).map(|stage| stage.start);
        let fits = match (cut, stage) {
            (None, _) => grows,
            (Some(cut), Some(stage)) => (cut - stage).abs() <= APART * cut,
            (Some(_), None) => canopy.air.stages().is_empty(),
        };
        let balanced = matches!(canopy.air, CanopyAir::Cavity(_) | CanopyAir::Rings(_) | CanopyAir::Point(_));
        let snaps = fits && cut.is_some() && !balanced && canopy.inflow_loss.is_none();
        (snaps || !fits).then(|| ReefingLine { canopy: name(spec, i), cut, stage, snaps })
    };
    spec.canopies.iter().enumerate().filter_map(of_canopy).collect()
}

impl fmt::Display for ReefingLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ReefingLine { canopy, cut, stage, snaps } = self;
        let [cut, stage] = [cut, stage].map(|t| t.map(|t| figures(t, 6)));
        match (cut, stage) {
            (Some(cut), _) if *snaps => write!(
                f,
                "the reefing line of {canopy} is cut at {cut} s, and no air slows the opening: the cloth snaps open within some \
                 hundredths of a second, and the lines feel a jerk that no measured canopy has; give the canopy \"inflow_loss\": 1"
            ),
            (None, None) => write!(f, "the reefing line of {canopy} is never cut: give its springs a \"cut\""),
            (None, Some(stage)) => write!(
                f,
                "the reefing line of {canopy} is never cut, but its last stage begins at {stage} s: give its springs a \"cut\" then"
            ),
            (Some(cut), None) => write!(
                f,
                "the reefing line of {canopy} is cut at {cut} s, but its schedule has one stage: give it a stage with the drag \
                 area of the reefed canopy, and one that starts at the cut"
            ),
            (Some(cut), Some(stage)) => write!(
                f,
                "the reefing line of {canopy} is cut at {cut} s, but its last stage begins at {stage} s: they are the same event"
            ),
        }
    }
}

impl From<ReefingLine> for Warning {
    fn from(found: ReefingLine) -> Self {
        Warning::new(WarningCode::ReefingLine, found.to_string())
    }
}

/// A canopy that is told how it fills, of cloth whose measured openings are harder.
#[derive(Clone, Debug, PartialEq)]
pub struct TightCloth {
    /// which one, in words
    pub canopy: String,
    /// [m/s] speed of the air through the cloth at 124.5 Pa, if its permeability is given
    pub leak: Option<f64>,
    /// measured loads of tight cloth, where what hangs on the canopy is free
    pub opening: Option<Opening>,
}

/// K m V^2/D0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// [kg] m of the whole system
    pub mass: f64,
    /// [m/s] V at the start
    pub speed: f64,
    /// [m] D0
    pub diameter: f64,
}

/// Looks at a canopy with a schedule that fills during the run, at `speed` [m/s] at the start; canopies with slots are
/// not meant. `cloth` is what the case tells of its cloth.
pub fn tight_cloth(spec: &NetworkSpec, canopy: usize, cloth: Option<ClothSpec>, speed: f64) -> Option<TightCloth> {
    let found = spec.canopies.get(canopy)?;
    let fills = found.air.stages().iter().any(|stage| stage.start + stage.duration > 0.0);
    let sizes = found.triangles.iter().filter_map(|&t| spec.mesh.triangles.get(t as usize));
    let open = 1.0 - sizes.map(|&corners| triangle_area(spec, corners)).sum::<f64>() / found.nominal_area;
    let leak = cloth.map(|cloth| cloth.speed_at(STATED));
    if !fills || open > SLOTTED || leak.is_some_and(|w| w > TIGHT) {
        return None;
    }
    // The speed at an event is not known before the run.
    let waits = found.air.stages().first().is_some_and(|stage| stage.event.is_some());
    let free = spec.canopies.len() == 1 && !spec.fixed.iter().flatten().any(|held| *held) && speed > 0.0 && !waits;
    let diameter = (4.0 * found.nominal_area / std::f64::consts::PI).sqrt();
    let opening = free.then(|| Opening { mass: spec.mass.iter().sum(), speed, diameter });
    Some(TightCloth { canopy: name(spec, canopy), leak, opening })
}

/// [m^2] of a triangle of the mesh as given.
fn triangle_area(spec: &NetworkSpec, [a, b, c]: [u32; 3]) -> f64 {
    let [a, b, c] = [a, b, c].map(|node| spec.mesh.point(node));
    0.5 * (b - a).cross(&(c - a)).norm()
}

impl fmt::Display for TightCloth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let TightCloth { canopy, leak, opening } = self;
        match leak {
            Some(_) => write!(f, "{canopy} fills by its schedule, and its cloth is tight")?,
            None => write!(f, "{canopy} fills by its schedule, and no permeability of its cloth is given")?,
        }
        write!(
            f,
            ": measured openings of tight cloth are up to three times harder, F = K m V^2/D0 with K = {MEASURED}"
        )?;
        if let Some(Opening { mass, speed, diameter }) = opening {
            let load = figures(MEASURED * mass * speed * speed / diameter, 3);
            let [mass, speed, diameter] = [*mass, *speed, *diameter].map(|number| figures(number, 3));
            write!(f, ", here {load} N with {mass} kg at {speed} m/s on D0 = {diameter} m")?;
        }
        f.write_str("; take \"filling\"")?;
        if leak.is_none() { f.write_str(", or give the permeability as \"law\" beside \"schedule\"") } else { Ok(()) }
    }
}

impl From<TightCloth> for Warning {
    fn from(found: TightCloth) -> Self {
        Warning::new(WarningCode::TightCloth, found.to_string())
    }
}

/// A height that the standard atmosphere does not reach.
#[derive(Clone, Debug, PartialEq)]
pub struct BeyondStandard {
    /// [m] above sea level
    pub height: f64,
}

/// Finds nodes that start above the standard atmosphere, or would rise above it without the air.
pub fn height(spec: &NetworkSpec) -> Option<BeyondStandard> {
    let stream = spec.stream.as_ref().filter(|stream| stream.atmosphere == AtmosphereSpec::Isa)?;
    let down = spec.gravity.map_or(0.0, |[_, _, z]| -z);
    let upward = |list: &[[f64; 3]], i: usize| list.get(i).map_or(0.0, |[_, _, z]| *z);
    let top = |(i, [_, _, z]): (usize, &[f64; 3])| {
        let speed = upward(&spec.velocity, i).max(0.0);
        let rise = if down > 0.0 { 0.5 * speed * speed / down } else { 0.0 };
        stream.altitude + z + upward(&spec.displacement, i) + rise
    };
    let height = spec.mesh.nodes.iter().enumerate().map(top).fold(f64::NEG_INFINITY, f64::max);
    (height > STANDARD).then_some(BeyondStandard { height })
}

impl fmt::Display for BeyondStandard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the scene starts, or may rise, as high as {} m above sea level; the standard atmosphere ends at 86000 m, and the density \
             above is that of its last layer carried on",
            figures(self.height, 4)
        )
    }
}

impl From<BeyondStandard> for Warning {
    fn from(found: BeyondStandard) -> Self {
        Warning::new(WarningCode::ThinAir, found.to_string())
    }
}
