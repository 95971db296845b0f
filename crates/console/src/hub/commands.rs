//! Commands of pages.

use std::time::Duration;

use sinew_board_client::{Journey, Line};
use sinew_link::message::{Command, POSE_MAX, State};

use super::act::{Act, Feeding};
use super::slider::Slider;
use super::{Hub, PageCommand, Refused};
use crate::message::ToPage;
use crate::server::PageId;

/// Time without a message of a slider after which it counts as let go.
const LET_GO: Duration = Duration::from_millis(400);
/// Share of the maximum speed that a journey uses: the board's own limit is not to be felt.
const SHARE: f32 = 0.7;

impl<L: Line> Hub<'_, L> {
    /// Executes a command of a page, if the page may give it. Returns what was done; `None`: it is answered later.
    pub(super) fn obey(
        &mut self,
        page: PageId,
        id: Option<u64>,
        command: PageCommand,
    ) -> Option<Result<String, Refused>> {
        use PageCommand::{
            Arm, Clear, EStop, Follow, Hello, Hold, Home, Jog, Lower, Ping, Play, Release, Seek,
            Stop, Upload, Wheel,
        };
        let is_driver = self.wheel.is_at(page);
        Some(match command {
            EStop => {
                self.end_all();
                self.ask(Command::EStop).map(|_| "torque is off".to_owned())
            }
            Hold => {
                self.end_all();
                self.hold()
            }
            Stop => {
                self.end_all();
                let going = "the rig goes to its rest pose, then torque is off";
                self.ask(Command::Stop).map(|_| going.to_owned())
            }
            Ping { t } => {
                self.tell_page(page, &ToPage::Pong { t });
                return None;
            }
            Hello { .. } => Ok(String::new()),
            Wheel { take } => self.turn_wheel(page, take),
            _ if !is_driver => {
                Err(Refused::because("another page drives; this page may hold and stop"))
            }
            _ if self.closing.is_some() => Err(Refused::because("the program ends")),
            _ if self.lost.is_some() => Err(Refused::because("the board does not answer")),
            Arm => {
                self.begin_arming(page, id);
                return None;
            }
            Lower => {
                self.end_all();
                self.ask(Command::Disarm).map(|_| "the rig is lowered where it is".to_owned())
            }
            Home => self.travel(&self.scene.home.clone()),
            Clear => self.ask(Command::ClearFaults).map(|_| "no fault is latched".to_owned()),
            Play { slot, is_loop } => self.play(slot, is_loop),
            Seek { t, slot } => self.seek(t, slot),
            Follow { t, slot } => self.seek(Some(t), slot).and_then(|_| match self.ghost.clone() {
                Some(ghost) => self.travel(&ghost),
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
            Upload { name, slot } => {
                self.announce_upload(page, id, name, slot);
                return None;
            }
        })
    }

    /// Ends what goes on, without a word to the board. A slider that is held moves nothing until it is let go.
    pub(super) fn end_all(&mut self) {
        self.bar_slider();
        (self.act, self.arming) = (None, None);
    }

    /// Bars a slider whose motion was ended by something else than its page.
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
            true if self.wheel.take(page, now) => Ok("this page drives".to_owned()),
            true => Err(Refused::because("another page drives: it must give the wheel back first")),
            false if self.wheel.is_at(page) => {
                let is_moved = self.act.as_ref().is_some_and(Act::dies_with_its_page);
                let held = if is_moved { self.hold() } else { Ok(String::new()) };
                self.wheel.free(now);
                held.map(|_| "nobody drives".to_owned())
            }
            false => Ok("this page does not drive".to_owned()),
        };
        self.tell_roles();
        answer
    }

    /// Moves a joint towards a slider's goal.
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
        if let Some(Act::Slider(feeding)) = &mut self.act
            && feeding.motion.dof == dof
        {
            feeding.motion.feed(goal, now);
            return Ok(String::new());
        }
        if matches!(self.act, Some(Act::Show(_) | Act::Journey(_))) {
            return Err(Refused::because("the rig moves on its own: hold it first"));
        }
        let at = self.wanted(coordinate).or_else(|| self.board.log.q.get(coordinate).copied());
        let at = at.ok_or_else(|| Refused::because("the pose is not known yet"))?;
        let most = own.speed.unwrap_or(self.soft_rad_s).min(self.soft_rad_s);
        let mut slider = Slider::new((dof, coordinate), at, (own.range, most), now);
        slider.feed(goal, now);
        self.act = Some(Act::Slider(Feeding::new(slider, now)));
        Ok(String::new())
    }

    /// Moves all joints to a pose.
    pub(super) fn travel(&mut self, to: &[f32]) -> Result<String, Refused> {
        if self.state() != State::Holding {
            return Err(Refused::Other(format!(
                "the rig is {}: it must stand, armed",
                self.state()
            )));
        }
        let from: Vec<f32> = (0..to.len())
            .filter_map(|k| self.wanted(k).or_else(|| self.board.log.q.get(k).copied()))
            .collect();
        if from.len() != to.len() {
            return Err(Refused::because("the pose is not known yet"));
        }
        if to.len() > POSE_MAX {
            return Err(Refused::because("the rig has more joints than a live pose carries"));
        }
        let now = self.now();
        let most_rad_s = SHARE * self.soft_rad_s;
        let journey = Journey::new(&from, to, &self.scene.blocks, most_rad_s, now);
        self.arrived = false;
        self.act = Some(Act::Journey(Feeding::new(journey, now)));
        Ok("the rig moves".to_owned())
    }

    /// Returns a coordinate of the pose that the board commands, if it is known.
    pub(super) fn wanted(&self, coordinate: usize) -> Option<f32> {
        self.scene.commanded(&self.board.log)?.get(coordinate).copied()
    }
}
