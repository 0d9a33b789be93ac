//! What only some systems have. A system returns such an ability as a value, `None` if it has none.

use super::gauge::{CANOPY_QUANTITIES, GAS_QUANTITIES};
use super::point::Point;
use super::spec::EventSpec;
use super::state::{State, StateRef};
use std::ops::Range;

/// One of the springs of a scene: its batch and its number within the batch, in the scene's order. A batch is a rule of
/// the case that has springs, or, where springs break, one of its springs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpringPlace {
    /// batch, counted from 0
    pub batch: u32,
    /// number within the batch
    pub number: u32,
}

/// What damps springs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SpringDamping {
    /// nothing
    None,
    /// forces C v with a matrix C that stays as it is: relative dashpots, Rayleigh damping
    Constant,
    /// axial dashpots, whose direction turns with the springs
    Axial,
}

/// Springs on edges, in the user's numbering.
pub trait Springs {
    /// The edges that have a spring, ascending.
    fn spring_edges(&self) -> Vec<u32>;

    /// The edges that have a spring which is neither cut nor broken in this run so far; an edge may be there twice.
    fn whole_edges(&self) -> Vec<u32>;

    /// The springs on some edges (ascending), of one rule or of all.
    fn springs_on(&self, edges: &[u32], rule: Option<usize>) -> Vec<SpringPlace>;

    /// The edge of a spring.
    fn edge_of(&self, spring: SpringPlace) -> Option<u32>;

