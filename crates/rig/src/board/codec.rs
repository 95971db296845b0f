//! Encodes a rig to bytes and decodes it; [`super`] describes the format.

use core::mem::MaybeUninit;

use heapless::Vec;
use sinew_core::glam::Vec3;
use sinew_core::{Body, Inertia, JointKind, RotationalInertia, Transform, Tree};

use super::bytes::{Reader, Writer};
use super::{Address, BoardDof, BoardDrive, BoardRig, BoardRigError, BoardServo, LinkedLimit};
use crate::drive::{
    CURVE_CAPACITY, Curve, DRIVE_CAPACITY, Drive, DriveError, FourBar, Links, MATRIX_CAPACITY,
    Matrix,
};
use crate::servo::{Servo, ServoSettings, SignalLoss};

const MAGIC: [u8; 4] = *b"SNWR";
const VERSION: u16 = 1;

/// First number that encodes a channel; smaller numbers are bus ids.
const CHANNELS: u16 = 256;

impl<const BODIES: usize, const DOFS: usize, const SERVOS: usize> BoardRig<BODIES, DOFS, SERVOS> {
    /// Writes the rig, and returns the number of bytes. [`Self::decode`] reads these bytes on any board whose
    /// capacity is large enough.
    ///
    /// # Errors
    /// [`BoardRigError::Length`] if `out` is too short; its content is then useless.
    pub fn encode(&self, out: &mut [u8]) -> Result<usize, BoardRigError> {
        let mut to = Writer::new(out);
        to.put(&MAGIC);
        to.u16(VERSION);
        let counts = [
            self.tree.len(),
            self.dofs.len(),
            self.limits.len(),
            self.drives.len(),
            self.servos.len(),
        ];
        for count in counts {
            to.count(count);
        }
        for body in self.tree.bodies() {
            write_body(&mut to, body);
        }
        for dof in &self.dofs {
            let BoardDof { range: [least, most], home, speed, acceleration, effort } = *dof;
            to.numbers([least, most, home, speed, acceleration, effort]);
        }
        for limit in &self.limits {
            to.u16(limit.dof);
            to.u16(limit.other);
            to.numbers([limit.factor, limit.other_factor]);
            to.numbers(limit.range);
        }
        for drive in &self.drives {
            write_drive(&mut to, drive);
        }
        for servo in &self.servos {
            write_servo(&mut to, servo);
        }
        to.finish()
    }

    /// Reads a rig, and checks every number once. O(size).
    ///
    /// # Errors
    /// [`BoardRigError`] names the value that is wrong, or the part that exceeds this capacity.
    pub fn decode(bytes: &[u8]) -> Result<Self, BoardRigError> {
        let mut rig = Self::empty();
        rig.fill(bytes)?;
        Ok(rig)
    }

