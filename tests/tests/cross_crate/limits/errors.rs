//! State errors of two states of a figure, and ticks that turn them into torques.

use std::f64::consts::PI;

use sinew_core::control::Gains;
use sinew_core::state_error::{
    Aim, AimStatus, Aims, Compensation, Method, StateError, linear_compensation, local, world,
};
use sinew_core::{JointTargets, TorqueController, Twist, Workspace};
use sinew_test_support::rig::{CAPACITY, Rig};
use sinew_verification::rounding::{
    Compensated, Difference, Joint, Motion, Number, State, Vector, turn_error,
};

use super::case::Case;
use super::dynamics::{GRAVITY_M_S2, Sides, vectors};
use super::tally::{Quantity, Table};

const GAINS: [f32; 2] = [900.0, 60.0];
const BETA: f32 = 0.7;

const LOCAL: [&str; 4] = ["local angle", "local way", "local rate", "local speed"];
const WORLD: [&str; 4] = ["world angle", "world way", "world rate", "world speed"];
const TURNED: [&str; 4] = ["turned angle", "turned way", "turned rate", "turned speed"];

/// Sine of an angle below which the core treats two directions as equal, or as opposite.
const SMALLEST_SINE: f64 = 1e-6;

/// Desired and measured figure, joints and bodies with their rounding.
struct Pair {
    desired: Side,
    measured: Side,
}

struct Side {
    sides: Sides,
    bodies: Vec<State>,
}

impl Side {
    fn new(rig: Rig) -> Self {
        let sides = Sides::new(rig);
        let bodies = sides.rounded.world();
        Self { sides, bodies }
    }
}

pub(crate) fn compare(case: &Case, table: &mut Table) {
    let (desired, measured) = case.figures();
    let pair = Pair { desired: Side::new(desired), measured: Side::new(measured) };
    let count = pair.desired.bodies.len();
    let (desired, measured) = (&pair.desired.sides, &pair.measured.sides);
    let mut got = vec![StateError::ZERO; count];

    local(&desired.states, &measured.states, &mut got);
    let of_joints: Vec<_> = (0..count).map(|body| pair.local(body)).collect();
    errors(table, LOCAL, &got, &of_joints, |_| 0.0);
    let [desired_world, measured_world] = [desired.rig.world(), measured.rig.world()];
    world(&desired_world, &measured_world, &mut got);
    let of_world: Vec<_> = (0..count).map(|body| pair.world(body)).collect();
    errors(table, WORLD, &got, &of_world, |_| 0.0);

    let aims = Aims::heaviest_child(&desired.rig.tree);
    let settings = Compensation { beta: BETA, ..Compensation::default() };
    let mut status = vec![AimStatus::Leaf; count];
    linear_compensation(
        aims.as_slice(),
        settings,
        &desired_world,
        &measured_world,
        &mut got,
        &mut status,
    );
    // The axis of a half turn is arbitrary: such cases are not compared.
    let turned: Option<Vec<_>> =
        (0..count).map(|body| pair.turned(body, aims.as_slice()[body], status[body])).collect();
    if let Some(turned) = &turned {
        let of_body: Vec<_> = turned.iter().map(|turned| turned.difference).collect();
        errors(table, TURNED, &got, &of_body, |body| turned[body].left_out_rad);
    }

    tick(table, &pair, "tick of local", Method::Local, &of_joints);
    tick(table, &pair, "tick of world", Method::World, &of_world);
    let method = Method::LinearCompensation { aims, settings };
    if let Some(turned) = turned.filter(|all| all.iter().all(|turned| turned.left_out_rad <= 0.0)) {
        let of_body: Vec<_> = turned.iter().map(|turned| turned.difference).collect();
        tick(table, &pair, "tick of compensation", method, &of_body);
    }
}

impl Pair {
    fn local(&self, body: usize) -> Difference {
        let seen = |side: &Side| side.sides.rounded.joints[body].in_parent();
        Difference::between(&seen(&self.desired), &seen(&self.measured))
    }

    fn world(&self, body: usize) -> Difference {
        Difference::between(&self.desired.bodies[body], &self.measured.bodies[body])
    }

