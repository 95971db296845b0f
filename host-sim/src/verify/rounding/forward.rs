//! Forward dynamics by the articulated-body algorithm.

use super::dynamics::{Link, Motion};
use super::number::Number;
use super::space::{Matrix, Vector};
use super::states::Joint;

type Six = [Number; 6];
type Inertia = [Six; 6];

struct Body {
    matrix: Matrix,
    columns: Vec<Six>,
    /// By velocities alone: of the body, from its parent's.
    moving: Six,
    inertia: Inertia,
    wrench: Six,
    /// Wrenches that the freedoms meet, and what they make of the rest.
    met: Vec<Six>,
    resistance: Vec<Vec<Number>>,
    push: Vec<Number>,
}

/// Accelerations of the freedoms of each joint that these wrenches of their drives make, as
/// [`forward_dynamics`](sinew_core::dynamics::forward_dynamics) has them but for what a universal joint's axes add by
/// moving.
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
        let passed = bodies[index].give_way(drives[index], link.rotor);
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
    let columns: Vec<_> = link.columns(joint);
    let mut angular = carried.cross(of_joint.angular);
    if let [first, second] = columns[..] {
        let speeds = first.angular.dot(of_joint.angular) * second.angular.dot(of_joint.angular);
        angular = angular + first.angular.cross(second.angular) * speeds;
    }
    let linear = matrix.turn_back(parent.cross(parent.cross(joint.arm)))
        + carried.cross(of_joint.linear).doubled(2.0);

    let (first_moment, inertia) = about_origin(link);
    let spin = velocity.cross(Matrix::of_columns(inertia).turn(velocity));
    let turning = velocity.cross(velocity.cross(first_moment));
    let body = Body {
        matrix,
        columns: columns.into_iter().map(Motion::components).collect(),
        moving: Motion { angular, linear }.components(),
        inertia: rigid(link.mass, first_moment, inertia),
        wrench: Motion { angular: spin, linear: turning }.components(),
        met: Vec::new(),
        resistance: Vec::new(),
        push: Vec::new(),
    };
    (velocity, body)
}

/// First moment, and the columns of the inertia about the origin.
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

/// What a joint passes on: as much per acceleration of the parent, and so much anyway.
struct Passed {
    inertia: Inertia,
    wrench: Six,
}

impl Body {
    fn give_way(&mut self, drive: Motion, rotor: Number) -> Passed {
        let drive = drive.components();
        let freedoms = self.columns.len();
        self.met = self.columns.iter().map(|column| times(&self.inertia, *column)).collect();
        self.resistance = (0..freedoms)
            .map(|i| {
                (0..freedoms)
                    .map(|j| {
                        let of = dot(self.columns[i], self.met[j]);
                        if i == j { of + rotor } else { of }
                    })
                    .collect()
            })
            .collect();
        self.push = self
            .columns
            .iter()
            .map(|column| dot(*column, drive) - dot(*column, self.wrench))
            .collect();
        // Column by column of the inertia: what the freedoms do about it.
        let mut inertia = self.inertia;
        for column in 0..6 {
            let wanted: Vec<_> = self.met.iter().map(|met| met[column]).collect();
            let moved = solve(self.resistance.clone(), wanted);
            for (row, numbers) in inertia.iter_mut().enumerate() {
                for (met, moved) in self.met.iter().zip(&moved) {
                    numbers[column] = numbers[column] - met[row] * *moved;
                }
            }
        }
        let alone = solve(self.resistance.clone(), self.push.clone());
        let mut wrench = sum(self.wrench, times(&inertia, self.moving));
        for (met, alone) in self.met.iter().zip(&alone) {
            wrench = sum(wrench, met.map(|of| of * *alone));
        }
        Passed { inertia, wrench }
    }

    fn follow(&self, parent: Motion, arm: Vector) -> (Motion, Motion) {
        let carried = Motion {
            angular: self.matrix.turn_back(parent.angular),
            linear: self.matrix.turn_back(parent.linear + parent.angular.cross(arm)),
        };
        let carried = sum(carried.components(), self.moving);
        let push = self.push.iter().zip(&self.met).map(|(push, met)| *push - dot(*met, carried));
        let along = solve(self.resistance.clone(), push.collect());
        let of_joint =
            self.columns.iter().zip(along).fold([Number::ZERO; 6], |all, (column, along)| {
                sum(all, column.map(|of| of * along))
            });
        (motion(of_joint), motion(sum(carried, of_joint)))
    }
}

impl Passed {
    /// The same in the parent's axes, about its origin.
    fn in_parent(&self, matrix: &Matrix, arm: Vector) -> (Inertia, Six) {
        let wrench = |six: Six| {
            let Motion { angular, linear } = motion(six);
            let force = matrix.turn(linear);
            let moment = matrix.turn(angular).plus_cross(arm, force);
            Motion { angular: moment, linear: force }.components()
        };
        // Columns as wrenches, then rows as such.
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

/// By elimination; the matrix is positive definite, so no pivot is needed.
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
