//! Forward dynamics by the articulated-body algorithm.

use sinew_core::JointKind;

use super::link::Link;
use super::motion::Motion;
use super::number::Number;
use super::space::{Matrix, Vector};
use super::states::Joint;

type Six = [Number; 6];
type Inertia = [Six; 6];

struct Body {
    matrix: Matrix,
    columns: Vec<Six>,
    /// Acceleration from the motion of the joint's own axes.
    along_axes: Vector,
    /// Acceleration of the body, relative to its parent's, that results from velocities alone.
    moving: Six,
    inertia: Inertia,
    wrench: Six,
    response: Response,
}

/// Response of a ball joint with a rotor: the constant part, the part per acceleration of the origin, and the part
/// of the carried acceleration that is transmitted.
struct Ball {
    turn: Vector,
    per_way: Matrix,
    held: Matrix,
}

/// Response of a joint.
enum Response {
    /// A joint that moves along its dofs: wrenches of unit accelerations, resistance of the dofs, and remaining push.
    Along { met: Vec<Six>, resistance: Vec<Vec<Number>>, push: Vec<Number> },
    /// A ball joint that turns about any axis, against a rotor.
    Ball(Box<Ball>),
}

/// Computes the accelerations of each joint's dofs under these wrenches of their drives, like
/// [`forward_dynamics`](sinew_core::dynamics::forward_dynamics).
pub fn forward_dynamics(
    links: &[Link],
    joints: &[Joint],
    drives: &[Motion],
    gravity: Vector,
) -> Vec<Motion> {
    let mut bodies: Vec<Body> = Vec::with_capacity(links.len());
    let mut velocities: Vec<Vector> = Vec::with_capacity(links.len());
    for (link, joint) in links.iter().zip(joints) {
        let parent = link.parent.map_or(Vector::ZERO, |parent| velocities[parent]);
        let (velocity, body) = start(link, joint, parent);
        velocities.push(velocity);
        bodies.push(body);
    }
    for (index, link) in links.iter().enumerate().rev() {
        let passed = bodies[index].give_way(link, drives[index]);
        if let Some(parent) = link.parent {
            let (inertia, wrench) = passed.in_parent(&bodies[index].matrix, joints[index].arm);
            let of_parent = &mut bodies[parent];
            of_parent.wrench = sum(of_parent.wrench, wrench);
            for (row, added) in of_parent.inertia.iter_mut().zip(inertia) {
                *row = sum(*row, added);
            }
        }
    }
    let world = Motion { angular: Vector::ZERO, linear: -gravity };
    let mut accelerations: Vec<Motion> = Vec::with_capacity(links.len());
    let mut out = Vec::with_capacity(links.len());
    for ((link, joint), body) in links.iter().zip(joints).zip(&bodies) {
        let parent = link.parent.map_or(world, |parent| accelerations[parent]);
        let (of_joint, of_body) = body.follow(parent, joint.arm);
        out.push(of_joint);
        accelerations.push(of_body);
    }
    out
}

fn start(link: &Link, joint: &Joint, parent: Vector) -> (Vector, Body) {
    let matrix = joint.rotation.matrix();
    let carried = matrix.turn_back(parent);
    let of_joint = joint.velocity;
    let velocity = carried + of_joint.angular;
    let columns = link.columns_by_parent(&matrix);
    let along_axes = if let [first, second] = columns[..] {
        let speeds = first.angular.dot(of_joint.angular) * second.angular.dot(of_joint.angular);
        first.angular.cross(second.angular) * speeds
    } else {
        Vector::ZERO
    };
    let angular = carried.cross(of_joint.angular) + along_axes;
    let linear = matrix.turn_back(parent.cross(parent.cross(joint.arm)))
        + carried.cross(of_joint.linear).doubled(2.0);

    let (first_moment, inertia) = about_origin(link);
    let spin = velocity.cross(Matrix::of_columns(inertia).turn(velocity));
    let turning = velocity.cross(velocity.cross(first_moment));
    let body = Body {
        matrix,
        columns: columns.into_iter().map(Motion::components).collect(),
        along_axes,
        moving: Motion { angular, linear }.components(),
        inertia: rigid(link.mass, first_moment, inertia),
        wrench: Motion { angular: spin, linear: turning }.components(),
        response: Response::Along { met: vec![], resistance: vec![], push: vec![] },
    };
    (velocity, body)
}