    /// Returns the error of a body by Linear Compensation. Returns `None` if f32 cannot distinguish the turn from a
    /// half turn, and the core did not report one.
    fn turned(&self, body: usize, aim: Aim, status: AimStatus) -> Option<Turned> {
        let of = |difference| Some(Turned { difference, left_out_rad: 0.0 });
        let Aim::Child(child) = aim else { return of(self.world(body)) };
        let [desired, measured] = [&self.desired.bodies[body], &self.measured.bodies[body]];
        let arm = self.desired.bodies[child].position - desired.position;
        let turned = Compensated::new(arm, Number::known(f64::from(BETA)), desired, measured);
        let way = arm.exact() + desired.position.exact() - measured.position.exact();
        let unclear = turned.sine.limit() > 0.1 * turned.sine.exact();
        if unclear && arm.exact().dot(way) < 0.0 {
            return if status == AimStatus::Antiparallel { of(self.world(body)) } else { None };
        }
        // If f32 cannot distinguish two directions, the core leaves out the turn between them, which is then very
        // small.
        let largest = SMALLEST_SINE + turned.sine.limit();
        let left_out_rad = if turned.sine.exact() < largest { largest } else { 0.0 };
        Some(Turned { difference: turned.difference, left_out_rad })
    }
}

/// An error by Linear Compensation.
struct Turned {
    difference: Difference,
    /// Size of a turn that the core may have left out, rad.
    left_out_rad: f64,
}

fn errors(
    table: &mut Table,
    names: [&'static str; 4],
    got: &[StateError],
    rounded: &[Difference],
    left_out_rad: impl Fn(usize) -> f64,
) {
    for (body, (got, rounded)) in got.iter().zip(rounded).enumerate() {
        let error = turn_error(got.angular_rad.as_dvec3(), rounded.angular.exact());
        let quantity = Quantity { name: names[0], unit: "rad", scale: PI };
        let limit = rounded.angular.limit() + left_out_rad(body);
        table.add(quantity, format_args!("body {body}"), error, limit);
    }
    let ways = got.iter().map(|error| error.linear_m);
    vectors(table, [names[1], "m"], ways, rounded.iter().map(|error| error.linear));
    let rates = got.iter().map(|error| error.angular_rate_rad_s);
    vectors(table, [names[2], "rad/s"], rates, rounded.iter().map(|error| error.angular_rate));
    let speeds = got.iter().map(|error| error.linear_rate_m_s);
    vectors(table, [names[3], "m/s"], speeds, rounded.iter().map(|error| error.linear_rate));
}

/// Compares the wrenches of a controller's tick with wrenches that are computed from the same errors, with their
/// rounding.
fn tick(
    table: &mut Table,
    pair: &Pair,
    name: &'static str,
    method: Method<CAPACITY>,
    rounded: &[Difference],
) {
    let local = matches!(method, Method::Local);
    let rig = &pair.measured.sides.rig;
    let gains = Gains::new(GAINS[0], GAINS[1]).expect("gains are positive");
    let controller = TorqueController::new(rig.tree.clone(), gains, method)
        .and_then(|controller| controller.with_gravity(GRAVITY_M_S2))
        .expect("a figure has no joint that a method cannot do");
    let mut targets = JointTargets::rest(&rig.tree);
    for (body, state) in pair.desired.sides.states.iter().enumerate() {
        targets.set(body, *state, Twist::ZERO).expect("a desired state is finite");
    }
    let mut workspace = Workspace::resolving();
    let got = controller.tick(&mut targets, &rig.states(), &[], &mut workspace);

    let Side { sides, bodies } = &pair.measured;
    let [kp, kv] = GAINS.map(|gain| Number::known(f64::from(gain)));
    let command = |(body, error): (usize, &Difference)| {
        let joint: &Joint = &sides.rounded.joints[body];
        let to_body = if local { joint.rotation } else { bodies[body].rotation }.inverse();
        let wanted = |way: Vector, rate: Vector| to_body.turn(way * kp + rate * kv);
        let angular = wanted(error.angular, error.angular_rate);
        let linear = if body == 0 { wanted(error.linear, error.linear_rate) } else { Vector::ZERO };
        Motion { angular, linear }
    };
    let commands: Vec<_> = rounded.iter().enumerate().map(command).collect();
    let needed = sides.rounded_wrenches(&commands);
    let moments = got.iter().map(|wrench| wrench.value.moment_nm);
    vectors(table, [name, "N m"], moments, needed.iter().map(|motion| motion.angular));
}
