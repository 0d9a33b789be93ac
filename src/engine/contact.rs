//! Contact: what is near, what touches, and the forces of it.
//!
//! * [`bodies`]: the nodes, edges and triangles that may touch, and obstacles among them.
//! * [`near`]: pairs that are near, found by trees of boxes ([`search`]) and kept until patches of the scene have come
//!   nearer to each other ([`patches`]).
//! * [`distance`], [`parallel`]: the distance of a pair with its derivatives, and what smooths that of parallel edges.
//! * [`impact`]: how far a pair may move before it touches; [`apart`]: how far all nodes of a scene may.
//! * [`barrier`], [`friction`]: the laws.
//! * [`survey`]: what a contact is made of, and the steps that it allows explicit methods.
//! * [`touch`]: force and tangent of a pair; [`mean`]: the same as a mean over a step.

pub mod apart;
pub mod barrier;
pub mod bodies;
pub mod distance;
pub mod friction;
pub mod impact;
pub mod mean;
pub mod near;
pub mod parallel;
pub mod patches;
pub mod search;
pub mod survey;
pub mod touch;
