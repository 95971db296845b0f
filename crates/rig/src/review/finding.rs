//! Findings of a review: wrong or doubtful values, in words.

use super::results::{DofReview, Finding, LoopReview, Review, Severity, Voltage};
use crate::description::ServoModel;
use crate::mechanism::{GRAVITY_M_S2, JointModel, Mechanism};

/// Factor on the torque that lifts the whole rig at its full reach. A torque limit above this product is regarded
/// as a placeholder.
const PLACEHOLDER: f64 = 10.0;

/// Smallest plausible mass of a body, kg: 1 mg.
const LIGHTEST_KG: f64 = 1e-6;

/// Factor from g mm², the unit of many CAD programs, to kg m².
pub const KG_M2_PER_G_MM2: f64 = 1e-9;

/// Plausible densities of a rig's parts, kg/m³: from a hollow foam body to osmium.
const DENSITIES: [f64; 2] = [10.0, 22_590.0];

/// Largest step at the far end of the rig that is regarded as invisible, mm.
const VISIBLE_MM: f64 = 1.0;

/// Supply voltage above which a servo is damaged, as a multiple of the voltage in its data; makers permit up to
/// 1.23.
const HIGHEST_VOLTAGE: f64 = 1.25;

/// Supply voltage below which a servo is noticeably weaker and slower, as a multiple of the voltage in its data.
const LOWEST_VOLTAGE: f64 = 0.8;

/// Speed that no servo reaches without load, rad/s.
const FASTEST_RAD_S: f64 = 50.0;

pub(super) fn findings(mechanism: &Mechanism, review: &Review) -> Vec<Finding> {
    let mut found = Vec::new();
    let mut add = |severity, about: String, text: String| {
        found.push(Finding { severity, about, text });
    };
    let lift_nm = review.mass_kg * GRAVITY_M_S2.length() * super::reach_m(mechanism, 0);
    for dof in &review.by_dof {
        for (severity, text) in of_dof(dof, lift_nm) {
            add(severity, format!("joint {}", dof.name), text);
        }
    }
    of_bodies(mechanism, &mut add);
    of_friction(mechanism, &mut add);
    of_voltages(&review.voltages, &mut add);
    if review.mass_kg <= 0.0 {
        let text = "none are given: loads and currents are not known, whatever the table says";
        add(Severity::Note, "masses".to_owned(), text.to_owned());
    }
    of_servos(mechanism, review, &mut add);
    add(
        Severity::Note,
        "collisions".to_owned(),
        "not checked: bodies may hit each other within the ranges".to_owned(),
    );
    found.sort_by_key(|finding| finding.severity);
    found
}

/// Finds problems of one dof. `lift_nm` is the torque that lifts the whole rig at its full reach.
fn of_dof(dof: &DofReview, lift_nm: f64) -> Vec<(Severity, String)> {
    let mut found = Vec::new();
    let unit = if dof.slides { "N" } else { "N m" };
    let asked = dof.gravity_effort;
    if let Some(servo) = &dof.servo {
        let names = servo.servos.join(", ");
        if asked > servo.stall {
            found.push((
                Severity::Fault,
                format!(
                    "gravity asks for {asked:.3} {unit} in the worst pose, its servo {names} gives {:.3} {unit} at stall: it \
                     falls; take a stronger servo, a gear, or a spring",
                    servo.stall
                ),
            ));
        } else if asked > servo.continuous {
            found.push((
                Severity::Warning,
                format!(
                    "gravity asks for {asked:.3} {unit} in the worst pose, its servo {names} holds {:.3} {unit} for long: it \
                     overheats if it rests there",
                    servo.continuous
                ),
            ));
        }
        if let Some([least, most]) = servo.reached {
            let (unit, scale) =
                if dof.slides { ("mm", 1e3) } else { ("deg", 1.0_f64.to_degrees()) };
            found.push((
                Severity::Warning,
                format!(
                    "its servo {names} reaches only {:.1} to {:.1} {unit} of its range: a show that goes farther ends \
                     with a following error; give the joint this range, or the servo another gear, home or range",
                    least * scale,
                    most * scale
                ),
            ));
        }
        if let Some(speed) = dof.speed_limit
            && speed > servo.no_load_speed
        {
            found.push((
                Severity::Warning,
                format!(
                    "the limit of speed is {speed:.2}, but its servo {names} reaches {:.2} without load",
                    servo.no_load_speed
                ),
            ));
        }
    } else if let Some(limit) = dof.effort_limit {
        if asked > limit {
            found.push((
                Severity::Fault,
                format!("gravity asks for {asked:.3} {unit} in the worst pose, its limit is {limit:.3} {unit}"),
            ));
        } else if !dof.slides && lift_nm > 0.0 && limit > PLACEHOLDER * lift_nm {
            found.push((
                Severity::Note,
                format!(
                    "its limit of {limit} {unit} is {:.0} times what would lift the whole rig: a placeholder of the file?",
                    limit / lift_nm
                ),
            ));
        }
    }
    if let (Some(speed), false) = (dof.speed_limit, dof.slides)
        && speed > FASTEST_RAD_S
    {
        found.push((
            Severity::Note,
            format!("its limit of speed is {speed:.0} rad/s, which no servo reaches: a placeholder of the file?"),
        ));
    }
    found.extend(of_loop(dof));
    if dof.inertia_free <= 0.0 {
        found.push((Severity::Note, "it moves no mass: kinematic, without torque".to_owned()));
    }
    if let Some(step_mm) = dof.resolution_mm
        && step_mm > VISIBLE_MM
    {
        found.push((
            Severity::Warning,
            format!(
                "one step of its servo is up to {step_mm:.1} mm at {:.2} m: slow moves are seen as steps",
                dof.reach_m
            ),
        ));
    }
    found
}

