//! The drives of a whole rig.

use heapless::Vec;
use sinew_core::coordinates::DofCommand;
use sinew_core::tracker::Timing;
use sinew_rig::board::{BoardDrive, BoardRig};
use sinew_rig::drive::{DriveInputError, DrivePose, Numbers};

use super::turn::{self, Turn};
use super::{
    Condition, DriveSettings, InputError, Limit, ServoCommand, ServoDrive, SetupError, ShaftTarget,
};

/// The drives of a rig. They convert efforts and targets of dofs to servo commands, and readings back to dofs.
///
/// Targets of revolute joints are in [-π, π]. They are unwrapped to the angle nearest to the middle of the joint's
/// range or, for a joint without a range, nearest to the last target.
#[derive(Debug, Clone)]
pub struct Drives<'r, const BODIES: usize, const DOFS: usize, const SERVOS: usize> {
    pub(super) rig: &'r BoardRig<BODIES, DOFS, SERVOS>,
    pub(super) servos: Vec<ServoDrive, SERVOS>,
    turns: Vec<Turn, DOFS>,
}

impl<'r, const BODIES: usize, const DOFS: usize, const SERVOS: usize>
    Drives<'r, BODIES, DOFS, SERVOS>
{
    /// Creates the drives of a rig. `settings` contains the settings of each servo, in the rig's order. `timing` is
    /// the tracker's timing, see [`CurrentDrive::new`](super::CurrentDrive::new).
    ///
    /// # Errors
    /// [`SetupError`] names the servo or the drive, and the error.
    pub fn new(
        rig: &'r BoardRig<BODIES, DOFS, SERVOS>,
        settings: &[DriveSettings],
        timing: Timing,
    ) -> Result<Self, SetupError> {
        let mut drives = Self::uninit(rig);
        drives.init(settings, timing)?;
        Ok(drives)
    }

    /// Creates drives without settings and servos, for [`init`](Self::init).
    pub(crate) fn uninit(rig: &'r BoardRig<BODIES, DOFS, SERVOS>) -> Self {
        Self { rig, servos: Vec::new(), turns: Vec::new() }
    }

    /// Initializes in place.
    #[inline(never)]
    pub(crate) fn init(
        &mut self,
        settings: &[DriveSettings],
        timing: Timing,
    ) -> Result<(), SetupError> {
        let (expected, found) = (self.rig.servos().len(), settings.len());
        let count = SetupError::Count { expected, found };
        if expected != found {
            return Err(count);
        }
        for (index, (on_board, settings)) in self.rig.servos().iter().zip(settings).enumerate() {
            let refused = |why| SetupError::Servo { servo: index, why };
            let drive = ServoDrive::new(&on_board.servo, settings, timing).map_err(refused)?;
            drive.check_address(on_board.address).map_err(refused)?;
            self.servos.push(drive).map_err(|_| count)?;
        }
        self.turns = turn::turns(self.rig);
        self.check_classes()?;
        self.begin_at_home();
        Ok(())
    }

    /// Checks that no drive has servos of two classes, which would work against each other.
    fn check_classes(&self) -> Result<(), SetupError> {
        for (index, drive) in self.rig.drives().iter().enumerate() {
            let mut classes = drive.servos.iter().filter_map(|servo| self.class(*servo));
            let first = classes.next();
            if classes.any(|class| Some(class) != first) {
                return Err(SetupError::Mixed { drive: index });
            }
        }
        Ok(())
    }

    fn class(&self, servo: u16) -> Option<super::Class> {
        self.servos.get(usize::from(servo)).map(ServoDrive::class)
    }

    /// Returns the drive of each servo, in the rig's order.
    pub fn servos(&self) -> &[ServoDrive] {
        &self.servos
    }

    /// Starts at the rig's home pose, before anything was read or commanded.
    fn begin_at_home(&mut self) {
        for drive in self.rig.drives() {
            let mut homes = Numbers::new();
            for dof in &drive.dofs {
                let home = self.rig.dofs().get(usize::from(*dof));
                // There is room: a drive's dofs and servos are limited in number.
                let _ = homes.push(home.map_or(0.0, |dof| dof.home));
            }
            let Ok(home) = drive.drive.at_joints(&homes) else { continue };
            for (index, shaft_rad) in drive.servos.iter().zip(home.servos()) {
                let Some(servo) = self.servos.get_mut(usize::from(*index)) else { continue };
                let settings = servo.servo().settings();
                let own_rad = settings.gear * shaft_rad + settings.offset_rad;
                servo.begin(if own_rad.is_finite() { own_rad } else { 0.0 });
            }
        }
    }

    /// Restarts each servo at its measured position. A servo without a reading restarts at its last commanded
    /// position, which is the rig's home pose at first. Offsets and currents rise from zero.
    pub fn begin(&mut self, conditions: &[Condition]) {
        let read = |servo: usize| conditions.get(servo).and_then(|condition| condition.feedback);
        for (index, servo) in self.servos.iter_mut().enumerate() {
            let read_rad = read(index).map(|read| read.position_rad - servo.encoder().zero_rad);
            servo.begin(read_rad.filter(|rad| rad.is_finite()).unwrap_or(servo.sent_rad()));
        }
        for drive in self.rig.drives() {
            // If a servo continues from its last commanded position, its joint stays in the same turn.
            if drive.servos.iter().any(|servo| read(usize::from(*servo)).is_none()) {
                continue;
            }
            for dof in &drive.dofs {
                let index = usize::from(*dof);
                if let (Some(Turn::Last(last)), Some(dof)) =
                    (self.turns.get_mut(index), self.rig.dofs().get(index))
                {
                    *last = dof.home;
                }
            }
        }
    }

    /// Computes a tick's command for each servo; `None` if no drive moves it. `commands` are per dof, `conditions`
    /// per servo. O(servos).
    ///
    /// # Errors
    /// [`InputError`] if a number is NaN, infinite or above 1e6 in absolute value, the number of items is not that of
    /// the dofs or servos, or a drive would need a number that f32 cannot hold. Nothing changes then.
    pub fn step(
        &mut self,
        commands: &[DofCommand],
        conditions: &[Condition],
        out: &mut [Option<ServoCommand>],
    ) -> Result<(), InputError> {
        self.check(commands, conditions)?;
        InputError::check_count("commands out", self.servos.len(), out.len())?;
        let mut targets: Vec<Option<(ShaftTarget, Option<Limit>)>, SERVOS> = Vec::new();
        // There is room: `SERVOS` is the maximum number.
        let _ = targets.resize(self.servos.len(), None);
        let mut turns = self.turns.clone();
        for (index, drive) in self.rig.drives().iter().enumerate() {
            self.targets(drive, commands, conditions, &mut turns, &mut targets)
                .map_err(|_| InputError::Drive { drive: index })?;
        }
        self.turns = turns;
        for (((out, servo), target), condition) in
            out.iter_mut().zip(&mut self.servos).zip(&targets).zip(conditions)
        {
            *out = target.map(|(target, limit)| {
                let command = servo.command(&target, condition);
                ServoCommand { limit: command.limit.or(limit), ..command }
            });
        }
        Ok(())
    }

    fn check(&self, commands: &[DofCommand], conditions: &[Condition]) -> Result<(), InputError> {
        InputError::check_count("commands", self.rig.dofs().len(), commands.len())?;
        Condition::check_all(self.servos.len(), conditions)?;
        for (index, command) in commands.iter().enumerate() {
            for (what, found) in [
                ("position of dof", command.position),
                ("velocity of dof", command.velocity),
                ("feed-forward effort of dof", command.feedforward_effort),
                ("feedback effort of dof", command.feedback_effort),
            ] {
                InputError::check_number(what, index, found)?;
            }
        }
        Ok(())
    }

    /// Computes the targets of the shafts of a drive's servos. Efforts are distributed for the measured pose if all
    /// servos were read, else for the target pose.
    fn targets(
        &self,
        drive: &BoardDrive,
        commands: &[DofCommand],
        conditions: &[Condition],
        turns: &mut [Turn],
        targets: &mut [Option<(ShaftTarget, Option<Limit>)>],
    ) -> Result<(), DriveInputError> {
        let mut numbers: [Numbers; 4] = Default::default();
        for dof in &drive.dofs {
            let index = usize::from(*dof);
            let command = commands.get(index).copied().unwrap_or_default();
            let position = turns
                .get_mut(index)
                .map_or(command.position, |turn| turn.unwrapped(command.position));
            let parts =
                [position, command.velocity, command.feedforward_effort, command.feedback_effort];
            for (all, part) in numbers.iter_mut().zip(parts) {
                // There is room: a drive's number of dofs is limited.
                let _ = all.push(part);
            }
        }
        let [q, qd, feedforward, feedback] = &numbers;
        let wanted = drive.drive.at_joints(q)?;
        let limit = wanted.reason().map(Limit::from);
        let velocities = wanted.servo_velocities(qd)?;
        let measured = self.shaft_positions(drive, conditions);
        let measured = measured.map(|positions| drive.drive.at_servos(&positions));
        let here: DrivePose<'_> = match measured {
            Some(measured) => measured?,
            None => wanted.clone(),
        };
        let feedforward = here.servo_torques(feedforward)?;
        let feedback = here.servo_torques(feedback)?;
        let parts = wanted.servos().iter().zip(&velocities).zip(feedforward.iter().zip(&feedback));
        for (index, ((position, velocity), (feedforward, feedback))) in
            drive.servos.iter().zip(parts)
        {
            if let Some(target) = targets.get_mut(usize::from(*index)) {
                let shaft = ShaftTarget {
                    position_rad: *position,
                    velocity_rad_s: *velocity,
                    feedforward_nm: *feedforward,
                    feedback_nm: *feedback,
                };
                *target = Some((shaft, limit));
            }
        }
        Ok(())
    }
}
