//! Valid random rigs, with numbers as people write them.

use crate::description::{
    Address, Base, Body, BodyShape, Description, Drive, DriveKind, FaceShape, InertiaMatrix, Joint,
    JointType, LinkedLimit, Mount, Servo, ServoModel, SignalLoss, SourcedValue, Supply,
};

/// A generator of random numbers from a seed (`SplitMix64`).
pub(super) struct Random(pub(super) u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        usize::try_from(self.next() % count as u64).unwrap()
    }

    fn one_of<T: Clone>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())].clone()
    }

    fn perhaps<T>(&mut self, make: impl FnOnce(&mut Self) -> T) -> Option<T> {
        (self.below(2) == 0).then(|| make(self))
    }

    /// Returns a number from 0.001 to 1000 with three to six digits.
    fn positive(&mut self) -> f64 {
        let scale = self.one_of(&[1e3, 1e4, 1e6]);
        (self.below(999_001) + 1000) as f64 / scale
    }

    fn number(&mut self) -> f64 {
        self.positive() * self.one_of(&[1.0, -1.0])
    }

    /// Returns an angle from -400 to 400 deg, in rad.
    fn angle(&mut self) -> f64 {
        ((self.below(800_000) as f64 - 400_000.0) / 1e3).to_radians()
    }

    fn numbers<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.number())
    }

    fn axis(&mut self) -> [f64; 3] {
        self.one_of(&[[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.6, 0.0, 0.8], [0.48, -0.64, 0.6]])
    }

    fn rotation(&mut self) -> [f64; 4] {
        self.one_of(&[[0.0, 0.0, 0.0, 1.0], [0.5, 0.5, -0.5, 0.5], [0.6, 0.0, 0.0, -0.8]])
    }

    /// Returns a range, and a value in it.
    fn range(&mut self, value: fn(&mut Self) -> f64) -> ([f64; 2], f64) {
        let mut three = [value(self), value(self), value(self)];
        three.sort_by(f64::total_cmp);
        ([three[0], three[2]], three[1])
    }

    /// Returns a name that is difficult to quote.
    fn name(&mut self, kind: &str, index: usize) -> String {
        let odd = self.one_of(&["", " ", "\"", "'", "\\", "\n", "é", "#", "\u{7f}", "'''\"\"\""]);
        format!("{kind}{odd}{index}")
    }
}

/// Creates a rig of up to ten bodies with every kind of part.
pub(super) fn rig(seed: u64) -> Description {
    let r = &mut Random(seed);
    let count = 1 + r.below(10);
    let bodies: Vec<Body> = (0..count).map(|index| body(r, index)).collect();
    let joints: Vec<Joint> = (1..count)
        .map(|child| {
            let parent = r.below(child);
            joint(r, child, &bodies[parent].name, &bodies[child].name)
        })
        .collect();
    let limits = limits(r, &joints);
    let (drives, servos) = drives(r, &joints);
    let models = r.below(3);
    let face_shapes = (0..r.below(3)).map(|index| face_shape(r, index, &joints)).collect();
    Description {
        name: r.name("rig", 0),
        mount: Mount {
            base: r.one_of(&[Base::Fixed, Base::Driven]),
            position_m: r.perhaps(Random::numbers).unwrap_or_default(),
            rotation_xyzw: r.rotation(),
        },
        supply: r.perhaps(|r| Supply { voltage_v: r.positive(), current_a: r.positive() }),
        bodies,
        joints,
        limits,
        drives,
        servos,
        servo_models: (0..models).map(|index| model(r, index)).collect(),
        face_shapes,
    }
}

/// Returns a shape in which some of the joints are at an end of their range.
fn face_shape(r: &mut Random, index: usize, joints: &[Joint]) -> FaceShape {
    let position = |joint: &Joint, end: usize| match joint.kind {
        JointType::Revolute => {
            Some(joint.range_rad.first().map_or(30_f64.to_radians(), |range| range[end]))
        }
        JointType::Prismatic => {
            // The file has mm: their text decides the last bit.
            let mm = format!("{:.9e}", 1000.0 * joint.range_m.map_or(0.02, |range| range[end]));
            Some(mm.parse::<f64>().unwrap() / 1000.0)
        }
        _ => None,
    };
    let mut pose = Vec::new();
    for joint in joints {
        let end = r.below(4);
        pose.extend(
            Some(end)
                .filter(|end| *end < 2)
                .and_then(|end| Some((joint.name.clone(), position(joint, end)?))),
        );
    }
    FaceShape { name: r.name("shape", index), pose }
}