/// Returns a finding if the dof's loop through its elastic gear oscillates, or would oscillate if the gear had half
/// its stiffness and twice its play.
fn of_loop(dof: &DofReview) -> Option<(Severity, String)> {
    let control = dof.control.as_ref()?;
    let LoopReview { resonance_hz, bandwidth_rad_s, bearable_rad_s, .. } = *control;
    let bearable_rad_s = bearable_rad_s?;
    let bears = if bearable_rad_s > 0.0 {
        format!("it tolerates {} rad/s", shown(bearable_rad_s, 0))
    } else {
        "it tolerates none".to_owned()
    };
    let observer = format!("an observer of {} rad/s", shown(bandwidth_rad_s, 0));
    let help = match (control.light_bears, control.voltage_bears) {
        (true, true) => "a stiffer gear, less load, or `--drive voltage`",
        (true, false) => "a stiffer gear, or less load",
        (false, true) => "a stiffer gear, or `--drive voltage`",
        (false, false) => "a stiffer gear",
    };
    Some(if control.nominal.margins.is_none() {
        let hz = shown(resonance_hz, 1);
        let shakes = format!(
            "by current it shakes: {observer} is too fast for its gear, which swings at {hz} Hz ({bears}); take {help}"
        );
        (Severity::Fault, shakes)
    } else {
        let shakes = format!(
            "by current it would shake with half its gear's stiffness and twice its play, by {observer} ({bears}); \
             take {help}"
        );
        (Severity::Warning, shakes)
    })
}

/// Returns a number of a joint's loop with `decimals` decimals, or in scientific notation if it is too small for
/// these.
pub fn shown(number: f64, decimals: usize) -> String {
    let step = libm::pow(0.1, decimals as f64);
    if number > 0.0 && number < step {
        format!("{number:.1e}")
    } else {
        format!("{number:.decimals$}")
    }
}

fn of_bodies(mechanism: &Mechanism, add: &mut impl FnMut(Severity, String, String)) {
    let size_m = super::reach_m(mechanism, 0);
    for link in &mechanism.bodies {
        let about = || format!("body {}", link.name);
        if link.mass_kg > 0.0 && link.mass_kg < LIGHTEST_KG {
            add(
                Severity::Note,
                about(),
                format!("its mass of {:e} kg looks like a placeholder", link.mass_kg),
            );
        }
        let gyration_m = if link.mass_kg > 0.0 {
            let trace = link.inertia_kg_m2.x_axis.x
                + link.inertia_kg_m2.y_axis.y
                + link.inertia_kg_m2.z_axis.z;
            libm::sqrt(0.5 * trace / link.mass_kg)
        } else {
            0.0
        };
        if gyration_m > size_m && size_m > 0.0 {
            let fits = fits_g_mm2(link.mass_kg, gyration_m, size_m);
            let hint = if fits {
                format!(": is it in g mm²? (`sinew rig import FILE --inertia-g-mm2 {}`)", link.name)
            } else {
                String::new()
            };
            add(
                Severity::Warning,
                about(),
                format!(
                    "its inertia is that of its mass {gyration_m:.3} m from its centre, more than the whole rig's \
                     {size_m:.3} m{hint}"
                ),
            );
        }
    }
}

