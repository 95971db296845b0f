//! What error each quantity may have, and why.
//!
//! The golden numbers are f64, the core computes in f32. A number is rounded by at most half a unit of its
//! last place, `HALF_ULP` = 6e-8 of its size; every rounding of an input and of a step of the computation
//! adds one. Each limit is that rounding times the number of steps it takes, two to five times what is
//! reached today, so that a mistake shows and another order of additions does not.

use super::tally::Limit;

/// Half a unit in the last place of f32, as a fraction of the number.
const HALF_ULP: f64 = f32::EPSILON as f64 / 2.0;

/// Torques and forces of inverse dynamics, relative to the largest torque (or the force) of the state. The
/// promise is 1e-5, for trees of 32 bodies too; 3e-6 is reached there.
pub const TORQUE: f64 = 1e-5;

/// Elements of the mass matrix, relative to the geometric mean of their two diagonal elements. A column is
/// one run of inverse dynamics without the terms of velocity; 1.3e-6 is reached with 32 bodies.
pub const MASS_MATRIX: f64 = 5e-6;

/// Torques of a control tick, relative to the largest of the state: those of inverse dynamics, for an
/// acceleration that is itself off by [`COMMAND`].
pub const CONTROL_TORQUE: f64 = 4e-6;

/// Commanded accelerations, relative to the largest of the state: kp (200) times a rotation error that may
/// be off by [`ROTATION`], 2e-4 rad/s², and kd (28) times the error of a rate, at some 100 rad/s².
pub const COMMAND: f64 = 8e-6;

/// World positions down a chain, relative to the largest of the tree: each joint turns an offset and
/// adds it, which takes some five roundings, and the chains are up to 10 deep.
pub const CHAIN_POSITION: Limit = Limit::Relative(40.0 * HALF_ULP);

/// World orientations down a chain: each joint multiplies two quaternions (four roundings of a component
/// each, and an angle is twice the vector part).
pub const CHAIN_ROTATION: Limit = Limit::Absolute(40.0 * HALF_ULP, "rad");

/// World angular velocities down a chain, relative to the largest of the tree: turned by an orientation
/// that is itself off by [`CHAIN_ROTATION`], and added up.
pub const CHAIN_ANGULAR_VELOCITY: Limit = Limit::Relative(60.0 * HALF_ULP);

/// World linear velocities down a chain, relative to the largest of the tree: angular velocities times
/// arms, added up.
pub const CHAIN_LINEAR_VELOCITY: Limit = Limit::Relative(60.0 * HALF_ULP);

/// Rotation vectors between two given orientations: eight components of two quaternions are rounded, and
/// those of their product; the angle is twice the vector part, up to π/2 times that where it is large.
pub const ROTATION: Limit = Limit::Absolute(16.0 * HALF_ULP, "rad");

/// Difference of two positions as they are: two inputs of up to 4 m, each rounded to 1.2e-7 m.
pub const DIRECT_POSITION: Limit = Limit::Absolute(2.4e-7, "m");

/// Difference of two velocities as they are, relative to the largest of the state: two roundings of inputs,
/// one of the difference.
pub const DIRECT_RATE: Limit = Limit::Relative(3.0 * HALF_ULP);

/// Difference of two positions as seen from a body: as [`DIRECT_POSITION`], four inputs, and both
/// differences turned to the axes of the body.
pub const RELATIVE_POSITION: Limit = Limit::Absolute(8e-7, "m");

/// Difference of two velocities as seen from a body, relative to the largest of the state: four
/// inputs, turned, with the velocity at the end of an arm.
pub const RELATIVE_RATE: Limit = Limit::Relative(20.0 * HALF_ULP);

/// As [`RELATIVE_RATE`], by way of joint states: turned three times instead of once, by quaternions whose
/// own length, off by two roundings, counts twice each time.
pub const JOINT_RATE: Limit = Limit::Relative(40.0 * HALF_ULP);

/// Rotations that Linear Compensation turns: as [`ROTATION`], and the directions to the goal, over 0.1 m and
/// more, whose ends are rounded to 1.2e-7 m (half as much below 2 m).
pub const COMPENSATED_ROTATION: Limit = Limit::Absolute(1.8e-6, "rad");

/// Angular rate of Linear Compensation, relative to the largest of the state and the speed of turning
/// `|ė_lin| / d`, the latter times `1 + |p| / d`: an arm of length d between points at p is that much
/// worse than its own rounding.
pub const COMPENSATED_RATE: Limit = Limit::Relative(4.0 * HALF_ULP);

/// The goal `p + R c`: a position of up to 4 m, an arm of 0.5 m turned, and their sum.
pub const GOAL: Limit = Limit::Absolute(3.6e-7, "m");

/// Distance of the child from its goal with a given orientation: an arm of up to 0.5 m at an orientation
/// off by [`COMPENSATED_ROTATION`]; at its minimum over the orientation, so of second order in that.
pub const TIP: Limit = Limit::Absolute(4e-8, "m");

/// Below this sine of the angle between two directions f32 cannot tell whether they are parallel, or
/// which way their axis points: directions over 0.2 m between points near 1 m are rounded to 1e-6 rad, and
/// the core calls them degenerate from there. What is compared of such a body: its status is one of the two
/// possible ones; next to parallel, everything (the turn is as small as the rounding); next to antiparallel,
/// the world error if the core took it, else all but the rotation.
pub const RESOLVED_SINE: f64 = 1e-5;