fn body(r: &mut Random, index: usize) -> Body {
    let mut body = Body { name: r.name("body", index), ..Body::default() };
    if r.below(4) > 0 {
        body.mass_kg = r.positive();
        body.center_of_mass_m = r.numbers();
        match r.below(3) {
            0 => body.box_m = Some([r.positive(), r.positive(), r.positive()]),
            1 => {
                let scale = r.one_of(&[1.0, 1e-3, 1e-7]);
                let [xx, yy, zz] = [1.0, 1.1, 1.2].map(|moment| moment * scale);
                let [xy, xz, yz] = [0.0, 0.01, -0.02]
                    .map(|product| if r.below(2) == 0 { 0.0 } else { product * scale });
                // The number is converted to text and back, because a product of two decimals may differ in the
                // last bit.
                let read = |x: f64| format!("{x:.6e}").parse::<f64>().unwrap();
                body.inertia_kg_m2 = Some(InertiaMatrix {
                    xx: read(xx),
                    xy: read(xy),
                    xz: read(xz),
                    yy: read(yy),
                    yz: read(yz),
                    zz: read(zz),
                });
            }
            _ => {}
        }
    }
    body.shapes = (0..r.below(3)).map(|_| shape(r)).collect();
    body
}

fn shape(r: &mut Random) -> BodyShape {
    let (radius_m, length_m) = (r.positive(), r.positive());
    let shape = match r.below(4) {
        0 => BodyShape::cuboid([radius_m, length_m, r.positive()]),
        1 => BodyShape::sphere(radius_m),
        2 => BodyShape::cylinder(radius_m, length_m),
        _ => BodyShape::capsule(radius_m, length_m),
    };
    let color_rgb = r.perhaps(|_| [1.0, 0.5, 0.0]);
    BodyShape { color_rgb, ..shape.at(r.numbers(), r.rotation()) }
}

fn joint(r: &mut Random, index: usize, parent: &str, child: &str) -> Joint {
    let mut joint = Joint {
        name: r.name("joint", index),
        kind: r.one_of(&[
            JointType::Fixed,
            JointType::Revolute,
            JointType::Revolute,
            JointType::Prismatic,
            JointType::Prismatic,
            JointType::Universal,
            JointType::Spherical,
            JointType::Free,
        ]),
        parent: parent.to_owned(),
        child: child.to_owned(),
        position_m: r.numbers(),
        rotation_xyzw: r.rotation(),
        ..Joint::default()
    };
    match joint.kind {
        JointType::Fixed | JointType::Free => return joint,
        JointType::Revolute => {
            joint.axis = Some(r.axis());
            if let Some((range, home)) = r.perhaps(|r| r.range(Random::angle)) {
                joint.range_rad = vec![range];
                joint.home_rad = r.perhaps(|_| home);
            }
        }
        JointType::Prismatic => {
            joint.axis = Some(r.axis());
            if let Some((range, home)) = r.perhaps(|r| r.range(Random::number)) {
                joint.range_m = Some(range);
                joint.home_m = r.perhaps(|_| home);
            }
        }
        JointType::Universal => {
            joint.axis = Some([0.6, 0.0, 0.8]);
            joint.second_axis = Some([0.0, -1.0, 0.0]);
            joint.range_rad = r
                .perhaps(|r| vec![r.range(Random::angle).0, r.range(Random::angle).0])
                .unwrap_or_default();
        }
        JointType::Spherical => {
            joint.range_rad = r.perhaps(|_| vec![[0.0, 35.5_f64.to_radians()]]).unwrap_or_default();
        }
    }
    let limits = [r.perhaps(Random::positive), r.perhaps(Random::positive)];
    if joint.kind == JointType::Prismatic {
        [joint.speed_m_s, joint.acceleration_m_s2] = limits;
    } else {
        [joint.speed_rad_s, joint.acceleration_rad_s2] = limits.map(|x| x.map(f64::to_radians));
    }
    joint.effort = r.perhaps(Random::positive);
    joint.rotor_inertia = r.perhaps(Random::positive);
    joint.friction = r.perhaps(Random::positive).unwrap_or_default();
    joint.damping = r.perhaps(Random::positive).unwrap_or_default();
    joint
}

