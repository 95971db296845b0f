//! `sinew record`: a rig is led by hand, and the measured positions become a motion.

mod board;

use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use sinew_firmware::supervisor::State;
use sinew_host_util::command::{note, print};
use sinew_host_util::output;
use sinew_performance::play::{Memory, Options, RigParts, ServoChoice, SimulatedRig, put_servos};
use sinew_performance::rig::LoadedRig;
use sinew_performance::teach::{
    GuideTrajectory, Mode, TeachRecording, TeachResult, TeachSession, compare_with_guide,
};
use sinew_performance::{
    MotionChoices, RetargetedClip, RigPerformance, ShowChoices, ShowPlayback, feasibility, rig_hash,
};
use sinew_retarget::exchange::table;
use sinew_retarget::feasibility::RigMotion;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::variation::Variation;
use sinew_show::write::Settings as ShowSettings;

use super::board::SilenceArg;
use super::clips::{rate, seconds};
use super::guide::read_guide;
use super::performance::{ON_STAND, PerformanceArgs};
use super::stack::with_stack;
use super::target::Target;
use crate::cli::output::OutputPath;

/// Record a motion by leading the rig by hand: as a show, or as a CSV of its joint coordinates.
///
/// By default torque is off: hold the rig. With --float the rig carries its own weight by its model, and stays about
/// where you leave it; for this every servo must accept an effort (be driven by current or voltage). The command
/// filters the measured motion with a low-pass filter, and removes the rest at its beginning and end; it reports both.
///
/// In the simulator a scripted hand leads the rig, by a spring and a damper at each joint. At the end the command
/// reports how far the result is from the hand's path. With a board you lead the rig, from the line `lead it` until
/// Ctrl-C. Then, if torque is on, the rig is lowered; torque is off before the command ends.
///
/// `sinew bake FILE.csv --rig RIG --fit` brings a CSV within the rig's limits.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Rig that you lead: `sim`, simulated servos as in `sinew play`; or the rig of the controller board at a serial
    /// port, such as /dev/ttyACM0, or at the USB port where a board answers (`auto`).
    #[arg(long, value_name = "sim|PORT", default_value_t = Target::Sim)]
    target: Target,

    /// End after S seconds of leading, on a board. Default: at Ctrl-C.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    seconds: Option<f64>,

    #[command(flatten)]
    silence: SilenceArg,

    /// The rig: rig.toml, URDF or MJCF.
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,

    /// Lead with torque off. Default.
    #[arg(long, conflicts_with = "float")]
    limp: bool,

    /// Arm the rig where it is, and let it carry its own weight.
    #[arg(long)]
    float: bool,

    /// Path of the scripted hand: a CSV of joint coordinates, as `sinew clip export` writes it. Default: all joints
    /// together, from home and back.
    #[arg(long, value_name = "FILE.csv")]
    guide: Option<PathBuf>,

    /// Add a servo of this kind to each joint that has none, as `sinew play` does. May be repeated.
    #[arg(long, value_name = "[JOINT=]KIND")]
    servo: Vec<ServoChoice>,

    /// Cutoff of the low-pass filter, in Hz. 0: no filter.
    #[arg(long, value_name = "HZ", default_value_t = 6.0, value_parser = cutoff, allow_negative_numbers = true)]
    cutoff_hz: f64,

    /// Rate of the rows in the output, in Hz.
    #[arg(long, value_name = "HZ", default_value_t = 100.0, value_parser = rate, allow_negative_numbers = true)]
    rate_hz: f64,

    /// Fit a show within all limits of the rig: smooth it, slow it down, or draw it towards the home pose where
    /// needed.
    #[arg(long)]
    fit: bool,

    /// Let the scripted hand release the rig at the end of its path for S seconds, and report how far the rig sinks.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    release_test_s: Option<f64>,

    /// Factor on the masses and inertias of the simulated bodies. The controller still uses the values in the rig's
    /// file. Default: 1.
    #[arg(long, value_name = "FACTOR", value_parser = factor, allow_negative_numbers = true)]
    mass_scale: Option<f64>,

    /// Factor on the dry friction of the simulated servos. Default: 1.
    #[arg(long, value_name = "FACTOR", value_parser = factor, allow_negative_numbers = true)]
    friction_scale: Option<f64>,

    /// File to write: `.show` or `.csv`. May be repeated.
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Vec<OutputPath>,
}

