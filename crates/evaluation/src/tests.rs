use serde_json::Value;

use sinew_core::StateInputError;
use sinew_core::control::ControlLaw;
use sinew_core::state_error::RateTerm;
use sinew_core::tracker::{DesiredVelocity, GainsName, InputError, SettingError, StepError};
use sinew_figure::fixture::moving;
use sinew_figure::plant::{PlantKind, Pose};
use sinew_figure::{Dimensions, FigureMotion, Root};

use super::together::{Job, track_together};
use super::*;

fn motions() -> Vec<FigureMotion> {
    vec![moving("one", 80), moving("two", 50)]
}

fn evaluation() -> Evaluation {
    evaluate(&motions(), &Protocol::default(), |_| ()).unwrap()
}

/// Returns all poses of a run on a figure of 1.1 times the clip's dimensions.
fn trace(setup: Setup) -> Vec<Pose> {
    beginning(setup, None)
}

fn beginning(setup: Setup, seconds: Option<f64>) -> Vec<Pose> {
    let setup = Setup { dimensions: Dimensions::uniform(1.1), ..setup };
    let mut poses = Vec::new();
    let motion = moving("clip", 120);
    let run = Run::new(&motion, &setup, seconds, 0).unwrap();
    run.track(|step| poses.extend_from_slice(step.measured)).unwrap();
    poses
}

fn with_method(method: MethodName) -> Setup {
    Protocol::default().setup_of(1.0, method)
}

/// Returns the poses of the first steps with an altered setup. Only the first steps: not every alteration allows
/// the figure to track for long.
fn altered(alter: impl FnOnce(&mut Setup)) -> Vec<Pose> {
    let mut setup = with_method(MethodName::World);
    alter(&mut setup);
    beginning(setup, Some(0.08))
}

#[test]
fn linear_compensation_without_weight_is_world() {
    let mut without = with_method(MethodName::LinearCompensation);
    without.controller.beta = 0.0;
    let world = trace(with_method(MethodName::World));
    assert!(trace(without) == world);
    assert!(trace(with_method(MethodName::Local)) != world, "the motion tells the methods apart");
}

#[test]
fn a_reference_frame_may_be_any_body() {
    let seen_from = |name: &str| {
        let mut setup = with_method(MethodName::Accumulated);
        setup.controller.reference = BodyName(name.to_owned());
        trace(setup)
    };
    assert!(seen_from("pelvis") == trace(with_method(MethodName::Egocentric)));
    assert!(seen_from("head") == trace(with_method(MethodName::World)), "it has no descendants");
    assert!(seen_from("thorax") != seen_from("pelvis"));
}

/// Tracks motions together, up to eight at once, and each alone, and compares errors and failures. `shares` tells
/// whether the trackers must take their ticks together.
fn compare_together_and_alone(motions: &[FigureMotion], setup: &Setup, shares: bool) {
    let jobs: Vec<Job<'_>> =
        (0..).zip(motions).map(|(stream, motion)| Job { motion, stream, setup }).collect();
    let add = |_: &Job<'_>, errors: &mut Errors, step: Step<'_>| {
        assert_eq!(step.tracker.is_none(), shares, "{:?}", setup.differences());
        errors.add_step(&step);
    };
    let together = track_together(&jobs, None, add, |_| ());
    for (job, together) in jobs.iter().zip(together) {
        let alone = Run::new(job.motion, setup, None, job.stream).and_then(Run::measure);
        let alone = alone.map(|(errors, _)| errors);
        assert_eq!(alone, together, "{} {:?}", job.motion.name(), setup.differences());
    }
}