/// Returns whether an inertia that is far too large in kg m² would be plausible in g mm²: its radius of gyration is
/// then not larger than the rig, and a ball with this radius of gyration has the density of a real material. A
/// placeholder seldom satisfies both conditions.
fn fits_g_mm2(mass_kg: f64, gyration_m: f64, size_m: f64) -> bool {
    let gyration_m = gyration_m * libm::sqrt(KG_M2_PER_G_MM2);
    // A ball of radius r has a squared radius of gyration of 3/5 r².
    let radius_m = gyration_m / libm::sqrt(0.6);
    let density = mass_kg / (4.0 / 3.0 * core::f64::consts::PI * libm::pow(radius_m, 3.0));
    let [least, most] = DENSITIES;
    gyration_m <= size_m && least <= density && density <= most
}

fn of_friction(mechanism: &Mechanism, add: &mut impl FnMut(Severity, String, String)) {
    for link in &mechanism.bodies {
        let speed = if link.speed.is_finite() { link.speed } else { 0.0 };
        let takes = link.friction + link.damping * speed;
        if takes > link.effort {
            add(
                Severity::Warning,
                format!("joint {}", link.joint_name),
                format!(
                    "friction takes {takes:.3} of the {:.3} that its drive gives, at its largest speed of {speed:.2}: \
                     it does not reach that speed",
                    link.effort
                ),
            );
        }
    }
}

fn of_voltages(voltages: &[Voltage], add: &mut impl FnMut(Severity, String, String)) {
    for Voltage { servos, model, supply_v, model_v } in voltages {
        let about = || format!("servos {}", servos.join(", "));
        let (share, kind) = (supply_v / model_v, ServoModel::with_article(model));
        if share > HIGHEST_VOLTAGE {
            let text =
                format!("{supply_v} V would damage {kind}, whose values are for {model_v} V");
            add(Severity::Fault, about(), text);
        } else if share < LOWEST_VOLTAGE {
            let text = format!(
                "values of {kind} are for {model_v} V: at {supply_v} V it has some {:.0} % of the torque and speed in the table",
                100.0 * share
            );
            add(Severity::Warning, about(), text);
        }
    }
}

fn of_servos(
    mechanism: &Mechanism,
    review: &Review,
    add: &mut impl FnMut(Severity, String, String),
) {
    if mechanism.bodies.first().is_some_and(|base| base.joint == JointModel::Free) {
        add(
            Severity::Note,
            "base".to_owned(),
            "a drive of six dofs moves it: nobody balances the rig".to_owned(),
        );
    }
    let Some(current) = review.current else {
        add(
            Severity::Note,
            "servos".to_owned(),
            "none are given: loads are compared with the file's own limits".to_owned(),
        );
        return;
    };
    let missing: Vec<&str> = review
        .by_dof
        .iter()
        .filter(|dof| dof.servo.is_none())
        .map(|dof| dof.name.as_str())
        .collect();
    if !missing.is_empty() {
        add(Severity::Fault, "servos".to_owned(), format!("none moves {}", missing.join(", ")));
    }
    if review.by_dof.iter().filter_map(|dof| dof.servo.as_ref()).any(|servo| servo.guessed) {
        add(
            Severity::Note,
            "servos".to_owned(),
            "some values of their kinds are guesses; docs/servos.md marks them".to_owned(),
        );
    }
    match current.supply_a {
        None => add(
            Severity::Note,
            "supply".to_owned(),
            format!(
                "not given; holding takes up to {:.1} A, all servos stalled {:.1} A",
                current.holding_a, current.stall_a
            ),
        ),
        Some(supply_a) if current.holding_a > supply_a => add(
            Severity::Fault,
            "supply".to_owned(),
            format!("it gives {supply_a:.1} A; holding takes up to {:.1} A", current.holding_a),
        ),
        Some(supply_a) if current.stall_a > supply_a => add(
            Severity::Warning,
            "supply".to_owned(),
            format!(
                "it gives {supply_a:.1} A; all servos stalled take {:.1} A: limit currents, or start joints one by one",
                current.stall_a
            ),
        ),
        Some(_) => {}
    }
}