    /// Reads a rig in place. The value is large, and each move would cost its size in stack.
    ///
    /// # Errors
    /// Returns the errors of [`Self::decode`].
    // Never inlined: the compiler then knows that nothing else uses the slot, and builds the rig there.
    #[inline(never)]
    pub fn decode_in<'s>(
        slot: &'s mut MaybeUninit<Self>,
        bytes: &[u8],
    ) -> Result<&'s mut Self, BoardRigError> {
        let rig = slot.write(Self::empty());
        rig.fill(bytes)?;
        Ok(rig)
    }

    // Never inlined: the value is then built in its final place.
    #[inline(never)]
    fn empty() -> Self {
        Self {
            tree: Tree::new(),
            dofs: Vec::new(),
            limits: Vec::new(),
            drives: Vec::new(),
            servos: Vec::new(),
        }
    }

    /// Reads the bytes into an empty rig, and checks it.
    #[inline(never)]
    fn fill(&mut self, bytes: &[u8]) -> Result<(), BoardRigError> {
        let mut from = Reader::new(bytes);
        let parts = self.read(&mut from);
        // A rig that is too short reports its length, not an error in the zeros that were read after its end.
        from.check_length()?;
        parts?;
        from.check_end()?;
        self.check()
    }

    /// Reads the parts, and checks each of them alone.
    fn read(&mut self, from: &mut Reader<'_>) -> Result<(), BoardRigError> {
        let magic = from.magic();
        if magic != MAGIC {
            return Err(BoardRigError::Magic { found: magic });
        }
        let version = from.u16();
        if version != VERSION {
            return Err(BoardRigError::Version { found: version });
        }
        from.check_crc()?;
        let mut count = |what, holds| -> Result<usize, BoardRigError> {
            let found = usize::from(from.u16());
            if found > holds {
                Err(BoardRigError::Capacity { what, found, holds })
            } else {
                Ok(found)
            }
        };
        let bodies = count("bodies", BODIES)?;
        let dofs = count("degrees of freedom", DOFS)?;
        let limits = count("linked limits", DOFS)?;
        let drives = count("drives", SERVOS)?;
        let servos = count("servos", SERVOS)?;
        for index in 0..bodies {
            self.tree.push(read_body(from, index)?).map_err(BoardRigError::Tree)?;
        }
        items_in(&mut self.dofs, dofs, |_| {
            let [least, most, home, speed, acceleration, effort] = from.numbers();
            Ok(BoardDof { range: [least, most], home, speed, acceleration, effort })
        })?;
        items_in(&mut self.limits, limits, |_| {
            let (dof, other) = (from.u16(), from.u16());
            let [factor, other_factor, least, most] = from.numbers();
            Ok(LinkedLimit { dof, other, factor, other_factor, range: [least, most] })
        })?;
        items_in(&mut self.drives, drives, |index| read_drive(from, index))?;
        items_in(&mut self.servos, servos, |index| read_servo(from, index))?;
        Ok(())
    }
}

/// Reads `count` items into an empty list; fails if there is no room for all.
fn items_in<T, const N: usize>(
    all: &mut Vec<T, N>,
    count: usize,
    mut read: impl FnMut(usize) -> Result<T, BoardRigError>,
) -> Result<(), BoardRigError> {
    for index in 0..count {
        let full = BoardRigError::Capacity { what: "items", found: count, holds: N };
        all.push(read(index)?).map_err(|_| full)?;
    }
    Ok(())
}

fn items<T, const N: usize>(
    count: usize,
    read: impl FnMut(usize) -> Result<T, BoardRigError>,
) -> Result<Vec<T, N>, BoardRigError> {
    let mut all = Vec::new();
    items_in(&mut all, count, read)?;
    Ok(all)
}

fn write_body(to: &mut Writer<'_>, body: &Body) {
    let parent = body.parent.and_then(|parent| i16::try_from(parent).ok()).unwrap_or(-1);
    let (kind, first, second) = match body.joint {
        JointKind::Fixed => (0, Vec3::ZERO, Vec3::ZERO),
        JointKind::Revolute { axis } => (1, axis, Vec3::ZERO),
        JointKind::Prismatic { axis } => (2, axis, Vec3::ZERO),
        JointKind::Universal { first, second } => (3, first, second),
        JointKind::Spherical => (4, Vec3::ZERO, Vec3::ZERO),
        JointKind::Free => (5, Vec3::ZERO, Vec3::ZERO),
    };
    to.u16(parent.cast_unsigned());
    to.u16(kind);
    to.numbers(first.to_array());
    to.numbers(second.to_array());
    to.numbers(body.placement.rotation.to_array());
    to.numbers(body.placement.translation_m.to_array());
    to.f32(body.inertia.mass_kg);
    to.numbers(body.inertia.center_of_mass_m.to_array());
    let i = &body.inertia.rotational_kg_m2;
    to.numbers([i.xx, i.xy, i.xz, i.yy, i.yz, i.zz]);
    to.f32(body.rotor_inertia);
}