#[test]
fn runs_have_the_same_bits_together_and_alone() {
    // The runs end one after the other.
    let motions: Vec<FigureMotion> =
        (14..21).map(|frames| moving(&format!("{frames} frames"), frames)).collect();
    for method in MethodName::PAPER {
        let compare = |alter: &dyn Fn(&mut Setup), shares| {
            let mut setup = Protocol::default().setup_of(1.1, method);
            setup.plant.kind = PlantKind::Articulated;
            alter(&mut setup);
            compare_together_and_alone(&motions, &setup, shares);
        };
        compare(&|_| (), true);
        compare(&|setup| setup.disturbance.torque_limit_nm = 60.0, true);
        compare(&|setup| setup.disturbance.sensor_noise_rad = 1e-3, true);
        compare(&|setup| setup.disturbance.masses = 0.15, true);
        compare(&|setup| setup.controller.rate_term = RateTerm::AsPrinted, true);
        let compensates = method == MethodName::LinearCompensation;
        compare(&|setup| setup.controller.beta = 0.7, !compensates);
        compare(&|setup| setup.controller.desired_velocity = DesiredVelocity::Joints, false);
        compare(&|setup| setup.controller.law = ControlLaw::ProportionalDerivative, false);
        compare(&|setup| setup.disturbance.supply_nm = 300.0, false);
    }
}

#[test]
fn a_refused_reading_has_the_same_error_together_and_alone() {
    // The noise is so large that the core refuses some readings, and the gains so small that the figure is not lost.
    let mut setup = Setup::default();
    setup.plant.kind = PlantKind::Articulated;
    setup.controller.kp = 1e-12;
    setup.disturbance.sensor_noise_m = 4e5;
    let motions: Vec<FigureMotion> = (0..8).map(|_| moving("clip", 30)).collect();
    compare_together_and_alone(&motions, &setup, true);
    let alone = |stream| Run::new(&motions[0], &setup, None, stream).and_then(Run::measure);
    let is_refused = |stream: &u64| {
        let source = StepError::Measured(InputError::Pose(StateInputError::NonFinite));
        alone(*stream).is_err_and(
            |error| matches!(error, RunError::State { frame: 1.., source: found } if found == source),
        )
    };
    assert!((0..8).filter(is_refused).count() > 4);
}

#[test]
fn every_disturbance_disturbs() {
    let undisturbed = altered(|_| ());
    for (name, disturbed) in [
        ("masses", altered(|setup| setup.disturbance.masses = 0.15)),
        ("rotations", altered(|setup| setup.disturbance.sensor_noise_rad = 1e-3)),
        ("positions", altered(|setup| setup.disturbance.sensor_noise_m = 1e-3)),
        ("limits", altered(|setup| setup.disturbance.torque_limit_nm = 50.0)),
        ("latency", altered(|setup| setup.disturbance.latency_steps = 1)),
    ] {
        assert!(disturbed != undisturbed, "{name}");
    }
    let masses = |seed| {
        altered(|setup| {
            setup.disturbance = Disturbance { masses: 0.15, seed, ..Disturbance::default() };
        })
    };
    assert!(masses(1) == masses(1) && masses(1) != masses(2));
}

#[test]
fn a_fixed_root_stays_and_the_clips_with_it() {
    let mut setup = with_method(MethodName::World);
    setup.root = Root::Fixed;
    let motion = moving("clip", 120);
    let mut errors = Errors::default();
    let run = Run::new(&motion, &setup, None, 0).unwrap();
    run.track(|step| {
        let start = motion.root_position_m[0];
        assert_eq!(step.desired[0].position_m, start);
        // The engine does not move a fixed body at all.
        assert_eq!(step.measured[0].position_m, start);
        errors.add_step(&step);
    })
    .unwrap();
    assert!(errors.all.linear_mean_cm() < 0.5, "{}", errors.all.linear_mean_cm());
    assert!(errors.all.linear_mean_cm() > 0.0);
}

