//! `sinew play --target sim`: plays a show on simulated servos, with the controller in this program.

use std::process::ExitCode;

use anyhow::{Context as _, bail};
use sinew_firmware::supervisor::{Fault, FaultSet, Overload, Refused};
use sinew_host_util::command::{note, print};
use sinew_performance::play::{Director, Ended, Memory, Recorder, RigParts, SimulatedRig, Tally};
use sinew_performance::rig::LoadedRig;
use sinew_rig::toml_file;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_show::Show;

use super::Args;
use super::live::Live;
use super::real_time::RealTime;
use crate::cli::output::OutputPath;
use crate::cli::sound::Player;
use crate::cli::stop::Stop;

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
        let mut live = Live::new(&show);
        let (mut director, mut tally) = (Director::with_preroll(self.preroll), Tally::new(parts));
        let mut pace = RealTime::begin();
        let ended = loop {
            let ended = director.tick(&mut sim, stop.times() > 0 || is_over(&tally));
            tally.note(&sim);
            if let Some(recorder) = &mut recorder {
                recorder.note(&sim).with_context(of_record)?;
            }
            live.show(&sim, director.waits_for());
            if let Some(player) = &mut player {
                player.note(sim.permission().runs);
            }
            if ended.is_some() || stop.times() > 1 {
                break ended;
            }
            if is_real_time {
                pace.wait(sim.time_s());
            }
        };
        live.end();
        pace.report();
        if let Some(recorder) = recorder {
            recorder.end().with_context(of_record)?;
            note(format_args!("wrote {}", of_record()));
        }
        // If the rig was never armed, only the reason is printed.
        if tally.ticks() > 0 || !matches!(ended, Some(Ended::Refused(_))) {
            print(&tally.table(&sim, director.raised()))?;
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
            let recorder = Recorder::new(path, parts, &rig, &notes);
            recorder.with_context(|| path.display().to_string())
        };
        self.record.as_ref().map(begin).transpose()
    }
}
