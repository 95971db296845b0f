//! Teaching by hand on a simulated arm: how near the result is to the hand's path, and how long a floating arm stays.

use sinew_rig::new::arm;
use sinew_servo_sim::device::MEMORY_LEN;

use sinew_performance::play::{Memory, Options, RigParts, SimulatedRig};
use sinew_performance::teach::{
    GuideTrajectory, Mode, TeachRecording, TeachResult, TeachSession, TeachSessionError,
    compare_with_guide,
};
use sinew_performance::{Baker, ShowMarks, ShowPlayback};
use sinew_retarget::feasibility::RigMotion;
use sinew_show::write::Settings;

const DEG: f64 = std::f64::consts::PI / 180.0;

/// Leads an arm with six joints. Its bodies have `masses` times the mass that its controller assumes, its servos
/// `friction` times the friction of their kind.
fn led(
    mode: Mode,
    let_go_s: f64,
    [masses, friction]: [f64; 2],
) -> Result<(TeachRecording, GuideTrajectory), TeachSessionError> {
    let rig = arm(6).unwrap();
    let mechanism = rig.mechanism().unwrap();
    let mut parts = RigParts::new(&rig, &mechanism, Options::default()).unwrap();
    for part in &mut parts.servos {
        part.own.kind.friction_nm *= friction;
        part.own.kind.stribeck_nm *= friction;
        part.own.kind.load_friction *= friction;
    }
    let mut heavy = mechanism.clone();
    for body in &mut heavy.bodies {
        body.mass_kg *= masses;
        body.inertia_kg_m2 *= masses;
    }
    let plant = parts.plant(&rig, &heavy).unwrap();
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let mut sim = SimulatedRig::new(&parts, None, &mut memories, plant).unwrap();
    let guide = GuideTrajectory::built_in(&mechanism).unwrap();
    let taken =
        TeachSession::new(&mut sim, &mechanism, guide.clone()).run(mode, let_go_s, |_, _| {})?;
    Ok((taken, guide))
}

fn most(numbers: &[f64]) -> f64 {
    numbers.iter().copied().fold(0.0, f64::max)
}

/// The show that a board plays must be within one degree of the hand.
#[test]
fn what_is_taught_is_within_a_degree_of_the_hand() {
    let mechanism = arm(6).unwrap().mechanism().unwrap();
    for mode in [Mode::Limp, Mode::Float] {
        let (TeachRecording { dt_s, rows, .. }, guide) = led(mode, 0.0, [1.0, 1.0]).unwrap();
        let measured = RigMotion { dt_s, rows };
        let taught = TeachResult::new(&mechanism, &measured, 6.0, 100.0).unwrap();
        let baker = Baker { mechanism: &mechanism, rig: 0, settings: Settings::default() };
        let baked = baker.bake(&taught.motion, &ShowMarks::default()).unwrap();
        let played = ShowPlayback::new(&baked.written.bytes).unwrap().motion(taught.motion.dt_s);
        let ([mean, most], ..) =
            compare_with_guide(&mechanism, &played, &guide, taught.cut_s[0]).unwrap();
        println!("{mode:?}: {:.3} deg, {:.3} at most", mean / DEG, most / DEG);
        assert!(most < 1.0 * DEG, "{mode:?}: {}", most / DEG);
        // There is a second of rest at both ends; motion below half a degree counts as rest, too.
        let [before, behind] = taught.cut_s;
        assert!((0.7..2.0).contains(&before) && (0.7..2.0).contains(&behind), "{:?}", taught.cut_s);
    }
}

/// A floating arm must stay within 2 degrees if its masses are a tenth larger or smaller than in the model. Friction
/// holds it; without friction it falls.
#[test]
fn a_floating_arm_stays_where_it_is_left() {
    for masses in [0.9, 1.0, 1.1] {
        let (taken, _) = led(Mode::Float, 30.0, [masses, 1.0]).unwrap();
        println!("masses {masses}: {:.2} deg", most(&taken.drift) / DEG);
        assert!(most(&taken.drift) < 2.0 * DEG, "{masses}: {}", most(&taken.drift) / DEG);
    }
}

/// Shows that friction is needed: the same arm without friction moves.
#[test]
fn without_friction_a_wrong_mass_moves_it() {
    let (taken, _) = led(Mode::Float, 2.0, [1.1, 0.0]).unwrap();
    println!("without friction: {:.2} deg in 2 s", most(&taken.drift) / DEG);
    assert!(most(&taken.drift) > 2.0 * DEG);
}
