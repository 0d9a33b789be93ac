//! The mechanical model: plain specifications, state, the forces of one pass, and the traits every scheme
//! and every output is written against.

pub mod abilities;
pub mod added_mass;
pub mod at_dof;
pub mod bounds;
pub mod forces;
pub mod gauge;
pub mod group_totals;
pub mod lanes;
pub mod links;
pub mod motion;
pub mod observables;
pub mod point;
pub mod quad;
pub mod quantity;
pub mod spec;
pub mod spring_state;
pub mod state;
pub mod step_block;
pub mod stop;
pub mod system;
pub mod workers;