/// The measured motion; with a scripted hand also its path, and the drift of each coordinate after the release.
type Led = (RigMotion, Option<(GuideTrajectory, Vec<f64>)>);

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    args.check()?;
    for path in &args.output {
        if !["show", "csv"].contains(&kind(path)) {
            bail!("{}: expected a name that ends in .show or .csv", path.display());
        }
    }
    let mut rig = PerformanceArgs::default().rig(&args.rig, ON_STAND)?;
    if put_servos(&mut rig.description, &args.servo)? > 0 {
        rig.mechanism = rig.description.mechanism()?;
    }
    let ((measured, simulated), ended) = with_stack(|| match &args.target {
        Target::Port(port) => args.led_at(port, &rig),
        Target::Sim | Target::Nucleo => args.led(&rig).map(|led| (led, Ok(()))),
    })?;
    let written = ended.and_then(|()| args.write(&rig, &measured, simulated));
    if written.is_err() && args.target != Target::Sim {
        args.keep(&rig, &measured);
    }
    print(&written?)?;
    Ok(())
}

impl Args {
    /// Writes the motion of a person as it was measured, beside the first output file, because nobody can repeat it
    /// exactly.
    fn keep(&self, rig: &LoadedRig, measured: &RigMotion) {
        let Some(path) = self.output.first() else { return };
        let kept = path.with_extension("led.csv");
        match output::write(&kept, table::csv(&rig.mechanism, measured, 0.0)) {
            Ok(()) => note(format_args!(
                "{}: the motion as measured until then: {:.2} s",
                kept.display(),
                measured.duration_s()
            )),
            Err(why) => note(format_args!("the measured motion is lost: {why:#}")),
        }
    }

    /// Writes all output files, and returns a description of them.
    fn write(
        &self,
        rig: &LoadedRig,
        measured: &RigMotion,
        simulated: Option<(GuideTrajectory, Vec<f64>)>,
    ) -> anyhow::Result<String> {
        let taught = TeachResult::new(&rig.mechanism, measured, self.cutoff_hz, self.rate_hz)?;
        let [before_s, behind_s] = taught.cut_s;
        let mut text = format!(
            "led for {:.2} s; cut {before_s:.2} s of rest before and {behind_s:.2} s after: {:.2} s remain\n",
            measured.duration_s(),
            taught.motion.duration_s(),
        );
        if self.cutoff_hz > 0.0 {
            text.extend([format!(
                "low-pass at {} Hz: it moved a joint by {} at most\n",
                self.cutoff_hz,
                shown(taught.smoothed)
            )]);
        }
        for path in &self.output {
            let is_show = kind(path) == "show";
            if is_show {
                let (of_show, motion) = self.show(rig, &taught.motion, path)?;
                text += &of_show;
                if let Some((guide, _)) = &simulated {
                    text += &self.off(rig, &motion, guide, before_s, "the show")?;
                }
            } else {
                output::write(path, table::csv(&rig.mechanism, &taught.motion, 0.0))?;
                if let Some((guide, _)) = &simulated {
                    text += &self.off(rig, &taught.motion, guide, before_s, "the table")?;
                }
            }
            note(format_args!("wrote {}", path.display()));
        }
        if let Some((let_go_s, (_, drift))) = self.release_test_s.zip(simulated) {
            let (at, most) = drift.iter().enumerate().fold((0, 0.0), |most, (at, drift)| {
                if *drift > most.1 { (at, *drift) } else { most }
            });
            let joint = coordinate(rig, at);
            let line = format!(
                "let go for {let_go_s} s: it drifted by {} at most ({joint})\n",
                shown(most)
            );
            text.push_str(&line);
        }
        Ok(text)
    }

    /// Refuses options that have no effect on the target.
    pub(super) fn check(&self) -> anyhow::Result<()> {
        let of_sim = [
            (self.guide.is_some(), "--guide"),
            (self.release_test_s.is_some(), "--release-test-s"),
            (self.mass_scale.is_some(), "--mass-scale"),
            (self.friction_scale.is_some(), "--friction-scale"),
        ];
        match &self.target {
            Target::Sim => {
                let of_board = [
                    (self.seconds.is_some(), "--seconds"),
                    (self.silence.is_given(), "--silence-s"),
                ];
                self.target.refuse(&of_board, "a board")
            }
            Target::Port(_) => self.target.refuse(&of_sim, "`--target sim`"),
            Target::Nucleo => bail!("--target nucleo: expected `sim` or a serial port"),
        }
    }

    fn mode(&self) -> Mode {
        if self.float && !self.limp { Mode::Float } else { Mode::Limp }
    }

    fn parts(&self, rig: &LoadedRig) -> anyhow::Result<RigParts> {
        let parts = RigParts::new(&rig.description, &rig.mechanism, Options::default());
        parts.with_context(|| self.rig.display().to_string())
    }

    /// Returns the motion that a controller measured while a person led its rig.
    fn led_at(&self, port: &Path, rig: &LoadedRig) -> anyhow::Result<(Led, anyhow::Result<()>)> {
        let parts = self.parts(rig)?;
        let (motion, ended) =
            board::led(port, self.silence.time(), rig, &parts, self.mode(), self.seconds)?;
        Ok(((motion, None), ended))
    }