fn read_body(from: &mut Reader<'_>, index: usize) -> Result<Body, BoardRigError> {
    let parent = match from.u16().cast_signed() {
        -1 => None,
        found => Some(usize::try_from(found).map_err(|_| BoardRigError::Index {
            what: "body",
            index,
            part: "body",
            found: usize::from(found.cast_unsigned()),
        })?),
    };
    let kind = from.u16();
    let (first, second) = (from.vec3(), from.vec3());
    let joint = match kind {
        0 => JointKind::Fixed,
        1 => JointKind::Revolute { axis: first },
        2 => JointKind::Prismatic { axis: first },
        3 => JointKind::Universal { first, second },
        4 => JointKind::Spherical,
        5 => JointKind::Free,
        found => return Err(BoardRigError::Kind { what: "joint of body", index, found, most: 5 }),
    };
    let placement = Transform::new(from.quat(), from.vec3());
    let mass_kg = from.f32();
    let center_of_mass_m = from.vec3();
    let [xx, xy, xz, yy, yz, zz] = from.numbers();
    let rotational_kg_m2 = RotationalInertia { xx, xy, xz, yy, yz, zz };
    let inertia = Inertia { mass_kg, center_of_mass_m, rotational_kg_m2 };
    Ok(Body { parent, joint, placement, inertia, rotor_inertia: from.f32() })
}

fn write_drive(to: &mut Writer<'_>, drive: &BoardDrive) {
    for indices in [&drive.dofs, &drive.servos] {
        to.count(indices.len());
        for index in indices {
            to.u16(*index);
        }
    }
    match &drive.drive {
        Drive::Matrix(matrix) => {
            to.u16(u16::from(matrix.is_ball()));
            to.numbers(matrix.rows().flatten().copied());
            to.numbers(matrix.offset().iter().copied());
        }
        Drive::Curve(curve) => {
            to.u16(2);
            to.count(curve.points().len());
            to.numbers(curve.points().flatten());
        }
        Drive::FourBar(four_bar) => {
            to.u16(3);
            let links = four_bar.links();
            to.numbers([links.ground_m, links.crank_m, links.coupler_m, links.rocker_m]);
            to.numbers([links.crank_zero_rad, links.rocker_zero_rad]);
            to.numbers(four_bar.range_rad());
            to.u16(u16::from(links.crossed));
        }
    }
}

fn read_drive(from: &mut Reader<'_>, index: usize) -> Result<BoardDrive, BoardRigError> {
    let mut indices = |what| -> Result<Vec<u16, DRIVE_CAPACITY>, BoardRigError> {
        let found = usize::from(from.u16());
        if found > DRIVE_CAPACITY {
            let error = DriveError::TooMany { what, found, most: DRIVE_CAPACITY };
            return Err(BoardRigError::Drive { index, error });
        }
        items(found, |_| Ok(from.u16()))
    };
    let (dofs, servos) = (indices("dofs")?, indices("servos")?);
    let refused = |error| BoardRigError::Drive { index, error };
    let drive = match from.u16() {
        kind @ (0 | 1) => {
            let found = dofs.len().saturating_mul(servos.len());
            if found > MATRIX_CAPACITY {
                return Err(refused(DriveError::TooMany {
                    what: "numbers",
                    found,
                    most: MATRIX_CAPACITY,
                }));
            }
            let numbers: Vec<f32, MATRIX_CAPACITY> = items(found, |_| Ok(from.f32()))?;
            let offset: Vec<f32, DRIVE_CAPACITY> = items(dofs.len(), |_| Ok(from.f32()))?;
            // A chunk has at least one number, otherwise it has no size; `new` refuses a matrix without rows.
            let mut rows = Vec::<&[f32], DRIVE_CAPACITY>::new();
            for row in numbers.chunks_exact(servos.len().max(1)) {
                // There is room, because the dofs were counted.
                let _ = rows.push(row);
            }
            // A branch instead of a function pointer, which the stack audit could not follow.
            let matrix = if kind == 1 {
                Matrix::of_ball(&rows, &offset)
            } else {
                Matrix::new(&rows, &offset)
            };
            matrix.map_err(refused)?.into()
        }
        2 => {
            let found = usize::from(from.u16());
            if found > CURVE_CAPACITY {
                return Err(refused(DriveError::TooMany {
                    what: "points",
                    found,
                    most: CURVE_CAPACITY,
                }));
            }
            let points: Vec<[f32; 2], CURVE_CAPACITY> = items(found, |_| Ok(from.numbers()))?;
            Curve::new(&points).map_err(refused)?.into()
        }
        3 => {
            let [ground_m, crank_m, coupler_m, rocker_m] = from.numbers();
            let [crank_zero_rad, rocker_zero_rad] = from.numbers();
            let range_rad = from.numbers();
            let crossed = match from.u16() {
                0 => false,
                1 => true,
                found => {
                    let what = "assembly of drive";
                    return Err(BoardRigError::Kind { what, index, found, most: 1 });
                }
            };
            let links = Links {
                ground_m,
                crank_m,
                coupler_m,
                rocker_m,
                crank_zero_rad,
                rocker_zero_rad,
                crossed,
            };
            FourBar::new(links, range_rad).map_err(refused)?.into()
        }
        found => return Err(BoardRigError::Kind { what: "drive", index, found, most: 3 }),
    };
    Ok(BoardDrive { drive, dofs, servos })
}

