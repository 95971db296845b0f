use glam::{DMat3, DQuat, DVec3, Vec3Swizzles as _};

use super::*;
use crate::mechanism::{JointModel, Link};

/// A generator of numbers from -1 to 1, equal in every run.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0 >> 8) / f64::from(1_u32 << 23) - 1.0
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }

    fn rotation(&mut self) -> DQuat {
        DQuat::from_scaled_axis(3.0 * self.vector())
    }
}

/// Creates a tree with joints of every kind at random places, some with rotors.
fn rig(random: &mut Random, base: JointModel) -> Mechanism {
    let (x, z) = (DVec3::X, DVec3::Z);
    let kinds = [
        base,
        JointModel::Revolute(DVec3::new(0.48, -0.64, 0.6)),
        JointModel::Universal([x, z]),
        JointModel::Fixed,
        JointModel::Revolute(z),
        JointModel::Spherical,
        JointModel::Prismatic(x),
        JointModel::Revolute(x),
    ];
    let body = |(index, joint): (usize, JointModel)| {
        let parent = (index > 0).then(|| index - 1 - (index * 7) % index.min(3));
        let lengths = random.vector().abs() + 0.1;
        Link {
            rotation: random.rotation(),
            mass_kg: 1.0 + random.next(),
            center_of_mass_m: 0.2 * random.vector(),
            inertia_kg_m2: DMat3::from_diagonal(lengths.yzx() + lengths.zxy()),
            rotor_inertia: if index % 3 == 1 { 0.02 } else { 0.0 },
            ..Link::on(parent, joint, random.vector())
        }
    };
    Mechanism { bodies: kinds.into_iter().enumerate().map(body).collect(), linked: vec![] }
}

/// Creates valid random positions (those of single-axis joints up to `most`), speeds and accelerations.
fn motion(random: &mut Random, mechanism: &Mechanism, most: f64) -> [Vec<f64>; 3] {
    let mut of_all = [vec![], vec![], vec![]];
    for link in &mechanism.bodies {
        let kind = link.joint.kind();
        let count = kind.coordinate_count();
        if count >= 4 {
            of_all[0].extend(random.rotation().to_array());
            of_all[0].extend((4..count).map(|_| random.next()));
        } else {
            of_all[0].extend((0..count).map(|_| most * random.next()));
        }
        for (of_all, most) in of_all[1..].iter_mut().zip([10.0, 300.0]) {
            of_all.extend((0..kind.dof_count()).map(|_| most * random.next()));
        }
    }
    // Zeros of both signs are included.
    for zero in [0.0, -0.0] {
        for of_all in &mut of_all[1..] {
            let place = ((0.5 + 0.5 * random.next()) * (of_all.len() - 1) as f64).round();
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place")]
            let place = place as usize;
            of_all[place] = zero;
        }
    }
    of_all
}

#[test]
#[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
fn side_by_side_has_the_bits_of_one_after_the_other() {
    let mut random = Random(1);
    for round in 0..200 {
        let base = if round % 2 == 0 { JointModel::Fixed } else { JointModel::Free };
        let mechanism = rig(&mut random, base);
        let mut dynamics = InverseDynamics::of(&mechanism).unwrap();
        // First within the range in which the core uses a polynomial, then beyond it and beyond a whole turn.
        let most = if round % 4 < 2 { 1.57 } else { 9.0 };
        let motions: [[Vec<f32>; 3]; LANES] = std::array::from_fn(|_| {
            motion(&mut random, &mechanism, most)
                .map(|wide| wide.iter().map(|x| *x as f32).collect())
        });
        let [q, qd, qdd] = [0, 1, 2].map(|kind| -> Vec<[f32; LANES]> {
            let places = 0..motions[0][kind].len();
            places.map(|k| motions.each_ref().map(|motion| motion[kind][k])).collect()
        });
        let all = dynamics.efforts_side_by_side(&q, &qd, &qdd).unwrap().to_vec();
        for (lane, [q, qd, qdd]) in motions.iter().enumerate() {
            let alone = dynamics.efforts(q, qd, qdd).unwrap();
            let bits = |efforts: &[f32]| efforts.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            let side_by_side: Vec<f32> = all.iter().map(|of_lanes| of_lanes[lane]).collect();
            assert_eq!(bits(&side_by_side), bits(alone), "round {round}, lane {lane}");
        }
    }
}

#[test]
fn what_the_core_refuses_is_refused_side_by_side() {
    let hinge = Link::on(Some(0), JointModel::Revolute(DVec3::X), DVec3::ZERO);
    let ball = Link::on(Some(1), JointModel::Spherical, DVec3::ZERO);
    let base = Link::on(None, JointModel::Fixed, DVec3::ZERO);
    let mechanism = Mechanism { bodies: vec![base, hinge, ball], linked: vec![] };
    let mut dynamics = InverseDynamics::of(&mechanism).unwrap();
    let mut q = [[0.0; LANES]; 5];
    q[4] = [1.0; LANES];
    let still = [[0.0; LANES]; 4];
    assert_eq!(dynamics.efforts_side_by_side(&q, &still, &still), Ok(&still[..]));
    for (place, lane, wrong) in [(0, 1, f32::NAN), (0, 3, 2e6), (4, 2, 0.9)] {
        let mut q = q;
        q[place][lane] = wrong;
        let alone = q.map(|of_lanes| of_lanes[lane]);
        let expected = dynamics.efforts(&alone, &[0.0; 4], &[0.0; 4]).unwrap_err().to_string();
        let told = dynamics.efforts_side_by_side(&q, &still, &still).unwrap_err().to_string();
        assert_eq!(told, expected);
    }
    assert!(dynamics.efforts_side_by_side(&q[1..], &still, &still).is_err());
}