    /// Returns the motion that was measured while the scripted hand led.
    fn led(&self, rig: &LoadedRig) -> anyhow::Result<Led> {
        let of_rig = || self.rig.display().to_string();
        let guide = read_guide(rig, self.guide.as_deref())?;
        let mut parts = self.parts(rig)?;
        parts.vary(Variation {
            masses: self.mass_scale.unwrap_or(1.0),
            friction: self.friction_scale.unwrap_or(1.0),
            ..Variation::default()
        });
        let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
        let plant = parts.plant(&rig.description, &rig.mechanism).with_context(of_rig)?;
        let mut sim = SimulatedRig::new(&parts, None, &mut memories, plant).with_context(of_rig)?;
        let mut last = None;
        let tell = |time_s: f64, state: State| {
            if last.replace(state) != Some(state) {
                note(format_args!("{time_s:7.2} s  {state}"));
            }
        };
        let let_go_s = self.release_test_s.unwrap_or_default();
        let mut session = TeachSession::new(&mut sim, &rig.mechanism, guide.clone());
        let TeachRecording { dt_s, rows, drift } = session.run(self.mode(), let_go_s, tell)?;
        Ok((RigMotion { dt_s, rows }, Some((guide, drift))))
    }

    /// Writes a show of a motion. Returns its description, and the motion of the show.
    fn show(
        &self,
        rig: &LoadedRig,
        motion: &RigMotion,
        path: &Path,
    ) -> anyhow::Result<(String, RigMotion)> {
        let name = path.display().to_string();
        let choices = MotionChoices { fit: self.fit, ..MotionChoices::default() };
        let clip = RetargetedClip::own(motion.clone());
        let mut performance = RigPerformance::new(rig, &name, 0.0, clip, choices)?;
        let (mechanism, settings) = (&rig.mechanism, ShowSettings::default());
        let (rig_crc, why_not) = rig_hash(&rig.description, mechanism);
        if let Some(line) = why_not {
            note(format_args!("note: {line}"));
        }
        let choices = ShowChoices { rig_crc, settings, ..ShowChoices::default() };
        let (baked, report) = performance.bake(mechanism, &choices)?;
        output::write(path, &baked.written.bytes)?;
        let rounding = [settings.angle_rad, settings.length_m];
        let mut text = format!(
            "{name}: {:.2} s, {} bytes\n{}",
            baked.duration_s,
            baked.written.bytes.len(),
            feasibility(mechanism, &performance.limits, &report, rounding, None)
        );
        if let Some(line) = performance.headline(mechanism) {
            text.extend([line, "\n".to_owned()]);
        }
        if let Some(done) = performance.fit_summary(mechanism) {
            text.extend([format!("\nFitted: {done}")]);
        }
        let played = ShowPlayback::new(&baked.written.bytes)?.motion(motion.dt_s);
        Ok((text, played))
    }

    /// Describes how far a motion is from the hand's path.
    fn off(
        &self,
        rig: &LoadedRig,
        motion: &RigMotion,
        guide: &GuideTrajectory,
        begin_s: f64,
        what: &str,
    ) -> anyhow::Result<String> {
        if self.fit && what == "the show" {
            // A slowed motion has other times than the path.
            return Ok(String::new());
        }
        let ([mean, most], at, time_s) =
            compare_with_guide(&rig.mechanism, motion, guide, begin_s)?;
        Ok(format!(
            "{what} against the hand's path: mean error {}, largest {} ({} at {time_s:.2} s)\n",
            shown(mean),
            shown(most),
            coordinate(rig, at)
        ))
    }
}

/// Formats an angle in degrees.
fn shown(radians: f64) -> String {
    format!("{:.2} deg", radians.to_degrees())
}

/// Returns the name of a coordinate's joint.
fn coordinate(rig: &LoadedRig, at: usize) -> &str {
    let ranges = rig.mechanism.coordinate_ranges();
    let mut joints = rig.mechanism.bodies.iter().zip(ranges);
    joints.find(|(_, range)| range.contains(&at)).map_or("", |(link, _)| &link.joint_name)
}

fn kind(path: &Path) -> &str {
    path.extension().and_then(|extension| extension.to_str()).unwrap_or_default()
}

fn cutoff(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(hz) if (0.0..=1000.0).contains(&hz) => Ok(hz),
        _ => Err("expected a number of Hz from 0 to 1000".into()),
    }
}

fn factor(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(factor) if (0.0..=10.0).contains(&factor) => Ok(factor),
        _ => Err("expected a factor from 0 to 10".into()),
    }
}
