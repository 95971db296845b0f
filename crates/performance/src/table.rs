//! Formats feasibility reports as text.

use std::fmt::Write as _;

use sinew_host_util::command;
use sinew_retarget::feasibility::{Excess, Fit, Limits, LoopedMotion, Report};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

use super::following::{LargestError, Prediction};
use super::left::JointLeft;
use super::{left, text};

/// Formats the largest demands of a motion on each joint, with the joint's limits and the excesses. Joints that do not
/// move and carry no load are left out. `strange`: the reason why the motion no longer looks like the performer's, if
/// so.
pub fn feasibility(
    mechanism: &Mechanism,
    limits: &Limits,
    report: &Report,
    rounding: [f64; 2],
    strange: Option<&str>,
) -> String {
    let header = [
        "joint", "from", "to", "range", "speed", "of", "accel.", "of", "torque", "of", "RMS",
        "for long",
    ];
    let mut table = command::table(header, 1..header.len());
    for (dof, peaks) in limits.dofs.iter().zip(&report.peaks) {
        if peaks.speed < 1e-6 && peaks.effort < 1e-9 {
            continue;
        }
        let [least, most] = dof.range;
        let shown = |x: f64| if dof.slides { 1000.0 * x } else { x.to_degrees() };
        let range = if least.is_finite() || most.is_finite() {
            format!("{:.0} {:.0}", shown(least), shown(most))
        } else {
            String::new()
        };
        let limit = |x: f64, digits: usize| {
            if x.is_finite() { format!("{x:.digits$}") } else { String::new() }
        };
        table.add_row([
            dof.name.clone(),
            format!("{:.1}", shown(peaks.least)),
            format!("{:.1}", shown(peaks.most)),
            range,
            format!("{:.2}", peaks.speed),
            limit(dof.speed, 2),
            format!("{:.1}", peaks.acceleration),
            limit(dof.acceleration, 1),
            format!("{:.3}", peaks.effort),
            limit(dof.effort, 3),
            format!("{:.3}", peaks.effort_rms),
            dof.heat.map(|heat| limit(heat.continuous, 3)).unwrap_or_default(),
        ]);
    }
    let mut out = format!(
        "Angles in deg, ways in mm; speeds in rad/s or m/s; accelerations per s; torques in N m, forces in N, with rotors \
         and friction.\n\n{table}\n\n"
    );
    let mut line =
        |text: std::fmt::Arguments<'_>| writeln!(out, "{text}").expect("a string takes everything");
    let name = |dof: usize| limits.dofs[dof].name.as_str();
    let mut told = 0;
    for (index, excess) in report.excesses.iter().enumerate() {
        let same = |other: &&Excess| (other.dof, other.kind) == (excess.dof, excess.kind);
        // One line for each joint and limit: the worst excess, and the number of excesses.
        if report.excesses[..index].iter().any(|other| same(&other)) {
            continue;
        }
        let all: Vec<_> = report.excesses.iter().filter(same).collect();
        let Some(worst) = all.iter().max_by(|a, b| {
            let share = |excess: &Excess| (excess.value - excess.limit).abs();
            share(a).total_cmp(&share(b))
        }) else {
            continue;
        };
        let seconds: f64 = all.iter().map(|excess| excess.to_s - excess.from_s).sum();
        line(format_args!(
            "EXCEEDED: {}: {} {} at {:.2} s; {} time(s), {seconds:.2} s in all",
            name(excess.dof),
            excess.kind.name(),
            text::excess(limits.dofs[excess.dof].slides, worst, rounding),
            worst.worst_s,
            all.len()
        ));
        told += 1;
    }
    if let Some(why) = strange {
        line(format_args!("NOBODY'S MOTION: {why}."));
    }
    if told == 0 && strange.is_some() {
        line(format_args!(
            "What is left of it is within all limits, in {:.2} s.",
            report.duration_s
        ));
    } else if told == 0 {
        line(format_args!("No limit is exceeded in {:.2} s.", report.duration_s));
    }
    if let Some(unknown) = text::unknown(mechanism, limits, report) {
        line(format_args!("{unknown}"));
    }
    line(format_args!("Not looked at: collisions, balance, cables."));
    out
}

/// Describes the changes by a fit. `left`: remaining share of each joint's motion.
pub(super) fn fitted(limits: &Limits, fit: &Fit, given_s: f64, left: &[JointLeft]) -> String {
    let mut out = String::new();
    let mut line =
        |text: std::fmt::Arguments<'_>| writeln!(out, "{text}").expect("a string takes everything");
    let slides = |joint: &str| limits.dofs.iter().any(|dof| dof.slides && dof.name == joint);
    for (joint, change) in &fit.clamped {
        let Some(change) = text::visible_change(slides(joint), *change) else { continue };
        line(format_args!("brought back into its range: {joint}, by up to {change}"));
    }
    for smoothed in &fit.smoothed {
        let change = text::visible_change(slides(&smoothed.joint), smoothed.change);
        let Some(change) = change else { continue };
        line(format_args!(
            "smoothed: {}, over {:.0} ms, changed by up to {change}",
            smoothed.joint,
            1000.0 * smoothed.width_s
        ));
    }
    for lowered in &fit.lowered {
        line(format_args!(
            "drawn towards home: {}, down to {:.0} % of its way at {:.2} s: gravity or heat would exceed what the \
             drive gives",
            lowered.joint,
            100.0 * lowered.share,
            lowered.at_s
        ));
    }
    for (joint, change) in &fit.lightened {
        let change = text::change(slides(joint), *change);
        line(format_args!(
            "home itself is too heavy: in place of it a pose with {joint} {change} from there"
        ));
    }
    let (slowest, at_s) = fit.slowest;
    if slowest < 1.0 {
        line(format_args!(
            "slowed down: {given_s:.2} s became {:.2} s; slowest {:.0} % at {at_s:.2} s",
            fit.motion.duration_s(),
            100.0 * slowest
        ));
    }
    if fit.settings.keep_time {
        out += &left::lines(left);
    }
    if out.is_empty() {
        let is_as_given = fit.smoothed.is_empty() && fit.clamped.is_empty();
        out.push_str(if is_as_given {
            "nothing had to be changed\n"
        } else {
            "changed by less than 0.001° and 0.001 mm\n"
        });
    }
    out
}

/// Describes the predicted following errors of a show.
pub(super) fn following(limits: &Limits, predicted: &Prediction) -> String {
    let LargestError { dof, error, at_s } = predicted.largest;
    let slides = limits.dofs[dof].slides;
    let shown = |x: f64| text::change(slides, x);
    let most = shown(predicted.limit.most_rad.into());
    let name = &limits.dofs[dof].name;
    let at =
        at_s.map_or_else(|| " by the bound of its servos".to_owned(), |s| format!(" at {s:.2} s"));
    let stopped = predicted.stopped.as_ref();
    let stopped =
        stopped.map_or_else(String::new, |why| format!("; the simulated rig stopped: {why}"));
    format!(
        "Following error by position, predicted: at most {}, {name}{at}; {most} for {} s ends a show{stopped}.\n",
        shown(error),
        predicted.limit.time_s
    )
}

/// Describes the changes that made a loop.
pub fn led(mechanism: &Mechanism, looped: &LoopedMotion) -> String {
    let (body, change) = looped.most;
    let link = &mechanism.bodies[body];
    let change = text::change(matches!(link.joint, JointModel::Prismatic(_)), change);
    format!(
        "loop: the last {:.2} s of the clip are led to where it begins; changed the most: {}, by {change}\n",
        looped.blend_s, link.joint_name
    )
}