fn write_servo(to: &mut Writer<'_>, servo: &BoardServo) {
    to.u16(servo.bus);
    to.u16(match servo.address {
        Address::Id(id) => u16::from(id),
        Address::Channel(channel) => CHANNELS.saturating_add(u16::from(channel)),
    });
    let s = servo.servo.settings();
    to.numbers([s.gear, s.offset_rad]);
    to.numbers(s.range_rad);
    to.numbers([s.torque_nm, s.speed_rad_s, s.acceleration_rad_s2, s.torque_constant_nm_a]);
    to.numbers([s.position_gain_nm_rad, s.friction_nm, s.damping_nm_s, s.rotor_inertia_kg_m2]);
    to.u16(match s.on_signal_loss {
        SignalLoss::Limp => 0,
        SignalLoss::Hold => 1,
        SignalLoss::Home => 2,
    });
    to.u16(0);
}

fn read_servo(from: &mut Reader<'_>, index: usize) -> Result<BoardServo, BoardRigError> {
    let bus = from.u16();
    let found = from.u16();
    let number = |address: u16| u8::try_from(address).unwrap_or(u8::MAX);
    let address = match found {
        0..=252 => Address::Id(number(found)),
        256..=271 => Address::Channel(number(found.saturating_sub(CHANNELS))),
        _ => {
            let part = "an address: ids are 0 to 252, channels 256 to 271, not";
            let found = usize::from(found);
            return Err(BoardRigError::Index { what: "servo", index, part, found });
        }
    };
    let [gear, offset_rad, least, most] = from.numbers();
    let [torque_nm, speed_rad_s, acceleration_rad_s2, torque_constant_nm_a] = from.numbers();
    let [position_gain_nm_rad, friction_nm, damping_nm_s, rotor_inertia_kg_m2] = from.numbers();
    let on_signal_loss = match from.u16() {
        0 => SignalLoss::Limp,
        1 => SignalLoss::Hold,
        2 => SignalLoss::Home,
        found => {
            return Err(BoardRigError::Kind {
                what: "signal loss of servo",
                index,
                found,
                most: 2,
            });
        }
    };
    match from.u16() {
        0 => {}
        found => {
            return Err(BoardRigError::Kind { what: "last field of servo", index, found, most: 0 });
        }
    }
    let settings = ServoSettings {
        gear,
        offset_rad,
        range_rad: [least, most],
        torque_nm,
        speed_rad_s,
        acceleration_rad_s2,
        torque_constant_nm_a,
        position_gain_nm_rad,
        friction_nm,
        damping_nm_s,
        rotor_inertia_kg_m2,
        on_signal_loss,
    };
    let servo = Servo::new(settings).map_err(|error| BoardRigError::Servo { index, error })?;
    Ok(BoardServo { bus, address, servo })
}
