//! Tests of dynamics in coordinates: properties on random trees, and refusals.

use sinew_core::coordinates::CoordinatesError;
use sinew_core::glam::{Quat, Vec3};
use sinew_core::{Body, Inertia, JointKind, Transform, Tree, math};

/// Bodies of a tree.
const N: usize = 10;

/// A source of numbers, with a fixed seed (xorshift; Marsaglia 2003).
struct Random(u32);

impl Random {
    fn bits(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 >> 8
    }

    fn number(&mut self) -> f32 {
        self.bits() as f32 / 8_388_608.0 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    fn rotation(&mut self) -> Quat {
        math::exp(self.vector() * 2.0)
    }

    fn below(&mut self, count: usize) -> usize {
        self.bits() as usize % count
    }

    fn numbers(&mut self, count: usize) -> Vec<f32> {
        (0..count).map(|_| 2.0 * self.number()).collect()
    }

    /// Returns a tree of joints of all kinds. Only a root is free.
    fn tree(&mut self) -> Tree<N> {
        let mut tree = Tree::new();
        for index in 0..N {
            let turned = self.rotation();
            let kinds = [
                JointKind::Revolute { axis: turned * Vec3::X },
                JointKind::Prismatic { axis: turned * Vec3::X },
                JointKind::Universal { first: turned * Vec3::X, second: turned * Vec3::Y },
                JointKind::Spherical,
                JointKind::Fixed,
                JointKind::Free,
            ];
            let body = Body {
                parent: (index > 0).then(|| self.below(index.max(1))),
                joint: kinds[self.below(if index == 0 { 6 } else { 5 })],
                placement: Transform::new(self.rotation(), self.vector() * 0.3),
                inertia: Inertia::of_box(
                    1.2 + self.number(),
                    self.vector() * 0.1,
                    self.vector() * 0.1 + Vec3::splat(0.2),
                ),
                rotor_inertia: 0.0,
            };
            tree.push(body).unwrap();
        }
        tree
    }

    /// Returns positions of all joints, with unit quaternions for ball joints.
    fn positions(&mut self, tree: &Tree<N>) -> Vec<f32> {
        let mut q = Vec::new();
        for body in tree.bodies() {
            match body.joint {
                JointKind::Spherical => q.extend(self.rotation().to_array()),
                JointKind::Free => {
                    q.extend(self.rotation().to_array());
                    q.extend(self.vector().to_array());
                }
                joint => q.extend(self.numbers(joint.dof_count())),
            }
        }
        q
    }
}

/// Calls `check` with trees, a state of each, and accelerations.
fn for_each_motion(mut check: impl FnMut(&Tree<N>, &[f32], &[f32], &[f32])) {
    let mut random = Random(20_261_128);
    for _ in 0..200 {
        let tree = random.tree();
        let q = random.positions(&tree);
        let [qd, qdd] = [0, 1].map(|_| random.numbers(tree.dof_count()));
        check(&tree, &q, &qd, &qdd);
    }
}

fn largest(numbers: &[f32]) -> f32 {
    numbers.iter().fold(0.0, |most, x| most.max(x.abs()))
}

fn product(matrix: &[f32], x: &[f32]) -> Vec<f32> {
    matrix.chunks(x.len()).map(|row| row.iter().zip(x).map(|(h, x)| h * x).sum()).collect()
}

fn difference(a: &[f32], b: &[f32]) -> f32 {
    largest(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>())
}

fn mass_matrix(tree: &Tree<N>, q: &[f32]) -> Vec<f32> {
    let mut matrix = vec![f32::NAN; tree.dof_count().pow(2)];
    tree.mass_matrix(q, &mut matrix).unwrap();
    matrix
}

#[test]
fn forward_dynamics_is_the_way_back_from_inverse_dynamics() {
    for_each_motion(|tree, q, qd, qdd| {
        let (mut tau, mut back) = (vec![0.0; qd.len()], vec![0.0; qd.len()]);
        tree.inverse_dynamics(q, qd, qdd, &mut tau).unwrap();
        tree.forward_dynamics(q, qd, &tau, &mut back).unwrap();
        // Compared as efforts, because accelerations may be off by the condition number of the matrix.
        let off: Vec<f32> = back.iter().zip(qdd).map(|(a, b)| a - b).collect();
        let off = largest(&product(&mass_matrix(tree, q), &off));
        assert!(off <= 2e-5 * largest(&tau).max(1.0), "off by {off:e} of {}", largest(&tau));
    });
}

#[test]
fn the_mass_matrix_is_symmetric_positive_definite_and_that_of_inverse_dynamics() {
    for_each_motion(|tree, q, qd, qdd| {
        let (matrix, size) = (mass_matrix(tree, q), qd.len());
        for row in 0..size {
            for column in 0..row {
                assert_eq!(
                    matrix[row * size + column].to_bits(),
                    matrix[column * size + row].to_bits()
                );
            }
        }
        // Cholesky's factors, in f64: all pivots are positive.
        let mut l = vec![0.0_f64; size * size];
        for row in 0..size {
            for column in 0..=row {
                let sum: f64 = (0..column).map(|k| l[row * size + k] * l[column * size + k]).sum();
                let rest = f64::from(matrix[row * size + column]) - sum;
                if row == column {
                    assert!(rest > 0.0, "a pivot of {rest}");
                    l[row * size + row] = rest.sqrt();
                } else {
                    l[row * size + column] = rest / l[column * size + column];
                }
            }
        }
        // H qdd is the effort of an acceleration without the bias.
        let (mut whole, mut bias) = (vec![0.0; size], vec![0.0; size]);
        tree.inverse_dynamics(q, qd, qdd, &mut whole).unwrap();
        tree.inverse_dynamics(q, qd, &vec![0.0; size], &mut bias).unwrap();
        let by_matrix: Vec<f32> =
            product(&matrix, qdd).iter().zip(&bias).map(|(a, b)| a + b).collect();
        let off = difference(&whole, &by_matrix);
        assert!(off <= 1e-5 * largest(&whole).max(largest(&bias)).max(1.0), "off by {off:e}");
    });
}

#[test]
fn gravity_is_inverse_dynamics_at_rest() {
    for_each_motion(|tree, q, qd, _| {
        let zeros = vec![0.0; qd.len()];
        let (mut gravity, mut at_rest) = (zeros.clone(), zeros.clone());
        tree.gravity(q, &mut gravity).unwrap();
        tree.inverse_dynamics(q, &zeros, &zeros, &mut at_rest).unwrap();
        assert!(difference(&gravity, &at_rest) <= 0.0);
        tree.under_gravity(Vec3::ZERO).gravity(q, &mut gravity).unwrap();
        assert!(largest(&gravity) <= 0.0);
    });
}

/// Returns a ball and a hinge: nq is 5, nv is 4.
fn leg() -> Tree<2> {
    let inertia = Inertia::of_box(1.0, Vec3::Y * -0.1, Vec3::new(0.05, 0.2, 0.05));
    let hip = Body::spherical(None, Vec3::ZERO, inertia);
    let knee = Body::revolute(None, Vec3::X, Vec3::Y * -0.2, inertia);
    Tree::serial_chain(&[hip, knee]).unwrap()
}

const Q: [f32; 5] = [0.0, 0.0, 0.0, 1.0, 0.5];

#[test]
fn slices_of_wrong_lengths_are_refused_by_name() {
    let (tree, mut out) = (leg(), [7.0; 16]);
    let count = |name, expected, found| Err(CoordinatesError::Count { name, expected, found });
    let four = [0.0; 4];
    let (short, long) = (&four[..3], [0.0; 5]);
    assert_eq!(tree.inverse_dynamics(&four, &four, &four, &mut out[..4]), count("q", 5, 4));
    assert_eq!(tree.inverse_dynamics(&Q, short, &four, &mut out[..4]), count("qd", 4, 3));
    assert_eq!(tree.inverse_dynamics(&Q, &four, &long, &mut out[..4]), count("qdd", 4, 5));
    assert_eq!(tree.inverse_dynamics(&Q, &four, &four, &mut out[..3]), count("tau", 4, 3));
    assert_eq!(tree.forward_dynamics(&Q, &four, short, &mut out[..4]), count("tau", 4, 3));
    assert_eq!(tree.forward_dynamics(&Q, &four, &four, &mut out[..5]), count("qdd", 4, 5));
    assert_eq!(tree.gravity(&four, &mut out[..4]), count("q", 5, 4));
    assert_eq!(tree.gravity(&Q, &mut out[..5]), count("tau", 4, 5));
    assert_eq!(tree.mass_matrix(&four, &mut out), count("q", 5, 4));
    assert_eq!(tree.mass_matrix(&Q, &mut out[..15]), count("matrix", 16, 15));
    assert!(difference(&out, &[7.0; 16]) <= 0.0);
}

#[test]
fn numbers_that_cannot_be_are_refused_by_name() {
    let (tree, mut out) = (leg(), [7.0; 4]);
    let four = [0.0; 4];
    for value in [f32::NAN, f32::INFINITY, -2e6] {
        let bad = [0.0, 0.0, 0.0, value];
        let refused = [
            tree.inverse_dynamics(&Q, &bad, &four, &mut out),
            tree.inverse_dynamics(&Q, &four, &bad, &mut out),
            tree.forward_dynamics(&Q, &four, &bad, &mut out),
            tree.gravity(&[0.0, 0.0, 0.0, 1.0, value], &mut out),
        ];
        for refused in refused {
            assert!(matches!(refused, Err(CoordinatesError::Number { joint: 1, .. })));
        }
    }
    let refused = tree.gravity(&[0.0, 0.0, 0.0, 2.0, 0.0], &mut out);
    assert_eq!(refused, Err(CoordinatesError::NotUnit { joint: 0, index: 0, squared: 4.0 }));
    assert!(difference(&out, &[7.0; 4]) <= 0.0);
}