fn limits(r: &mut Random, joints: &[Joint]) -> Vec<LinkedLimit> {
    let mut limits = Vec::new();
    for kind in [JointType::Revolute, JointType::Prismatic] {
        let alike: Vec<_> = joints.iter().filter(|joint| joint.kind == kind).collect();
        for pair in alike.windows(2) {
            let mut limit = LinkedLimit {
                joint: pair[0].name.clone(),
                other: pair[1].name.clone(),
                factor: r.one_of(&[1.0, -0.5, 2.0]),
                other_factor: r.one_of(&[1.0, -1.0, 0.25]),
                ..LinkedLimit::default()
            };
            // The range contains every possible home pose of the two joints: 400 deg or 1000 m, with factors of up
            // to 2 and 1.
            let (least, most) = (-3000.0, r.perhaps(|_| 3000.5));
            if kind == JointType::Revolute {
                limit.least_rad = Some(f64::to_radians(least));
                limit.most_rad = most.map(f64::to_radians);
            } else {
                (limit.least_m, limit.most_m) = (Some(least), most);
            }
            limits.push(limit);
        }
    }
    limits
}

fn drives(r: &mut Random, joints: &[Joint]) -> (Vec<Drive>, Vec<Servo>) {
    let (mut drives, mut servos) = (Vec::new(), Vec::new());
    for joint in joints {
        let dofs = joint.kind.dof_count();
        if matches!(joint.kind, JointType::Fixed | JointType::Free) || r.below(4) == 0 {
            continue;
        }
        let slides = joint.kind == JointType::Prismatic;
        let of_joint = |r: &mut Random| if slides { r.number() } else { r.angle() };
        let mut columns = dofs;
        let kind = match r.below(5) {
            0 => DriveKind::one_to_one(dofs),
            1 if dofs == 1 => DriveKind::Curve { points: curve(r, slides) },
            2 if joint.kind == JointType::Revolute => four_bar(r),
            _ => {
                columns += r.below(2);
                let offset = r.perhaps(|r| (0..dofs).map(|_| of_joint(r)).collect());
                let rows = rows(r, dofs, columns);
                DriveKind::Matrix { rows, offset: offset.unwrap_or_default() }
            }
        };
        let first = servos.len();
        servos.extend((first..first + columns).map(|index| servo(r, index)));
        if matches!(kind, DriveKind::FourBar { .. }) {
            // The servo's range is within the valid range of the linkage.
            let shaft = &mut servos[first];
            (shaft.gear, shaft.offset_rad, shaft.range_rad) =
                (1.0, None, vec![[-57_f64, 57.0].map(f64::to_radians)]);
        }
        let names = servos[first..].iter().map(|servo: &Servo| servo.name.clone()).collect();
        drives.push(Drive { joints: vec![joint.name.clone()], servos: names, kind });
    }
    (drives, servos)
}

/// Returns a matrix that is far from singular: each dof has a servo of its own, and the others contribute little.
fn rows(r: &mut Random, dofs: usize, servos: usize) -> Vec<Vec<f64>> {
    let entry = |r: &mut Random, own: bool| {
        if own { (500 + r.below(1001)) as f64 / 1000.0 } else { (1 + r.below(100)) as f64 / 1000.0 }
    };
    (0..dofs).map(|row| (0..servos).map(|column| entry(r, row == column)).collect()).collect()
}