/// Returns the first moment, and the columns of the inertia about the origin.
fn about_origin(link: &Link) -> (Vector, [Vector; 3]) {
    let (c, m) = (link.center, link.mass);
    let moment = c * m;
    let units = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let columns = units.map(|unit| {
        let [x, y, z] = unit.map(Number::known);
        let unit = Vector { x, y, z };
        link.inertia.turn(unit) + unit * c.dot(moment) - moment * c.dot(unit)
    });
    (moment, columns)
}

fn rigid(mass: Number, moment: Vector, inertia: [Vector; 3]) -> Inertia {
    let o = Number::ZERO;
    let Vector { x, y, z } = moment;
    let [a, b, c] = inertia.map(Vector::components);
    [
        [a[0], b[0], c[0], o, -z, y],
        [a[1], b[1], c[1], z, o, -x],
        [a[2], b[2], c[2], -y, x, o],
        [o, z, -y, mass, o, o],
        [-z, o, x, o, mass, o],
        [y, -x, o, o, o, mass],
    ]
}

/// The load that a joint transmits to its parent: a part per acceleration of the parent, and a constant part.
struct Passed {
    inertia: Inertia,
    wrench: Six,
}

impl Body {
    fn give_way(&mut self, link: &Link, drive: Motion) -> Passed {
        if link.joint == JointKind::Spherical && link.rotor.exact() > 0.0 {
            return self.turn_any_way_with_rotor(drive.angular, link.rotor);
        }
        let drive = drive.components();
        let dofs = self.columns.len();
        let met: Vec<_> = self.columns.iter().map(|column| times(&self.inertia, *column)).collect();
        let resists = |i: usize, j: usize| {
            let of = dot(self.columns[i], met[j]);
            if i == j { of + link.rotor } else { of }
        };
        let resistance: Vec<Vec<_>> =
            (0..dofs).map(|i| (0..dofs).map(|j| resists(i, j)).collect()).collect();
        let push: Vec<_> = self
            .columns
            .iter()
            .map(|column| dot(*column, drive) - dot(*column, self.wrench))
            .collect();
        // For each column of the inertia: the response of the dofs.
        let mut inertia = self.inertia;
        for column in 0..6 {
            let wanted: Vec<_> = met.iter().map(|met| met[column]).collect();
            let moved = solve(resistance.clone(), wanted);
            for (row, numbers) in inertia.iter_mut().enumerate() {
                for (met, moved) in met.iter().zip(&moved) {
                    numbers[column] = numbers[column] - met[row] * *moved;
                }
            }
        }
        let alone = solve(resistance.clone(), push.clone());
        let mut wrench = sum(self.wrench, times(&inertia, self.moving));
        for (met, alone) in met.iter().zip(&alone) {
            wrench = sum(wrench, met.map(|of| of * *alone));
        }
        self.response = Response::Along { met, resistance, push };
        Passed { inertia, wrench }
    }

    /// Computes the load that a ball joint with a rotor transmits, like the core: with `r (I + r)⁻¹` of the body's
    /// resistance, which avoids a difference.
    fn turn_any_way_with_rotor(&mut self, drive: Vector, rotor: Number) -> Passed {
        let block = |row: usize, column: usize| {
            let of = |k: usize| Vector {
                x: self.inertia[row][column + k],
                y: self.inertia[row + 1][column + k],
                z: self.inertia[row + 2][column + k],
            };
            Matrix::of_columns([of(0), of(1), of(2)])
        };
        let (angular, coupling, linear) = (block(0, 0), block(0, 3), block(3, 3));
        let with_rotor = angular.map_columns(|k, column| column + Vector::along(k, rotor));
        let columns = with_rotor.transposed();
        let rows: Vec<Vec<_>> = [0, 1, 2].map(|k| columns.column(k).components().to_vec()).to_vec();
        let inverse = Matrix::of_columns([0, 1, 2].map(|k| {
            let unit = Vector::along(k, Number::known(1.0)).components().to_vec();
            let solved = solve(rows.clone(), unit);
            Vector { x: solved[0], y: solved[1], z: solved[2] }
        }));
        let wrench = motion(self.wrench);
        let free = drive - wrench.angular;
        let turn = inverse.turn(free);
        let per_way = inverse.times(&coupling);
        let held = inverse.map_columns(|_, column| column * rotor);
        let back = coupling.transposed();
        let (angular, coupling) = (held.times(&angular), held.times(&coupling));
        let given_way = back.times(&per_way);
        let linear = linear.map_columns(|k, column| column - given_way.column(k));
        let forces = coupling.transposed();
        let inertia = transposed(&std::array::from_fn(|column| {
            let (of, k) = if column < 3 {
                ((&angular, &forces), column)
            } else {
                ((&coupling, &linear), column - 3)
            };
            Motion { angular: of.0.column(k), linear: of.1.column(k) }.components()
        }));
        let wrench =
            Motion { angular: drive - held.turn(free), linear: wrench.linear + back.turn(turn) };
        let wrench = sum(wrench.components(), times(&inertia, self.moving));
        self.response = Response::Ball(Box::new(Ball { turn, per_way, held }));
        Passed { inertia, wrench }
    }

