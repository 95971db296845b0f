//! Inverse dynamics by the recursive Newton-Euler algorithm; the mass matrix by that algorithm, column by column, and
//! by the composite-rigid-body algorithm.

use sinew_core::JointKind;

use super::link::Link;
use super::motion::Motion;
use super::number::Number;
use super::space::{Matrix, Rotation, Vector};
use super::states::Joint;

#[derive(Clone, Copy)]
struct BodyMotion {
    velocity: Vector,
    acceleration: Motion,
}

/// Computes the wrench of each joint on its body about its origin, body axes, like
/// [`inverse_dynamics`](sinew_core::dynamics::inverse_dynamics).
pub fn inverse_dynamics(
    links: &[Link],
    joints: &[Joint],
    accelerations: &[Motion],
    gravity: Vector,
) -> Vec<Motion> {
    let world = BodyMotion {
        velocity: Vector::ZERO,
        acceleration: Motion { angular: Vector::ZERO, linear: -gravity },
    };
    let mut motions: Vec<BodyMotion> = Vec::with_capacity(links.len());
    let mut wrenches = Vec::with_capacity(links.len());
    let matrices: Vec<_> = joints.iter().map(|joint| joint.rotation.matrix()).collect();
    for (index, link) in links.iter().enumerate() {
        let parent = link.parent.map_or(world, |parent| motions[parent]);
        let motion =
            outward(&parent, &matrices[index], link, &joints[index], &accelerations[index]);
        wrenches.push(needed(link, &motion));
        motions.push(motion);
    }
    for (index, link) in links.iter().enumerate().rev() {
        let (of_body, acceleration) = (wrenches[index], &accelerations[index]);
        if let Some(parent) = link.parent {
            let force = matrices[index].turn(of_body.linear);
            let moment = matrices[index].turn(of_body.angular).plus_cross(joints[index].arm, force);
            let of_parent: &mut Motion = &mut wrenches[parent];
            of_parent.angular = of_parent.angular + moment;
            of_parent.linear = of_parent.linear + force;
        }
        if link.rotor.exact() > 0.0 {
            let wrench = &mut wrenches[index];
            wrench.angular = wrench.angular + acceleration.angular * link.rotor;
            if slides(link) {
                wrench.linear = wrench.linear + acceleration.linear * link.rotor;
            }
        }
    }
    wrenches
}

fn slides(link: &Link) -> bool {
    matches!(link.joint, JointKind::Prismatic { .. } | JointKind::Free)
}

fn outward(
    parent: &BodyMotion,
    matrix: &Matrix,
    link: &Link,
    joint: &Joint,
    acceleration: &Motion,
) -> BodyMotion {
    let Motion { angular, linear } = parent.acceleration;
    let (arm, w) = (joint.arm, joint.velocity.angular);
    let carried = matrix.turn_back(parent.velocity);
    let turning = parent.velocity.cross(arm);
    let at_joint = linear + angular.cross(arm) + parent.velocity.cross(turning);
    let mut linear = matrix.turn_back(at_joint);
    if slides(link) {
        linear = linear + (carried.cross(joint.velocity.linear.doubled(2.0)) + acceleration.linear);
    }
    let angular = matrix.turn_back(angular) + acceleration.angular + carried.cross(w);
    BodyMotion { velocity: carried + w, acceleration: Motion { angular, linear } }
}

fn needed(link: &Link, motion: &BodyMotion) -> Motion {
    let (w, Motion { angular, linear }) = (motion.velocity, motion.acceleration);
    let turning = w.cross(link.center);
    let force = linear.plus_cross(angular, link.center).plus_cross(w, turning) * link.mass;
    let spin = link.inertia.turn(w);
    let about_center = link.inertia.turn(angular).plus_cross(w, spin);
    Motion { angular: about_center.plus_cross(link.center, force), linear: force }
}

/// Returns the dofs of a rig: body and motion of each, in the order of the core's mass matrix.
fn dofs(links: &[Link], columns: impl Fn(usize, &Link) -> Vec<Motion>) -> Vec<(usize, Motion)> {
    let of_body = |(body, link): (usize, &Link)| {
        columns(body, link).into_iter().map(move |column| (body, column)).collect::<Vec<_>>()
    };
    links.iter().enumerate().flat_map(of_body).collect()
}

