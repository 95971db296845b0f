//! The rigs of the tests: arms, in which each joint has one servo.

use std::ops::Range;

use sinew_rig::Description;
use sinew_rig::board::BoardRig;
use sinew_rig::description::{Drive, DriveKind, Servo};
use sinew_rig::import::{Options, urdf};
use sinew_rig::mechanism::{InverseDynamics, Mechanism};
use sinew_rig::servo::Address;
use sinew_rig::toml_file;

/// A rig type with room for Poppy Humanoid.
pub(crate) type Board = BoardRig<40, 40, 8>;

/// A rig, with the indices in `q` of its servos' joints.
pub(crate) struct Figure {
    pub(crate) name: &'static str,
    pub(crate) mechanism: Mechanism,
    pub(crate) board: Board,
    pub(crate) model: String,
    pub(crate) home: Vec<f32>,
    /// Index in `q` of each servo's joint.
    pub(crate) places: Vec<usize>,
    pub(crate) ranges_rad: Vec<[f64; 2]>,
}

impl Figure {
    /// Returns the arm of six servos that `sinew rig new` wrote before its links became shorter: its servos sag more.
    pub(crate) fn desk_arm(model: &str) -> Self {
        let text = include_str!("../../../../tests/support/rigs/arm_62ff7e0.toml");
        let mut rig = toml_file::read(text).unwrap();
        for (servo, body) in rig.servos.iter_mut().zip(&mut rig.bodies[1..]) {
            model.clone_into(&mut servo.model);
            // The arm is designed for XL330 of 18 g; an STS3215 weighs 55 g, an MX-28 77 g.
            body.mass_kg += match model {
                "XL330-M288-T" => 0.0,
                "MX-28" => 0.059,
                _ => 0.037,
            };
        }
        Self::of("arm of six", &rig, model)
    }

    /// Returns both arms of Poppy Humanoid; its other joints are held at home. Needs `SINEW_DATA`.
    pub(crate) fn poppy(model: &str) -> Self {
        let data = std::env::var("SINEW_DATA").expect("SINEW_DATA names the folder of the data");
        let path = format!("{data}/urdf/poppy-humanoid/Poppy_Humanoid.urdf");
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
        let options = Options { repair_inertia: true, ..Options::default() };
        let mut rig = urdf(&text, &options).unwrap().description;
        let joints = ["shoulder_y", "shoulder_x", "arm_z", "elbow_y"];
        let names =
            ["l", "r"].iter().flat_map(|side| joints.map(|joint| format!("{side}_{joint}")));
        for (id, name) in (1..).zip(names) {
            rig.drives.push(Drive {
                joints: vec![name.clone()],
                servos: vec![name.clone()],
                kind: DriveKind::one_to_one(1),
            });
            rig.servos.push(Servo {
                name,
                model: model.to_owned(),
                address: Address::Id(id),
                ..Servo::default()
            });
        }
        Self::of("Poppy's arms", &rig, model)
    }

    fn of(name: &'static str, rig: &Description, model: &str) -> Self {
        let mechanism = rig.mechanism().unwrap();
        let board = Board::bake(rig, &mechanism).unwrap();
        let starts: Vec<Range<usize>> = mechanism.coordinate_ranges();
        let link = |servo: &Servo| {
            mechanism.bodies.iter().position(|link| link.joint_name == servo.name).unwrap()
        };
        let links: Vec<usize> = rig.servos.iter().map(link).collect();
        let home = mechanism.home().iter().map(|home| *home as f32).collect();
        Self {
            name,
            board,
            model: model.to_owned(),
            home,
            places: links.iter().map(|link| starts[*link].start).collect(),
            ranges_rad: links.iter().map(|link| mechanism.bodies[*link].ranges[0]).collect(),
            mechanism,
        }
    }

    /// Returns the servos' torques that hold a pose, with masses multiplied by `masses`, N m.
    pub(crate) fn weights(&self, masses: f64) -> Weights {
        let mut mechanism = self.mechanism.clone();
        for link in &mut mechanism.bodies {
            link.mass_kg *= masses;
            link.inertia_kg_m2 *= masses;
        }
        Weights {
            dynamics: InverseDynamics::of(&mechanism).unwrap(),
            places: self.places.clone(),
            zeros: vec![0.0; self.home.len()],
        }
    }
}

/// Calculator of the torques that gravity exerts on a rig's joints.
pub(crate) struct Weights {
    dynamics: InverseDynamics,
    places: Vec<usize>,
    zeros: Vec<f32>,
}

impl Weights {
    /// Returns the torque with which each servo holds a pose, N m. All joints have one axis, so indices in `q` and of
    /// dofs are equal.
    pub(crate) fn at(&mut self, q: &[f32]) -> Vec<f32> {
        let efforts = self.dynamics.efforts(q, &self.zeros, &self.zeros).unwrap();
        self.places.iter().map(|place| efforts[*place]).collect()
    }

    /// Returns the inertia at each servo while all others are held, kg m².
    pub(crate) fn inertias(&mut self, q: &[f32]) -> Vec<f64> {
        let weights = self.at(q);
        let mut inertias = Vec::new();
        for (servo, place) in self.places.clone().into_iter().enumerate() {
            let mut unit = self.zeros.clone();
            unit[place] = 1.0;
            let efforts = self.dynamics.efforts(q, &self.zeros, &unit).unwrap();
            inertias.push(f64::from(efforts[place] - weights[servo]).max(1e-4));
        }
        inertias
    }
}