/// Below this sine two directions that are almost opposite have an axis that is off by [`COMPENSATED_ROTATION`]
/// over the sine: the error is compared times the sine.
pub const ILL_CONDITIONED_SINE: f64 = 0.05;

/// Angles of the metrics: [`ROTATION`] in degrees.
pub const METRIC_ANGLE: Limit =
    Limit::Absolute(16.0 * HALF_ULP * 180.0 / std::f64::consts::PI, "deg");

/// Distances of the metrics: [`DIRECT_POSITION`] in centimetres.
pub const METRIC_DISTANCE: Limit = Limit::Absolute(2.4e-5, "cm");

/// Angular velocity over 10 ms: two quaternions, each component rounded to 3e-8 (6e-8 above 0.5), and
/// their product; twice that is an angle; over 0.01 s.
pub const DIFFERENCE_OMEGA: Limit = Limit::Absolute(4e-5, "rad/s");

/// Linear velocity over 10 ms: two positions of up to 2 m, each rounded to 6e-8 m, over 0.01 s.
pub const DIFFERENCE_VELOCITY: Limit = Limit::Absolute(1.2e-5, "m/s");

/// Angular acceleration over 10 ms: the difference of two velocities that may be off by
/// [`DIFFERENCE_OMEGA`], over 0.01 s.
pub const DIFFERENCE_ALPHA: Limit = Limit::Absolute(8e-3, "rad/s²");

/// Linear acceleration over 10 ms: the difference of two velocities that may be off by
/// [`DIFFERENCE_VELOCITY`], over 0.01 s.
pub const DIFFERENCE_ACCELERATION: Limit = Limit::Absolute(2.4e-3, "m/s²");

/// Volume, centre and inertia of solids, relative to each number: computed in f64, as the files are, in
/// less than 90 roundings of 1.1e-16 on either side, with no difference of like numbers among them.
pub const SOLID: Limit = Limit::Relative(1e-14);

/// Accelerations from torques, relative to the largest of the case: computed in f64, as the files are, so
/// f64's rounding times the condition of the mass matrix, which is some 1e4, trunk against hand; 3e-12 is
/// reached with 32 bodies.
pub const FORWARD: Limit = Limit::Relative(1e-11);

/// Accelerations from torques by the core, relative to the largest of the case: f32's rounding of the torques
/// and of the sums, times the condition of the mass matrix, which is some 1e4; 2.6e-4 is reached with 32 bodies.
pub const CORE_FORWARD: Limit = Limit::Relative(1e-3);

/// Weights by the length of descendants, each relative to itself: lengths of 0.1 m and more between positions of up
/// to 1 m, each coordinate rounded, added up with two roundings for every joint on the way; 2.5e-7 is reached.
pub const WEIGHT_OF_LENGTHS: Limit = Limit::Relative(10.0 * HALF_ULP);

/// Weights by the surface of cylinders, each relative to itself: as [`WEIGHT_OF_LENGTHS`], which area and distance
/// both have, the radius, and 1.6e-7 of the quadrature, which points in its place do not have; 4.8e-7 is reached with
/// points.
pub const WEIGHT_OF_CYLINDERS: Limit = Limit::Relative(16.0 * HALF_ULP);

/// Weights by the surface of a mesh, each relative to itself: area, skinning weight and position of a vertex are
/// rounded, its distance and their product, but not all one way, and their sum is compensated; 1.3e-7 is reached.
pub const WEIGHT_OF_MESH: Limit = Limit::Relative(6.0 * HALF_ULP);

/// Distances of poses in angles, relative: logarithms of rotations that are off by two roundings, and the root of a
/// sum of squares, which halves what is off; 3.1e-7 is reached.
pub const ANGLE_DISTANCE: Limit = Limit::Relative(20.0 * HALF_ULP);

/// Distances of poses in space and lengths of curves, relative: differences of positions that are off as
/// [`CHAIN_POSITION`] has it, of figures not ten times as large as the distance; 3.8e-7 is reached.
pub const POSE_DISTANCE: Limit = Limit::Relative(20.0 * HALF_ULP);

/// Energies of curves, relative: squares of [`POSE_DISTANCE`]; 6.0e-7 is reached.
pub const CURVE_ENERGY: Limit = Limit::Relative(40.0 * HALF_ULP);

/// Gradients of an energy, over the squared size of the figure times its number of joints: second differences of
/// positions, each times an arm; 6e-8 is reached.
pub const ENERGY_GRADIENT: Limit = Limit::Relative(5.0 * HALF_ULP);

/// By how much the energy of a geodesic may be above the golden one, relative, computed in f64 as the files are: at a
/// minimum, what its poses are off by counts squared. The promise is 1e-6; 5e-16 is reached.
pub const GEODESIC_ENERGY: Limit = Limit::Relative(1e-12);

/// Positions on geodesics, and their lengths, relative to the length: where the gradient ends at 1e-9 of the energy,
/// in the direction in which the energy bends least; 3e-11 of a length is reached.
pub const GEODESIC_PATH: Limit = Limit::Relative(1e-6);
