//! What counted work costs on one core of an ordinary machine: the one table of all studies and forecasts, which so
//! decide the same on every machine. The choice of a linear solver has its own (`solve/cost_model`), in which only the
//! ratios between solvers count.

/// [s] A force pass itself, besides its elements, where no step is counted, and where [`STEP`] is.
pub(crate) const PASS: f64 = 3e-7;
pub(crate) const SMALL_PASS: f64 = 5e-8;
/// [s] A spring, a triangle and a node in a force pass.
pub(crate) const SPRING: f64 = 8e-9;
pub(crate) const TRIANGLE: f64 = 15e-9;
pub(crate) const NODE: f64 = 8e-9;
/// [-] A second force pass at the same positions over the first, from which it takes what follows from positions
/// (annuli of 703 nodes in the wind: 0.88; of 10,000 and 100,000 nodes without: 0.65; with a first pass that kept all
/// sums apart).
pub(crate) const AGAIN: f64 = 0.7;
/// [s] A step besides its forces and its equations, and the same a degree of freedom.
pub(crate) const STEP: f64 = 3e-7;
pub(crate) const STEP_DOF: f64 = 4e-9;
/// [s] The equations of an implicit step a degree of freedom, to an order of magnitude.
pub(crate) const IMPLICIT_DOF: f64 = 1e-6;
/// [s] A search of the spectrum for critical steps, a degree of freedom: some two hundred tangent products.
pub(crate) const SEARCH_DOF: f64 = 1e-5;
/// [1/s] Operations of a Cholesky factorisation (8e9 on one core of the machine this was written on, 15.7 million
/// entries).
pub(crate) const OPERATIONS: f64 = 6e9;
/// [s] An entry of W in an assembly, an entry of the factor in its making and in a solve (703 nodes, quiet: 0.22, 0.8
/// and 0.1 ms).
pub(crate) const ASSEMBLY: f64 = 12e-9;
pub(crate) const FACTOR: f64 = 2e-9;
pub(crate) const SOLVE: f64 = 1.05e-9;
/// [s] An entry of W in an iteration of conjugate gradients, and in making them ready (703 and 10,000 nodes).
pub(crate) const CG_ITERATION: f64 = 1.3e-9;
pub(crate) const CG_READY: f64 = 3.5e-9;
/// [s] An LU factorisation of a net with n unknowns over n^1.5 (annuli of 2,500 to 40,000 nodes: 55 to 105 ns), and a
/// solve over n.
pub(crate) const LU: f64 = 6e-8;
