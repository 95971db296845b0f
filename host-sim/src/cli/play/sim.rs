//! `sinew play --target sim`: plays a show on simulated servos, with the controller in this program.

use std::process::ExitCode;

use anyhow::{Context as _, bail};
use sinew_console::local::Bell;
use sinew_firmware::controller::Approach;
use sinew_firmware::supervisor::{Fault, FaultSet, Moving, Overload, Refused, State};
use sinew_host_util::command::{note, print};
use sinew_performance::play::{Director, Ended, Memory, Recorder, RigParts, SimulatedRig, Tally};
use sinew_performance::rig::LoadedRig;
use sinew_rig::toml_file;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::plant::RigPlant;
use sinew_show::Show;

use super::Args;
use super::live::{Live, Moment, Row};
use super::real_time::RealTime;
use crate::cli::output::OutputPath;
use crate::cli::sound::Player;
use crate::cli::stop::Stop;

/// Opens the socket through which other terminals stop the rig. If this fails, prints the reason.
fn open_bell() -> Option<Bell> {
    let name = format!("simulated-{}", std::process::id());
    let tell = |error| note(format_args!("`sinew stop` cannot stop this play: {error}"));
    Bell::open(&name).map_err(tell).ok()
}

/// Live display of a simulated rig.
struct SimulatedLive {
    live: Live,
    has_waited: bool,
    /// Beginning of the show, computed when the rig begins to play; `None` before.
    approach: Option<Approach>,
    ran: u64,
    show_s: f64,
    is_loop: bool,
}

impl SimulatedLive {
    fn new(show: &Show<'_>) -> Self {
        let (show_s, is_loop) = (f64::from(show.duration_s()), show.is_loop());
        let live = Live::new(show);
        Self { live, has_waited: false, approach: None, ran: 0, show_s, is_loop }
    }

    /// Returns the place in the show, s.
    fn played_s(&self, sim: &SimulatedRig<'_, RigPlant>) -> f64 {
        let played_s = self.ran as f64 / f64::from(sim.parts.rate_hz);
        if self.is_loop { played_s % self.show_s } else { played_s.min(self.show_s) }
    }

    /// Updates the display after a tick. `waits_for`: the joint that must come to rest before the rig can be armed.
    fn show(&mut self, sim: &SimulatedRig<'_, RigPlant>, waits_for: Option<Moving>) {
        let (report, parts) = (sim.report(), sim.parts);
        self.ran += u64::from(sim.runs());
        let is_playing = report.state == State::Playing;
        if is_playing && self.approach.is_none() {
            self.approach = sim.approach();
        }
        let voltages = report.servos.iter().filter_map(|servo| servo.voltage_v);
        let moment = Moment {
            time_s: sim.time_s(),
            state: report.state.to_string(),
            is_playing,
            runs: sim.runs(),
            approach: self.approach,
            show_s: self.played_s(sim),
            errors_deg: report
                .following
                .map(|error| [error.mean_rad, error.most_rad].map(f32::to_degrees)),
            supply_v: voltages.reduce(f32::min),
            tick_us: None,
        };
        self.live.show(&moment, || rows(sim));
        if let Some(moving) = waits_for
            && !std::mem::replace(&mut self.has_waited, true)
        {
            let [now, most] = moving.rad_s();
            self.live.tell(format_args!(
                "{:7.2} s  waits until the rig rests: {} at {now:.2} rad/s, at most {most:.2}",
                sim.time_s(),
                parts.names[usize::from(moving.dof)],
            ));
        }
        for fault in report.raised.iter() {
            self.live.tell(format_args!("{:7.2} s  {fault}", sim.time_s()));
        }
    }
}

/// Returns the rows of the table: the joints with servos.
fn rows(sim: &SimulatedRig<'_, RigPlant>) -> Vec<Row> {
    let (report, parts) = (sim.report(), sim.parts);
    // If a joint's servos report no position, the error of the simulated rig is used.
    let simulated = sim.simulated_errors();
    let has_effort = !matches!(report.state, State::Off | State::Limp | State::Lowering);
    let row = |joint: usize| {
        let dof = report.dofs[joint];
        // Commanded minus measured, as the controller reports it.
        let error = if parts.tells_nothing(joint) { -simulated[joint] } else { dof.error };
        let told = parts.first_servo[joint].map(|servo| &report.servos[servo]);
        Row {
            joint: parts.names[joint].clone(),
            slides: parts.slides[joint],
            error: report.following.map(|_| error),
            effort: has_effort.then_some(dof.effort),
            heat_percent: told.map(|servo| 100.0 * servo.heat),
            celsius: told.and_then(|servo| servo.temperature_c),
            limiter: sim.limiter(joint),
        }
    };
    let joints = (0..parts.names.len()).filter(|joint| parts.drives[*joint].is_some());
    joints.map(row).collect()
}