#[test]
fn desired_velocities_matter() {
    let of = |velocity| altered(|setup| setup.controller.desired_velocity = velocity);
    let kinds = [
        DesiredVelocity::Bodies,
        DesiredVelocity::Joints,
        DesiredVelocity::Backward,
        DesiredVelocity::Zero,
    ];
    for (i, a) in kinds.into_iter().enumerate() {
        for b in &kinds[i + 1..] {
            assert!(of(a) != of(*b), "{a:?} {b:?}");
        }
    }
}

#[test]
fn an_error_in_a_table_names_its_key_on_one_line() {
    let refused = |toml: &str| Setup::from_table(toml.parse().unwrap()).unwrap_err().to_string();
    let beta = refused("controller.beta = \"much\"");
    assert!(beta.starts_with("controller.beta: invalid type: string"), "{beta}");
    let unknown = refused("plant.steps = 1");
    assert!(unknown.starts_with("plant.steps: unknown field"), "{unknown}");
    for message in [beta, unknown, refused("plnt = 1")] {
        assert!(!message.contains('\n'), "{message}");
    }
}

#[test]
fn a_setup_survives_toml() {
    let mut setup = with_method(MethodName::LinearCompensation);
    setup.disturbance.torque_limit_nm = 40.0;
    setup.controller.rate_term = RateTerm::AsPrinted;
    let text = toml::to_string(&setup).unwrap();
    assert_eq!(Setup::parse(&text).unwrap(), setup);
    assert_eq!(setup.differences().len(), 3, "{:?}", setup.differences());
    // The default contains an infinity, which must survive too.
    assert_eq!(
        Setup::parse(&toml::to_string(&Setup::default()).unwrap()).unwrap(),
        Setup::default()
    );
}

#[test]
fn a_figure_of_equal_dimensions_follows_a_slow_motion() {
    let evaluation = evaluation();
    for result in &evaluation.figures[0].methods {
        // At less than 1 Hz and 0.3 rad, a method's lag is a small part of a degree.
        let [mean_deg, mean_cm, max_deg, max_cm] = result.total.all.figures();
        assert!(mean_deg < 0.5 && mean_cm < 0.5, "{}: {mean_deg} {mean_cm}", result.method);
        assert!(max_deg < 2.0 && max_cm < 2.0, "{}: {max_deg} {max_cm}", result.method);
    }
    // A tenth of a leg is about 8 cm: the larger figure cannot reach the clip's places.
    let larger = evaluation.figures[1].method(MethodName::Local).unwrap();
    assert!(larger.total.leaf.linear_mean_cm() > 3.0);
}

#[test]
fn counts_are_those_of_the_steps() {
    let evaluation = evaluation();
    let steps = (80 - 2) + (50 - 2);
    assert_eq!(evaluation.frames(), steps);
    let motions = motions();
    assert_eq!(count_all_steps(&motions, &Protocol::default()), steps * 2 * 3);
    for result in evaluation.figures.iter().flat_map(|figure| &figure.methods) {
        assert_eq!(result.total.all.n, steps as u64 * 18);
        assert_eq!(result.total.leaf.n, steps as u64 * 5);
    }
    let protocol = Protocol { seconds: Some(0.3), ..Protocol::default() };
    let short = evaluate(&motions, &protocol, |_| ()).unwrap();
    assert_eq!(short.frames(), 2 * (30 - 2));
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| report::json(&evaluation()))
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}

#[test]
fn the_json_has_the_promised_shape() {
    let evaluation = evaluation();
    let document: Value = serde_json::from_str(&report::json(&evaluation)).unwrap();
    assert_eq!(document["schema"], "sinew-evaluate/1");
    assert_eq!(document["frames"], 126);
    assert_eq!(document["plant"]["name"], "rapier");
    assert_eq!(document["clips"][1]["name"], "two");
    assert_eq!(document["clips"][1]["frames"], 48);
    assert_eq!(document["figures"][1]["scale"], 1.1);
    for figure in document["figures"].as_array().unwrap() {
        for method in MethodName::PAPER {
            for (joints, bodies) in [("all", 18), ("leaf", 5)] {
                let group = &figure["methods"][method.as_str()][joints];
                assert_eq!(group["n"], 126 * bodies);
                for key in
                    ["angular_mean_deg", "linear_mean_cm", "angular_max_deg", "linear_max_cm"]
                {
                    assert!(group[key].as_f64().unwrap() > 0.0, "{method} {joints} {key}");
                }
                assert_eq!(group.as_object().unwrap().len(), 5);
            }
        }
    }
}