    fn follow(&self, parent: Motion, arm: Vector) -> (Motion, Motion) {
        let carried = Motion {
            angular: self.matrix.turn_back(parent.angular),
            linear: self.matrix.turn_back(parent.linear + parent.angular.cross(arm)),
        };
        let carried = sum(carried.components(), self.moving);
        let of_body =
            match &self.response {
                Response::Along { met, resistance, push } => {
                    let push = push.iter().zip(met).map(|(push, met)| *push - dot(*met, carried));
                    let along = solve(resistance.clone(), push.collect());
                    let steps = self.columns.iter().zip(along);
                    motion(steps.fold(carried, |all, (column, along)| {
                        sum(all, column.map(|of| of * along))
                    }))
                }
                Response::Ball(ball) => {
                    let Ball { turn, per_way, held } = &**ball;
                    let Motion { angular, linear } = motion(carried);
                    Motion { angular: *turn - per_way.turn(linear) + held.turn(angular), linear }
                }
            };
        // The joint's own acceleration is the body's minus the carried acceleration.
        let carried = motion(carried);
        let of_joint = Motion {
            angular: self.along_axes + (of_body.angular - carried.angular),
            linear: of_body.linear - carried.linear,
        };
        (of_joint, of_body)
    }
}

impl Passed {
    /// Returns the load in the parent's axes, about its origin.
    fn in_parent(&self, matrix: &Matrix, arm: Vector) -> (Inertia, Six) {
        let wrench = |six: Six| {
            let Motion { angular, linear } = motion(six);
            let force = matrix.turn(linear);
            let moment = matrix.turn(angular).plus_cross(arm, force);
            Motion { angular: moment, linear: force }.components()
        };
        // Columns are converted as wrenches, then rows.
        let columns = transposed(&self.inertia).map(wrench);
        (transposed(&columns).map(wrench), wrench(self.wrench))
    }
}

fn motion([a, b, c, d, e, f]: Six) -> Motion {
    Motion { angular: Vector { x: a, y: b, z: c }, linear: Vector { x: d, y: e, z: f } }
}

fn transposed(matrix: &Inertia) -> Inertia {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[column][row]))
}

fn sum(a: Six, b: Six) -> Six {
    std::array::from_fn(|k| a[k] + b[k])
}

fn dot(a: Six, b: Six) -> Number {
    a.into_iter().zip(b).fold(Number::ZERO, |sum, (a, b)| sum + a * b)
}

fn times(matrix: &Inertia, v: Six) -> Six {
    std::array::from_fn(|row| dot(matrix[row], v))
}

/// Solves by elimination. The matrix is positive definite: no pivoting is needed.
fn solve(mut matrix: Vec<Vec<Number>>, mut right: Vec<Number>) -> Vec<Number> {
    let count = right.len();
    for pivot in 0..count {
        for row in pivot + 1..count {
            let factor = matrix[row][pivot] / matrix[pivot][pivot];
            let of_pivot = matrix[pivot].clone();
            for (number, of_pivot) in matrix[row].iter_mut().zip(of_pivot).skip(pivot) {
                *number = *number - factor * of_pivot;
            }
            right[row] = right[row] - factor * right[pivot];
        }
    }
    for row in (0..count).rev() {
        for column in row + 1..count {
            right[row] = right[row] - matrix[row][column] * right[column];
        }
        right[row] = right[row] / matrix[row][row];
    }
    right
}