    /// [N] Tension of a spring with its axial dashpot.
    fn spring_tension(&self, at: StateRef<'_>, spring: SpringPlace) -> f64;

    /// Adds to the elastic tension [N] of every edge `[n_edges]` the force of the dashpot along it, if it has one.
    /// Forces between its ends that also have other directions are not included.
    fn add_axial_damping(&self, at: StateRef<'_>, tension: &mut [f64]);

    /// [m] Rest length at time `t` [s] of the spring on every edge `[n_edges]`, of several the shortest; NaN without.
    fn rest_lengths(&self, t: f64, out: &mut [f64]);

    /// The spring with the largest stiffness over the masses at its ends, at the node of a degree of freedom.
    fn fastest_spring(&self, dof: usize) -> Option<u32>;

    /// While `taut`, tangents and bounds take every spring that is slack as just taut.
    fn take_slack_as_taut(&self, taut: bool);

    /// Whether some spring changes its law with the state: it can go slack.
    fn has_branches(&self) -> bool;

    /// What damps them; of several the last in the order of [`SpringDamping`].
    fn damping(&self) -> SpringDamping;

    /// Writes into `impulse` [N s] `[n_dof]` the impulse that depends on changes of force laws within a step. For each
    /// force it is the smaller of two: what the force would have added with the law at the start, or with the other law
    /// from the start. Returns where the force with the largest impulse changes first, as a share of the step. `None`
    /// if none changes; `impulse` is then unspecified.
    fn branch_changes(&self, step: [StateRef<'_>; 2], impulse: &mut [f64]) -> Option<f64>;
}

/// Air around a system.
pub trait Air {
    /// Holds the wind at a velocity [m/s], or goes back to its table.
    fn hold_wind(&self, wind: Option<[f64; 3]>);

    /// [m/s] Winds at time `t` [s], between which that at any height is.
    fn winds(&self, t: f64) -> Vec<[f64; 3]>;

    /// Whether it puts pressures on triangles.
    fn presses(&self) -> bool;

    /// Pressure difference [Pa] that the air puts on every triangle `[n_triangles]`, positive along its right-hand
    /// normal; 0 on a triangle without air.
    fn triangle_pressure(&self, at: StateRef<'_>, out: &mut [f64]);

    /// Number of canopies that it fills.
    fn canopies(&self) -> usize;

    /// [`CANOPY_QUANTITIES`] of a canopy: the diameter of a circle with the area that the canopy and its openings show
    /// along the axis; twice the mean distance of the skirt's nodes from the axis; the volume between the cloth and
    /// flat covers of its openings; speed against the air along the axis; rho V |V|/2; drag over that; force of the air
    /// against the motion along the axis; mean over the cloth of the pressure difference from inside to outside; the
    /// projected diameter over D0; drag over rho V |V|/2 and S0; angle between the axis and the motion of the skirt
    /// through the air. The drag area leaves the breathing out but for a cavity, and has no value there without speed.
    /// The last two have no value without speed, nor while a stage has less than half of its drag area.
    fn canopy_values(&self, canopy: usize, at: StateRef<'_>) -> [f64; CANOPY_QUANTITIES.len()];

    /// Number of gases in closed volumes, in the order of
    /// [`NetworkSpec::gases`](crate::model::spec::NetworkSpec::gases).
    fn gases(&self) -> usize;

    /// [`GAS_QUANTITIES`] of a gas: pressure above the ambient one, and volume. NaN where there is no such gas.
    fn gas_values(&self, gas: usize, at: StateRef<'_>) -> [f64; GAS_QUANTITIES.len()];

    /// [N] Tension of a riser below a `mass` [kg], which is part of the node that all canopies are: the size of
    /// D + mass (g - a) with their drag and the force of the air that they take along D, and the acceleration a of the
    /// node. 0 without canopies that are points.
    fn pull_of_points(&self, mass: f64, at: &Point) -> f64;
}

/// Parts of a system that may touch each other or obstacles.
pub trait Touches {
    /// Says whether steps are explicit: contact then has a limited stiffness, and friction follows its pressure.
    fn set_explicit(&self, explicit: bool);

    /// [s] Says which size all steps have, if they have one.
    fn set_step(&self, step: Option<f64>);

    /// Says that an implicit step begins at a state, whose pressures friction has in this step.
    fn begin_step(&self, from: StateRef<'_>);

    /// Whether there is friction.
    fn rubs(&self) -> bool;

    /// Whether anything pressed on anything else at the last state whose forces were asked for.
    fn presses(&self) -> bool;

    /// Whether friction may have acted in the last step or may in the next one: a matrix then belongs to one step.
    fn is_rubbing(&self) -> bool;

    /// Shortens displacements `way` [m] `[n_dof]` from the positions `x` [m] `[n_dof]`, between two times [s], of nodes
    /// that would pass through others or touch them; where obstacles move, nodes before them are carried along. Returns
    /// the share [-] that is free for all nodes.
    fn keep_apart(&self, x: &[f64], times: [f64; 2], way: &mut [f64]) -> f64;

    /// Whether a block of steps may begin at a state without a look at contact, as nothing is near anything else.
    fn begin_block(&self, from: StateRef<'_>) -> bool;

    /// Whether nothing can have touched in a block that led to a state.
    fn covers(&self, to: StateRef<'_>) -> bool;

    /// Ends the block.
    fn leave_block(&self);

    /// What every contact is made of, and what is near and touches at a state; pairs are looked for anew.
    fn survey(&self, at: StateRef<'_>) -> Vec<ContactSurvey>;

    /// [1/s^2] [`ContactSurvey::rate`] of every contact.
    fn most_rates(&self) -> Vec<f64>;

    /// Adds the forces [N] of all contacts to `f` `[n_dof]`, as a pass does.
    fn press(&self, at: StateRef<'_>, f: &mut [f64]);

    /// What the first side of a contact does to the second one at a state; NaN where there is no such contact.
    fn load_of(&self, contact: usize, at: StateRef<'_>) -> ContactLoad;

    /// The pair that presses most on the node of a degree of freedom, in words, in the user's numbering.
    fn pressed_most(&self, at: StateRef<'_>, dof: usize) -> Option<String>;

    /// A pair whose gap is closed at a state.
    fn closed(&self, at: StateRef<'_>) -> Option<Passage>;

    /// From where pairs that are near were found; `None` before the first time.
    fn save(&self) -> Option<NearFrom>;

    /// Finds them from there again.
    fn restore(&self, from: &NearFrom);

    /// Where something has passed through something else, or has touched it, on the straight way between two states.
    fn passage(&self, from: StateRef<'_>, to: StateRef<'_>) -> Option<Passage>;
}

/// What a contact is made of, and what it has at a state.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ContactSurvey {
    /// nodes, edges and triangles of the first side
    pub first: [usize; 3],
    /// those of the second one; zeros of a plane, and of a contact with itself
    pub second: [usize; 3],
    /// pairs that are near: closer than the gap and the skin
    pub near: usize,
    /// those of them that are closer than the gap
    pub touching: usize,
    /// most pairs that are near and share a node of the scene
    pub at_one_node: usize,
    /// [1/s^2] largest stiffness along the normal, over the mass, of a pair that is closed by 60 % or more, in explicit
    /// steps
    pub rate: f64,
}

/// What the first side of a contact does to the second one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLoad {
    /// [N] force on the second side, friction included; 0 of a contact with itself
    pub force: [f64; 3],
    /// [N] sum of the pressures of all pairs
    pub pressure: f64,
}

impl ContactLoad {
    /// That of a contact that is not there: not a number.
    pub const NONE: ContactLoad = ContactLoad { force: [f64::NAN; 3], pressure: f64::NAN };
}

/// From where pairs that may touch were found.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct NearFrom {
    /// [s] time
    pub t: f64,
    /// [m] how far beyond their gaps and the skin
    pub more: f64,
    /// [m] positions of all degrees of freedom
    pub x: Vec<f64>,
}

/// A place where something has passed through something else.
#[derive(Clone, Debug, PartialEq)]
pub struct Passage {
    /// a degree of freedom of a node there
    pub dof: usize,
    /// the pair in words, in the user's numbering
    pub pair: String,
    /// [m] the gap that should have held it
    pub gap: f64,
}

/// What happens at given times: supports are released or change their velocity, springs are cut, loads and rest lengths
/// change.
pub trait Events {
    /// [s] Times at which supports are released or change their velocity, or springs are cut, ascending. A run ends a
    /// step there.
    fn event_times(&self) -> &[f64];

    /// [s] Times at which a force has a corner or a jump in time, ascending: rows of load and wind tables, and events.
    fn corners(&self) -> Vec<f64>;

    /// Makes load and wind tables ready for a run in fixed steps of `h` [s] from t = 0, whose samples would miss
    /// changes between them, or for any other run. All later evaluations belong to that run.
    fn sample_tables(&self, h: Option<f64>);

    /// Changes to the state of affairs after this many events. Returns whether forces, masses and tangents found
    /// before do not fit any more.
    fn pass_events(&self, passed: usize) -> bool;

    /// [s] Times after 0 from which the tangent is another at the same positions, ascending: of releases, of cuts, and
    /// where rest lengths that change are shortest.
    fn changes(&self) -> Vec<f64>;

    /// [s] When the last change is over that takes place before `end` [s], 0 without any: of loads, wind, base and rest
    /// lengths by their tables, of canopies by their stages, and events. A change that goes on at `end` lasts until
    /// then.
    fn settled_after(&self, end: f64) -> f64;

    /// The events that the scene has besides, by number: those that wait for a state or for another event, springs that
    /// break, and those that are only told.
    fn named(&self) -> &[EventSpec] {
        &[]
    }

    /// How far the [condition](crate::model::spec::Condition) of one of these is from being met, in its unit: it is met
    /// at 0 and below. Infinite for an event that waits for none.
    fn margin(&self, event: usize, at: StateRef<'_>) -> f64 {
        let _ = (event, at);
        f64::INFINITY
    }

    /// Which of them are that a spring breaks: there may be thousands.
    fn breaks(&self) -> Range<usize> {
        0..0
    }

    /// [N] The least margin of these, of springs that have not broken; infinite without any.
    fn break_margin(&self, at: StateRef<'_>) -> f64 {
        let _ = at;
        f64::INFINITY
    }

    /// [m, m/s] Place and velocity of what one of these looks at.
    fn place_of(&self, event: usize, at: StateRef<'_>) -> [[f64; 3]; 2] {
        let _ = (event, at);
        [[f64::NAN; 3]; 2]
    }

    /// [m/s] The wind at time `t` [s] and a height `z` [m] of the scene; 0 without air.
    fn wind_at(&self, t: f64, z: f64) -> [f64; 3] {
        let _ = (t, z);
        [0.0; 3]
    }

    /// [s] Times at which a wind that begins with one of these has a corner, from its time on: steps end there too.
    fn corners_after(&self, event: usize) -> Vec<f64> {
        let _ = event;
        Vec::new()
    }

    /// Says when each of these has happened [s], infinite where it has not, and with what speed against the air [m/s];
    /// those beyond the list have not. Returns whether forces, masses and tangents found before do not fit any more.
    fn set_happened(&self, happened: &[[f64; 2]]) -> bool {
        let _ = happened;
        false
    }

    /// Puts what supports move where it is at the time of a state, with the velocity that it then has. `share` [-] of
    /// the displacement is applied: 1 but for steps of a load. Returns whether they move anything.
    fn put_supports(&self, state: &mut State, share: f64) -> bool;
}