#[test]
fn the_csv_has_a_row_for_everything() {
    let evaluation = evaluation();
    // Header; two figures, three methods, two groups. For clips, each of these rows exists for both clips.
    assert_eq!(report::result_csv(&evaluation).lines().count(), 1 + 12);
    assert_eq!(report::clips_csv(&evaluation).lines().count(), 1 + 24);
    assert!(
        report::clips_csv(&evaluation).starts_with("clip,scale,method,joints,n,angular_mean_deg")
    );
    assert!(report::result_csv(&evaluation).contains("\n1.1,linear_compensation,leaf,630,"));
}

#[test]
fn tables_stand_beside_the_papers_where_it_has_some() {
    let text = report::tables(&evaluation());
    for number in 1..=4 {
        assert!(text.contains(&format!("Table {number}. ")), "{number}");
    }
    assert!(text.contains(" (0.872) |") && text.contains(" (3.35) |"));
    let protocol =
        Protocol { scales: vec![0.9], methods: vec![MethodName::World], ..Protocol::default() };
    let text = report::tables(&evaluate(&motions(), &protocol, |_| ()).unwrap());
    assert!(!text.contains("paper") && !text.contains("Table"), "{text}");
    assert!(text.contains("not among the methods"));
}

#[test]
fn what_cannot_be_evaluated_is_refused_by_name() {
    let protocol = Protocol::default();
    assert_eq!(evaluate::<FigureMotion>(&[], &protocol, |_| ()), Err(EvaluateError::NoClips));
    let error = evaluate(&[moving("short", 2)], &protocol, |_| ()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "clip short, scale 1, method local: the clip has 2 frames; at least 3 are needed"
    );
}

#[test]
fn a_figure_that_is_lost_is_an_error_not_a_mean() {
    // The clip jumps 1 km away: no figure follows, and the run reports the frame of the loss.
    let mut motion = moving("leap", 60);
    for position in &mut motion.root_position_m[30..] {
        position.x += 1000.0;
    }
    let error = evaluate(&[motion], &Protocol::default(), |_| ()).unwrap_err();
    let EvaluateError::Run { clip, method, kind: RunError::Diverged { frame, .. }, .. } = error
    else {
        panic!("{error}");
    };
    assert_eq!((clip.as_str(), method), ("leap", MethodName::Local));
    // Forward differences see the jump in advance: the figure may be lost before it.
    assert!((29..=31).contains(&frame), "{frame}");
}

#[test]
fn gains_of_joints_are_for_pd_alone() {
    let text = "controller.gains = 'composite_inertia'";
    assert_eq!(Setup::parse(text), Err(SetupError::Controller(SettingError::GainsWithoutPd)));
    let with_pd = Setup::parse(&format!("{text}\ncontroller.law = 'pd'")).unwrap();
    assert_ne!(with_pd, Setup::default());
    let of = |gains| {
        altered(|setup| {
            setup.controller.law = ControlLaw::ProportionalDerivative;
            setup.controller.kp = 1.0;
            setup.controller.gains = gains;
        })
    };
    assert!(of(GainsName::CompositeInertia) != of(GainsName::ArticulatedInertia));
}