/// Computes the mass matrix column by column, as the wrenches of a unit acceleration at rest.
pub fn mass_matrix_by_torques(links: &[Link], joints: &[Joint]) -> Vec<Vec<Number>> {
    let still: Vec<_> = joints.iter().map(Joint::still).collect();
    let dofs = dofs(links, |body, link| link.columns(&joints[body]));
    let column = |(moved, unit): &(usize, Motion)| {
        let mut accelerations = vec![Motion::ZERO; links.len()];
        accelerations[*moved] = *unit;
        let wrenches = inverse_dynamics(links, &still, &accelerations, Vector::ZERO);
        dofs.iter().map(|(body, along)| along.dot(&wrenches[*body])).collect()
    };
    dofs.iter().map(column).collect()
}

/// Computes the mass matrix by the composite-rigid-body algorithm. It is zero where neither joint moves the
/// other's body.
pub fn mass_matrix(links: &[Link], joints: &[Joint]) -> Vec<Vec<Number>> {
    let matrices: Vec<_> = joints.iter().map(|joint| joint.rotation.matrix()).collect();
    let mut composites: Vec<_> = links.iter().map(Composite::of).collect();
    for (index, link) in links.iter().enumerate().rev() {
        if let Some(parent) = link.parent {
            let carried = composites[index].turned(&matrices[index]).moved(joints[index].arm);
            composites[parent] = composites[parent].plus(&carried);
        }
    }
    // Converts bodies, and the vectors from their parents, to the axes of the root, whose own rotation is zero.
    let mut turns: Vec<Rotation> = Vec::with_capacity(links.len());
    let mut rotations: Vec<Matrix> = Vec::with_capacity(links.len());
    let mut arms = Vec::with_capacity(links.len());
    for (link, joint) in links.iter().zip(joints) {
        let (turn, arm) = match link.parent {
            Some(parent) => {
                (turns[parent].after(joint.rotation).unit(), rotations[parent].turn(joint.arm))
            }
            None => (Rotation::identity(), joint.arm),
        };
        turns.push(turn);
        rotations.push(turn.matrix());
        arms.push(arm);
    }
    let dofs = dofs(links, |body, link| link.columns_by_parent(&matrices[body]));
    let turned: Vec<_> = dofs.iter().map(|(body, along)| along.turned(&rotations[*body])).collect();
    let mut rows = vec![vec![Number::ZERO; dofs.len()]; dofs.len()];
    for (row, (body, unit)) in dofs.iter().enumerate() {
        let of = |body| dofs.iter().enumerate().filter(move |(_, (of, _))| *of == body);
        let in_body = composites[*body].wrench(unit);
        for (column, (_, along)) in of(*body) {
            let element = along.dot(&in_body);
            let element = if row == column { element + links[*body].rotor } else { element };
            (rows[row][column], rows[column][row]) = (element, element);
        }
        let mut wrench = in_body.turned(&rotations[*body]);
        let mut at = *body;
        while let Some(parent) = links[at].parent {
            wrench.angular = wrench.angular + arms[at].cross(wrench.linear);
            for (column, _) in of(parent) {
                let element = turned[column].dot(&wrench);
                (rows[row][column], rows[column][row]) = (element, element);
            }
            at = parent;
        }
    }
    rows
}

/// Several rigidly connected bodies, with their inertia about an origin.
#[derive(Clone, Copy)]
struct Composite {
    mass: Number,
    moment: Vector,
    inertia: Matrix,
}

impl Composite {
    fn of(link: &Link) -> Self {
        Self { mass: link.mass, moment: Vector::ZERO, inertia: link.inertia }.moved(link.center)
    }

    /// Returns the inertia about an origin from which the present origin is `arm` away.
    fn moved(&self, arm: Vector) -> Self {
        let way = arm * self.mass;
        let halfway = self.moment + way.doubled(0.5);
        let twice = arm.dot(halfway).doubled(2.0);
        let inertia = self.inertia.map_columns(|k, column| {
            let (a, h) = (arm.components()[k], halfway.components()[k]);
            column + (Vector::along(k, twice) - (arm * h + halfway * a))
        });
        Self { mass: self.mass, moment: self.moment + way, inertia }
    }

    fn turned(&self, rotation: &Matrix) -> Self {
        let half = self.inertia.map_columns(|_, column| rotation.turn(column)).transposed();
        Self {
            mass: self.mass,
            moment: rotation.turn(self.moment),
            inertia: half.map_columns(|_, column| rotation.turn(column)),
        }
    }

    fn plus(&self, other: &Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            moment: self.moment + other.moment,
            inertia: self.inertia.plus(&other.inertia),
        }
    }

    fn wrench(&self, of: &Motion) -> Motion {
        Motion {
            angular: self.inertia.turn(of.angular).plus_cross(self.moment, of.linear),
            linear: (of.linear * self.mass).plus_cross(of.angular, self.moment),
        }
    }
}
