//! Executes the commands of pages, and of programs that drive.

use std::time::Duration;

use sinew_board_client::console::Report;
use sinew_board_client::{Journey, Line};
use sinew_link::message::{Command, POSE_MAX, Refusal, State};

use super::act::{Act, Feeding};
use super::bound::Bound;
use super::slider::Slider;
use super::{Hub, PageCommand, Refused};
use crate::local::{CUTS, STOPS};
use crate::message::ToPage;
use crate::server::{PageId, is_program};

/// Time without a message of a barred slider after which it counts as released.
const LET_GO: Duration = Duration::from_millis(400);
/// Share of a slider's maximum speed that a journey uses, so that the board's own limit is not reached.
const SHARE: f32 = 0.7;
/// Longest time of a motion to a pose, s.
const LONGEST_S: f64 = 3600.0;
/// Permitted distance beyond a range, rad or m, which rounding may cause.
const ROUNDING: f32 = 1e-5;

impl<L: Line> Hub<'_, L> {
    /// Executes a command of a page, if the page may give it. Returns the result in words; or `None` if the answer
    /// follows later, or is not needed.
    pub(super) fn obey(
        &mut self,
        page: PageId,
        id: Option<u64>,
        command: PageCommand,
    ) -> Option<Result<String, Refused>> {
        use PageCommand::{
            Arm, Clear, EStop, Faults, Follow, Goto, Hello, Hold, Home, Idle, Jog, Live, Lower,
            Ping, Play, Record, Release, Seek, State, Stop, Upload, Wheel,
        };
        let is_driver = self.wheel.is_at(page);
        match command {
            Hold if !is_driver => self.bound.hold(),
            Stop | EStop if !is_driver => self.bound.stop(),
            Hold | Arm | Home | Goto { .. } | Play { .. } | Follow { .. } | Idle { .. }
                if is_driver =>
            {
                self.bound.release();
            }
            _ => {}
        }
        Some(match command {
            EStop => {
                self.end_all();
                self.ask(Command::EStop).map(|_| CUTS.to_owned())
            }
            Hold => {
                self.end_all();
                self.hold()
            }
            Stop => {
                self.end_all();
                self.ask(Command::Stop).map(|_| STOPS.to_owned())
            }
            Ping { t } => {
                self.tell_page(page, &ToPage::Pong { t });
                return None;
            }
            Hello { .. } => Ok(String::new()),
            Wheel { take } => self.turn_wheel(page, take),
            State | Faults if self.lost.is_some() => {
                Err(Refused::because("the board does not answer"))
            }
            State => self.report(),
            // The log takes many turns of the link, so pages of other machines do not ask for it.
            Faults if is_program(page) => self.faults(),
            _ if !is_driver => {
                Err(Refused::because("somebody else drives; everybody may hold and stop"))
            }
            Record { on: true } => self.begin_record(),
            Record { on: false } => self.end_record(None).map_err(Refused::Other),
            _ if self.closing.is_some() => Err(Refused::because("the program ends")),
            _ if self.lost.is_some() => Err(Refused::because("the board does not answer")),
            Arm => {
                if is_program(page) {
                    if let Err(refused) = self.bound.check_arm() {
                        return Some(Err(refused));
                    }
                } else {
                    // A person arms by a deliberate gesture.
                    self.bound.clear();
                }
                self.begin_arming(page, id);
                return None;
            }
            Lower => {
                self.end_all();
                self.ask(Command::Disarm).map(|_| "the rig is lowered where it is".to_owned())
            }
            Home => self.travel(&self.scene.home.clone(), Duration::ZERO),
            Goto { q, seconds } => {
                let begun = self.go_to(q, seconds);
                return self.answer_at_end(page, id, begun);
            }
            Live { q } => self.live(q),
            Faults => Err(Refused::because("only programs of this user read the log of faults")),
            Clear => self.clear(),
            Play { slot, is_loop, rounds: 0 } => self.play(slot, is_loop, 0),
            Play { slot, is_loop, rounds } => {
                let begun = self.play(slot, is_loop, rounds);
                return self.answer_at_end(page, id, begun);
            }
            Idle { on } => self.turn_idle(on),
            Seek { t, slot } => self.seek(t, slot),
            Follow { t, slot } => self.seek(Some(t), slot).and_then(|_| match self.ghost.clone() {
                Some(ghost) => self.travel(&ghost, Duration::ZERO),
                None => Err(Refused::because("there is no such pose")),
            }),
            Jog { dof, goal } => self.jog(dof, goal),
            Release { .. } => {
                self.barred = None;
                match self.act {
                    Some(Act::Slider(_)) => self.hold(),
                    _ => Ok("nothing moves".to_owned()),
                }
            }
            Upload { name, slot, .. } => {
                self.announce_upload(page, id, name, slot);
                return None;
            }
        })
    }

    /// Clears faults, and lets a program arm again after a stop of somebody else.
    fn clear(&mut self) -> Result<String, Refused> {
        let was_stopped = self.bound.clear();
        match self.ask(Command::ClearFaults) {
            Err(Refused::Board(Refusal::NoFault)) if was_stopped => {
                Ok("the rig may be armed again".to_owned())
            }
            cleared => cleared.map(|_| "no fault is latched".to_owned()),
        }
    }

    /// Ends the motion and the arming, without a command to the board. A slider that is held moves nothing until it is
    /// released.
    pub(super) fn end_all(&mut self) {
        self.bar_slider();
        self.end_idle();
        self.act = None;
        self.end_arming("the rig was told to stand");
    }

    /// Bars a slider whose motion was ended by something other than its page: it must be released first.
    pub(super) fn bar_slider(&mut self) {
        if matches!(self.act, Some(Act::Slider(_))) {
            self.barred = Some(self.now());
        }
    }

    fn turn_wheel(&mut self, page: PageId, take: bool) -> Result<String, Refused> {
        let now = self.now();
        let may_drive = self.pages.get(&page).is_some_and(|page| page.may_drive);
        let answer = match take {
            true if !may_drive => Err(Refused::because(
                "a page of another machine views and stops only: start the console with --allow-drive",
            )),
            true => {
                let is_new = !self.wheel.is_at(page);
                if !self.wheel.take(page, now) {
                    self.tell_roles();
                    return Err(Refused::because(
                        "somebody else drives, and was asked for the wheel",
                    ));
                }
                if is_new {
                    self.bound = Bound::default();
                    self.end_arming("somebody else drives");
                }
                // The previous driver may have become silent while it moved a joint.
                let is_moved = self.act.as_ref().is_some_and(Act::dies_with_its_page);
                let held = if is_new && is_moved { self.hold() } else { Ok(String::new()) };
                held.map(|_| "this page drives".to_owned())
            }
            false if self.wheel.is_at(page) => {
                self.end_arming("this page does not drive any more");
                let is_moved = self.act.as_ref().is_some_and(Act::dies_with_its_page);
                let held = if is_moved { self.hold() } else { Ok(String::new()) };
                self.wheel.pass(now);
                self.bound = Bound::default();
                held.map(|_| "this page does not drive any more".to_owned())
            }
            false => Ok("this page does not drive".to_owned()),
        };
        self.tell_roles();
        answer
    }

    /// Moves a joint towards a slider's goal. Further calls for the same joint change the goal.
    fn jog(&mut self, dof: usize, goal: f64) -> Result<String, Refused> {
        let now = self.now();
        #[expect(
            clippy::cast_possible_truncation,
            reason = "a board has f32, and the range limits it"
        )]
        let goal = goal as f32;
        if !matches!(self.state(), State::Holding | State::Playing) {
            return Err(Refused::Other(format!("the rig is {}: arm it first", self.state())));
        }
        if self.barred.is_some_and(|last| now.saturating_sub(last) < LET_GO) {
            self.barred = Some(now);
            return Err(Refused::because("the rig was told to stand: let the slider go first"));
        }
        let own =
            self.scene.dofs.get(dof).ok_or_else(|| Refused::because("there is no such joint"))?;
        let Some(coordinate) = own.coordinate else {
            return Err(Refused::because("a ball joint has no slider of its own"));
        };
        if let Some(why) = self.scene.follows(own) {
            return Err(Refused::Other(why));
        }
        if let Some(Act::Slider(feeding)) = &mut self.act
            && feeding.motion.dof == dof
        {
            if feeding.motion.feed(goal, now) {
                feeding.hurry();
            }
            return Ok(String::new());
        }
        if matches!(self.act, Some(Act::Show(_) | Act::Journey(_) | Act::Live(_) | Act::Idle(_))) {
            return Err(Refused::because("the rig moves on its own: hold it first"));
        }
        let at = self.wanted(coordinate).or_else(|| self.board.log.q.get(coordinate).copied());
        let at = at.ok_or_else(|| Refused::because("the pose is not known yet"))?;
        let leads = self.scene.leads(dof);
        let soft = self.soft_rad_s / leads.unwrap_or(1.0).max(1.0);
        let most = own.speed.unwrap_or(soft).min(soft);
        let mut slider = Slider::new((dof, coordinate), at, (own.range, most), now);
        slider.feed(goal, now);
        if leads.is_some() {
            slider.lead(self.pose_now(self.scene.home.len())?);
        }
        self.act = Some(Act::Slider(Feeding::new(slider, now)));
        Ok(String::new())
    }

    /// Begins to move the rig to a pose of a program.
    fn go_to(&mut self, mut q: Vec<f32>, seconds: f64) -> Result<String, Refused> {
        self.check_pose(&q)?;
        if !(0.0..=LONGEST_S).contains(&seconds) {
            return Err(Refused::Other(format!(
                "seconds: expected 0 to {LONGEST_S}, found {seconds}"
            )));
        }
        self.scene.follow(&mut q);
        self.travel(&q, Duration::from_secs_f64(seconds))
    }

    /// Refuses a pose of a program that is not one of this rig.
    pub(super) fn check_pose(&self, q: &[f32]) -> Result<(), Refused> {
        let count = self.scene.home.len();
        if q.len() != count || count > POSE_MAX {
            return Err(Refused::Other(format!(
                "expected a pose of {count} numbers, of which a live pose carries {POSE_MAX}; found {}",
                q.len()
            )));
        }
        if q.iter().any(|number| !number.is_finite()) {
            return Err(Refused::because("expected a pose of finite numbers"));
        }
        for dof in self.scene.dofs.iter().filter(|dof| dof.limited && dof.leader.is_none()) {
            let Some(at) = dof.coordinate.map(|coordinate| q[coordinate]) else { continue };
            let [least, most] = dof.range;
            if !(least - ROUNDING..=most + ROUNDING).contains(&at) {
                return Err(Refused::Other(format!(
                    "`{}`: expected {least:.4} to {most:.4}, found {at:.4}",
                    dof.name
                )));
            }
        }
        Ok(())
    }

    /// Returns the state of the rig as JSON.
    fn report(&self) -> Result<String, Refused> {
        let log = &self.board.log;
        let summary =
            log.summary.ok_or_else(|| Refused::because("the controller sends no telemetry"))?;
        json(&Report {
            rig: self.board.about().rig,
            summary,
            summaries: log.summaries,
            q: log.q.clone(),
            efforts: log.dofs.iter().map(|dof| dof.effort).collect(),
            servos: log.servos.clone(),
        })
    }

    /// Returns the board's log of faults as JSON.
    fn faults(&mut self) -> Result<String, Refused> {
        // Its many turns of the link would delay the poses of a motion, and a hold.
        self.check_free()?;
        match self.board.fault_log() {
            Ok(records) => json(&records),
            Err(error) => {
                let text = error.to_string();
                self.lose(error);
                Err(Refused::Other(text))
            }
        }
    }

    /// Begins to move all joints of a rig that holds to a pose, in at least a time.
    pub(super) fn travel(&mut self, to: &[f32], least: Duration) -> Result<String, Refused> {
        if self.state() != State::Holding {
            return Err(Refused::Other(format!(
                "the rig is {}: it must stand, armed",
                self.state()
            )));
        }
        self.check_free()?;
        let from = self.pose_now(to.len())?;
        let now = self.now();
        let most_rad_s = SHARE * self.soft_rad_s;
        let journey = Journey::new(&from, to, &self.scene.blocks, most_rad_s, now).lasting(least);
        self.arrived = None;
        self.act = Some(Act::Journey(Feeding::new(journey, now)));
        Ok("the rig moves".to_owned())
    }

    /// Refuses what must not happen while the hub moves the rig.
    fn check_free(&self) -> Result<(), Refused> {
        if self.act.is_some() {
            return Err(Refused::because("the rig moves: hold it first"));
        }
        Ok(())
    }

    /// Returns the pose at which a motion of all joints begins: the pose that the board commands, otherwise the
    /// measured pose.
    pub(super) fn pose_now(&self, count: usize) -> Result<Vec<f32>, Refused> {
        let own = |k: usize| self.wanted(k).or_else(|| self.board.log.q.get(k).copied());
        let pose: Vec<f32> = (0..count).filter_map(own).collect();
        if pose.len() != count {
            return Err(Refused::because("the pose is not known yet"));
        }
        if count > POSE_MAX {
            return Err(Refused::because("the rig has more joints than a live pose carries"));
        }
        Ok(pose)
    }

    /// Returns a coordinate of the pose that the board commands; `None` if it is not known.
    pub(super) fn wanted(&self, coordinate: usize) -> Option<f32> {
        self.scene.commanded(&self.board.log)?.get(coordinate).copied()
    }
}

fn json(message: &impl serde::Serialize) -> Result<String, Refused> {
    serde_json::to_string(message).map_err(|error| Refused::Other(error.to_string()))
}