impl Args {
    /// Plays to the end, and prints the table.
    pub(super) fn simulate(
        &self,
        rig: &LoadedRig,
        parts: &RigParts,
        bytes: &[u8],
        mut player: Option<Player>,
    ) -> anyhow::Result<ExitCode> {
        let of_rig = || self.rig.display().to_string();
        let of_record =
            || self.record.iter().map(|path| path.display().to_string()).collect::<String>();
        let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
        let plant = parts.plant(&rig.description, &rig.mechanism).with_context(of_rig)?;
        let mut sim =
            SimulatedRig::new(parts, Some(bytes), &mut memories, plant).with_context(of_rig)?;
        let mut recorder = self.recorder(rig, parts)?;
        let is_real_time = self.is_real_time();
        let stop = Stop::new()?;
        let show = Show::open(bytes)?;
        let rounds = self.rounds(&show, is_real_time)?;
        let round_ticks = f64::from(show.duration_s()) * f64::from(parts.rate_hz);
        let is_over = |tally: &Tally| {
            rounds.is_some_and(|rounds| tally.ticks() as f64 >= f64::from(rounds) * round_ticks)
        };
        let mut live = SimulatedLive::new(&show);
        let mut bell = is_real_time.then(open_bell).flatten();
        let (mut director, mut tally) = (Director::with_preroll(self.preroll), Tally::new(parts));
        let mut pace = RealTime::begin();
        let ended = loop {
            let (is_stopped, is_cut) = bell.as_mut().map(Bell::asked).unwrap_or_default();
            if is_cut {
                director.cut();
            }
            let is_stopped = is_stopped || stop.times() > 0 || is_over(&tally);
            let ended = director.tick(&mut sim, is_stopped);
            tally.note(&sim);
            if let Some(recorder) = &mut recorder {
                recorder.note(&sim).with_context(of_record)?;
            }
            live.show(&sim, director.waits_for());
            if let Some(player) = &mut player {
                player.note(sim.runs().then(|| live.played_s(&sim)));
            }
            if ended.is_some() || stop.times() > 1 {
                break ended;
            }
            if is_real_time {
                pace.wait(sim.time_s());
            }
        };
        live.live.end();
        pace.report();
        if let Some(recorder) = recorder {
            recorder.end().with_context(of_record)?;
            note(format_args!("wrote {}", of_record()));
        }
        if tally.ticks() > 0 {
            print(&tally.table(&sim, director.raised()))?;
        } else if matches!(ended, Some(Ended::Stopped)) {
            note(format_args!("stopped before the show began"));
        }
        for warning in director.raised().and(FaultSet::WARNINGS).iter() {
            note(format_args!("{warning}: {}; to do: {}", warning.when(), warning.remedy()));
        }
        Ok(match ended {
            Some(Ended::Done | Ended::Stopped) => ExitCode::SUCCESS,
            Some(Ended::Faults(faults)) => {
                for fault in Fault::ALL.into_iter().filter(|fault| faults.contains(*fault)) {
                    let named = sim.named(fault);
                    note(format_args!("{named}: {}; to do: {}", fault.when(), fault.remedy()));
                }
                ExitCode::from(1)
            }
            Some(Ended::Refused(why @ Refused::RegisterDiffers(differs))) => {
                let name = &parts.servos[usize::from(differs.servo)].own.name;
                bail!("the controller refused (servo {} is `{name}`): {why}", differs.servo)
            }
            Some(Ended::Refused(why @ Refused::Overload(overload))) => {
                let (Overload::Servo { dof, .. } | Overload::Supply { dof, .. }) = overload;
                let name = &parts.names[usize::from(dof)];
                bail!("the controller refused (joint {dof} is `{name}`): {why}")
            }
            Some(Ended::Preroll(needed_ms)) => bail!(
                "--preroll: expected at least {:.2} s, which the way to the first pose takes",
                1e-3 * f64::from(needed_ms)
            ),
            Some(Ended::Refused(why)) => bail!("the controller refused: {why}"),
            None => {
                note(format_args!(
                    "ended at once: torque was left on at {} servos",
                    sim.servos_on()
                ));
                ExitCode::from(1)
            }
        })
    }

    fn recorder(&self, rig: &LoadedRig, parts: &RigParts) -> anyhow::Result<Option<Recorder>> {
        let begin = |path: &OutputPath| {
            let rig = toml_file::write(&rig.description);
            let varied = self.varied();
            let notes = [("show", Some(&self.show)), ("plant", varied.as_ref())];
            let notes: Vec<(&str, &str)> = notes
                .iter()
                .filter_map(|(key, note)| Some((*key, note.as_ref()?.as_str())))
                .collect();
            let recorder = Recorder::new(path, (parts, parts.rate_hz.into()), &rig, &notes);
            recorder.with_context(|| path.display().to_string())
        };
        self.record.as_ref().map(begin).transpose()
    }
}