/// Returns a monotone curve whose slopes differ less than the limit, in degrees, or in degrees and metres.
fn curve(r: &mut Random, slides: bool) -> Vec<[f64; 2]> {
    let down = if r.below(2) == 0 { 1.0 } else { -1.0 };
    let mut at = [-60.0, 12.0 * down];
    (0..2 + r.below(3))
        .map(|_| {
            let [s, q] = at;
            let step = (20 + r.below(20)) as f64;
            at = [s + step, q + down * (10 + r.below(20)) as f64];
            [s.to_radians(), if slides { q / 1000.0 } else { q.to_radians() }]
        })
        .collect()
}

/// Returns a parallelogram of any size, with a right angle when the servo is at zero.
fn four_bar(r: &mut Random) -> DriveKind {
    let size_m = 0.01 * (1.0 + r.below(10) as f64);
    DriveKind::FourBar {
        ground_m: 2.0 * size_m,
        crank_m: size_m,
        coupler_m: 2.0 * size_m,
        rocker_m: size_m,
        crank_zero_rad: std::f64::consts::FRAC_PI_2,
        rocker_zero_rad: ((45 + r.below(90)) as f64).to_radians(),
        crossed: false,
    }
}

fn servo(r: &mut Random, index: usize) -> Servo {
    let address = match u8::try_from(index) {
        Ok(channel @ 0..16) if r.below(2) == 0 => Address::Channel(channel),
        other => Address::Id(other.unwrap()),
    };
    let is_hobby = matches!(address, Address::Channel(_));
    Servo {
        name: r.name("servo", index),
        model: r.one_of(&["XL330-M288-T".to_owned(), "MX-64".to_owned(), "MG90S".to_owned()]),
        bus: r.one_of(&["main".to_owned(), "second".to_owned()]),
        address,
        direction: r.one_of(&[1, -1]),
        offset_rad: r.perhaps(Random::angle),
        homing_offset_rad: r.perhaps(Random::angle),
        gear: r.perhaps(Random::positive).unwrap_or(1.0),
        pulse_us: r.perhaps(|_| [600.0, 1450.0, 2350.5]).filter(|_| is_hobby),
        travel_rad: r.perhaps(Random::positive).filter(|_| is_hobby).map(f64::to_radians),
        range_rad: r.perhaps(|r| vec![r.range(Random::angle).0]).unwrap_or_default(),
        torque_nm: r.perhaps(Random::positive),
        speed_rad_s: r.perhaps(|r| r.positive().to_radians()),
        acceleration_rad_s2: r.perhaps(|r| r.positive().to_radians()),
        p_gain: r.perhaps(|r| r.one_of(&[1, 640, 16_383])),
        on_signal_loss: r.one_of(&[SignalLoss::Limp, SignalLoss::Hold, SignalLoss::Home]),
    }
}

fn model(r: &mut Random, index: usize) -> ServoModel {
    let mut model = ServoModel { name: r.name("model", index), ..ServoModel::default() };
    for (_, value) in model.values_mut() {
        *value = SourcedValue { value: r.positive(), source: r.name("guess: ", index) };
    }
    // Values that no servo has would be refused.
    model.friction_nm.value = 0.5 * model.stall_torque_nm.value;
    for fine in [&mut model.resolution_rad, &mut model.backlash_rad] {
        fine.value = fine.value.min(0.1);
    }
    // The rotor must be heavy enough for the gear's stiffness, which is given or follows from a rule.
    let rotor = &mut model.rotor_inertia_kg_m2.value;
    *rotor = rotor.max((model.stall_torque_nm.value / 0.0175 / 1e3).ceil() / 1e3);
    let stiffest = (1e6 * *rotor).round();
    for (key, value) in model.optional_values_mut() {
        *value = r.perhaps(|r| {
            let [least, most] = match key {
                "pulse_least_us" => [300.0, 900.0],
                "pulse_middle_us" => [1400.0, 1600.0],
                "pulse_most_us" => [2000.0, 2500.0],
                "output_friction_share" => [0.0, 1.0],
                "gear_stiffness_nm_rad" => [0.0, stiffest],
                _ => [0.0, f64::INFINITY],
            };
            SourcedValue {
                value: r.positive().clamp(least, most),
                source: r.name("guess: ", index),
            }
        });
    }
    model
}