#[test]
fn implicit_gains_hold_a_figure_that_gains_as_given_throw_off() {
    let text = "controller.implicit = true\ncontroller.law = 'pd'";
    assert_eq!(
        Setup::parse(text),
        Err(SetupError::Controller(SettingError::ImplicitWithoutInertia))
    );
    let of = |implicit| {
        let mut protocol = Protocol::default();
        protocol.setup.plant.kind = PlantKind::Articulated;
        protocol.setup.controller.kp = 1e4;
        protocol.setup.controller.implicit = implicit;
        evaluate(&[moving("clip", 60)], &protocol, |_| ())
    };
    let error = of(false).unwrap_err();
    assert!(matches!(error, EvaluateError::Run { kind: RunError::Diverged { .. }, .. }), "{error}");
    assert!(of(true).is_ok());
}

#[test]
fn resolved_acceleration_weighs_positions_and_needs_inverse_dynamics() {
    for bad in ["position = -1.0", "position = 1e-9", "rotation_m = 0.0", "position = nan"] {
        assert!(Setup::parse(&format!("controller.resolved.{bad}")).is_err(), "{bad}");
    }
    let of = |position| {
        altered(|setup| {
            setup.controller.method = MethodName::ResolvedAcceleration;
            setup.controller.resolved.position = position;
        })
    };
    assert!(of(1.0) != of(0.0));
    let projected = |resolved| {
        altered(|setup| {
            setup.controller.method = MethodName::ManifoldProjection;
            setup.controller.projection.resolved = resolved;
        })
    };
    assert!(projected(true) != projected(false));
    let mut setup = Setup::default();
    setup.controller.method = MethodName::ResolvedAcceleration;
    setup.controller.law = ControlLaw::ProportionalDerivative;
    let motion = moving("clip", 10);
    let run = Run::new(&motion, &setup, None, 0);
    let error = run.and_then(|run| run.track(|_| ())).unwrap_err();
    assert!(error.to_string().contains("inverse dynamics"), "{error}");
}

#[test]
fn every_method_that_was_asked_for_is_in_the_json() {
    let protocol = Protocol {
        methods: MethodName::ALL.to_vec(),
        scales: vec![1.0],
        seconds: Some(0.1),
        ..Protocol::default()
    };
    let clip = sinew_figure::builtin::clips().remove(0);
    let (motion, _) =
        sinew_figure::pipeline::prepare(clip, &sinew_figure::pipeline::Settings::default())
            .unwrap();
    let evaluation = evaluate(&[motion], &protocol, |_| {}).unwrap();
    let json: serde_json::Value = serde_json::from_str(&report::json(&evaluation)).unwrap();
    let methods = json["figures"][0]["methods"].as_object().unwrap();
    assert_eq!(methods.len(), MethodName::ALL.len());
    for method in MethodName::ALL {
        assert!(methods[method.as_str()]["all"]["n"].is_u64(), "{method}");
    }
}

#[test]
fn nobody_is_asked_for_a_type() {
    for (text, told) in [
        ("controller.projection.sweeps = 300", "expected a whole number from 0 to 255"),
        ("controller.projection.sweeps = -1", "expected a whole number from 0 to 255"),
        ("plant.substeps = -1", "expected a whole number, 0 or more"),
        ("plant.substeps = 2.5", "expected a whole number, 0 or more"),
        ("controller.kp = 'much'", "expected a number"),
        ("plant = 3", "expected a table of keys"),
        ("controller.method = 3", "expected a name in quotes"),
        ("disturbance.seed = 'x'", "expected a whole number, 0 or more"),
    ] {
        let of_text = Setup::parse(text).unwrap_err().to_string();
        let of_table = Setup::from_table(text.parse().unwrap()).unwrap_err().to_string();
        assert!(of_text.ends_with(told) || of_text.ends_with(&format!("{told}\n")), "{of_text}");
        assert!(of_table.ends_with(told), "{of_table}");
    }
    let error = sinew_figure::Mapping::parse("units_m = 'x'").unwrap_err();
    assert!(!sinew_host_util::parse_message(&error).contains("f64"), "{error}");
}
