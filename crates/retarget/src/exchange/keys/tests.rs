use proptest::prelude::*;
use sinew_rig::Mechanism;
use sinew_rig::new::{arm, face};

use super::*;
use crate::exchange::table;

fn of_face(text: &str) -> Result<KeyedMotion, KeyError> {
    read(&face().mechanism().unwrap(), text, None)
}

/// Returns the values of a joint in deg.
fn joint(keyed: &KeyedMotion, name: &str) -> Vec<f64> {
    let mechanism = face().mechanism().unwrap();
    let place = columns(&mechanism).iter().position(|column| column.name == name).unwrap();
    keyed.motion.rows.iter().map(|q| q[place].to_degrees()).collect()
}

fn home(mechanism: &Mechanism, name: &str) -> f64 {
    let link = mechanism.bodies.iter().find(|link| link.joint_name == name).unwrap();
    link.home[0].to_degrees()
}

fn refused(text: &str, parts: &[&str]) {
    let told = of_face(text).unwrap_err().to_string();
    assert!(parts.iter().all(|part| told.contains(part)), "{told}");
}

#[test]
fn uneven_keys_keep_their_times() {
    let text = "jaw_deg;time;eye_turn_left_rad\n0;1,5;0\n-20;1,73;0,1\n-5;4;\n0;5,001;0,2\n";
    let keyed = of_face(text).unwrap();
    assert_eq!((keyed.start_s, keyed.keys), (1.5, Some(4)));
    // A show's rate is whole, so the last key is held for less than a sample.
    assert!((keyed.motion.duration_s() - 3.51).abs() < 1e-9, "{}", keyed.motion.duration_s());
    let jaw = joint(&keyed, "jaw");
    assert!(
        (jaw[0]).abs() < 1e-9 && (jaw[23] + 20.0).abs() < 1e-9 && (jaw[250] + 5.0).abs() < 1e-9
    );
    assert!(jaw.iter().all(|deg| (-20.0 - 1e-9..=1e-9).contains(deg)));
    // An empty field is no key: the eye goes on to its next one.
    let eye = joint(&keyed, "eye_turn_left");
    assert!(eye[24..350].windows(2).all(|pair| pair[1] > pair[0]), "{eye:?}");
    // A joint without a column stays at home.
    let mechanism = face().mechanism().unwrap();
    let lid = joint(&keyed, "lid_upper_left");
    assert!(lid.iter().all(|deg| (deg - home(&mechanism, "lid_upper_left")).abs() < 1e-9));
}

#[test]
fn delimiters_and_units_do_not_change_a_motion() {
    let comma = of_face("time,jaw_deg,brow_left_deg\n0,0,1\n0.3,-18,2\n1,0,0.5\n").unwrap();
    for other in [
        "time_ms\tjaw_rad\tbrow_left_deg\n0\t0\t1\n300\t-0.3141592653589793\t2\n1000\t0\t0.5\n",
        "Time;brow_left_deg;jaw_deg\r\n0;1;0\r\n0,3;2;-18\r\n1;0,5;0\r\n;;\r\n",
        "\u{feff}brow_left_deg,jaw_deg,time_s\n1,0,0\n2,-18,0.3\n0.5,0,1\n",
    ] {
        let other = of_face(other).unwrap();
        for (a, b) in comma.motion.rows.iter().flatten().zip(other.motion.rows.iter().flatten()) {
            assert!((a - b).abs() < 1e-12);
        }
        assert_eq!(comma.motion.rows.len(), other.motion.rows.len());
    }
}

#[test]
fn easings_of_rows_and_of_columns() {
    let text = |easing: &str| format!("time,jaw_deg,easing\n0,0,{easing}\n1,-20,linear\n2,0,\n");
    let at = |easing: &str, row: usize| joint(&of_face(&text(easing)).unwrap(), "jaw")[row];
    assert!((at("linear", 25) + 5.0).abs() < 1e-9);
    assert!((at("ease in", 50) + 5.0).abs() < 1e-9);
    assert!((at("Ease-Out", 50) + 15.0).abs() < 1e-9);
    assert!((at("both", 50) + 10.0).abs() < 1e-9 && (at("ease_both", 25) + 3.125).abs() < 1e-9);
    // A jaw of 400 deg/s and 9000 deg/s² needs 0.10 s for its step, which ends at the next key.
    assert!(at("step", 75).abs() < 1e-9 && (at("step", 100) + 20.0).abs() < 1e-9);
    let step = joint(&of_face(&text("step")).unwrap(), "jaw");
    assert!(step.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= 3.0));
    // A row below the header is for each joint.
    let text = "time,jaw_deg,brow_left_deg\neasing,linear,in\n0,0,0\n1,-20,10\n";
    let keyed = of_face(text).unwrap();
    assert!((joint(&keyed, "jaw")[25] + 5.0).abs() < 1e-9);
    assert!((joint(&keyed, "brow_left")[50] - 2.5).abs() < 1e-9);
}

#[test]
fn a_recording_is_taken_row_by_row() {
    for rig in [arm(3).unwrap(), face()] {
        let mechanism = rig.mechanism().unwrap();
        let row = |row: u32| mechanism.home().iter().map(|q| q + 0.001 * f64::from(row)).collect();
        let motion = RigMotion { dt_s: 0.02, rows: (0..40).map(row).collect() };
        let keyed = read(&mechanism, &table::csv(&mechanism, &motion, 2.0), None).unwrap();
        assert_eq!((keyed.keys, keyed.jumps.len()), (None, 0));
        assert!((keyed.motion.dt_s - 0.02).abs() < 1e-9 && (keyed.start_s - 2.0).abs() < 1e-9);
        for (a, b) in motion.rows.iter().flatten().zip(keyed.motion.rows.iter().flatten()) {
            assert!((a - b).abs() < 1e-9);
        }
    }
}

#[test]
fn rounded_times_of_a_recording_get_a_rate_of_shows() {
    let row = |k: i32| format!("{:.3},{}\n", f64::from(k) / 30.0 * 1.02, -k);
    let rows = (0..31).map(row).collect::<Vec<_>>().concat();
    let keyed = of_face(&format!("time,jaw_deg\n{rows}")).unwrap();
    assert_eq!(keyed.keys, None);
    assert!((keyed.motion.dt_s - 0.01).abs() < 1e-12 && keyed.motion.rows.len() == 103);
}

#[test]
fn a_jump_names_joint_and_speed() {
    let keyed =
        of_face("time,jaw_deg,brow_left_deg\n0,0,0\n0.5,-10,5\n0.52,-20,5\n2,0,0\n").unwrap();
    let [jump] = &keyed.jumps[..] else { panic!("{:?}", keyed.jumps) };
    let told = jump.to_string();
    for part in ["line 4", "jaw", "10.0000 deg", "0.020 s", "500.0000 deg/s", "400.0000 deg/s"] {
        assert!(told.contains(part), "{told}");
    }
}

#[test]
fn errors_name_line_column_joint_and_unit() {
    refused("time,jaw\n0,0\n1,1\n", &["column 2", "no unit", "`jaw_deg` or `jaw_rad`"]);
    refused("time,jaw_mm\n0,0\n1,1\n", &["`jaw` is not measured in mm", "`jaw_deg` or `jaw_rad`"]);
    refused("time,jow_deg\n0,0\n1,1\n", &["column 2", "jow_deg", "jaw_deg"]);
    refused("t,jaw_deg\n0,0\n1,1\n", &["column 1", "`t`", "`time`"]);
    refused("jaw_deg\n0\n1\n", &["no column `time`"]);
    refused("time,jaw_deg,jaw_rad\n0,0,0\n1,1,1\n", &["two columns"]);
    refused("time,jaw_deg\n0,0\n1,x\n", &["line 3", "`jaw_deg`", "joint `jaw` in deg", "`x`"]);
    refused("time,jaw_deg\n0,0\nx,1\n", &["line 3", "the time", "`x`"]);
    refused("time,jaw_deg\n0,0\n1,1\n1,2\n", &["line 4", "after 1 s"]);
    refused("time,jaw_deg,easing\n0,0,slow\n1,1,\n", &["line 2", "`slow`", "ease both"]);
    refused("time,jaw_deg\n0,\n1,\n", &["`jaw_deg`", "no value"]);
    refused("time,jaw_deg\n0,0\n", &["at least 2 rows"]);
    refused("", &["no column `time`"]);
    refused("time,jaw_deg\n0,0\n90000,1\n", &["7200 s"]);
}

#[test]
fn units_may_be_given_for_a_header_without_them() {
    let (mechanism, text) = (face().mechanism().unwrap(), "time,jaw\n0,0\n0.3,-10\n1,0\n");
    let least = |units| {
        let motion = read(&mechanism, text, Some(units)).map(|keyed| joint(&keyed, "jaw"));
        motion.unwrap().into_iter().fold(0.0, f64::min)
    };
    assert!((least(HeaderUnits::Degrees) + 10.0).abs() < 1e-9);
    assert!((least(HeaderUnits::Si) + 10_f64.to_degrees()).abs() < 1e-9);
}

#[test]
fn a_ball_joint_needs_its_four_columns() {
    let mut rig = arm(2).unwrap();
    let joint = &mut rig.joints[1];
    joint.kind = sinew_rig::description::JointType::Spherical;
    joint.range_rad.clear();
    joint.axis = None;
    joint.home_rad = None;
    let name = joint.name.clone();
    rig.drives.clear();
    rig.servos.clear();
    let mechanism = rig.mechanism().unwrap();
    let text = format!(
        "time,{name}.x,{name}.y,{name}.z,{name}.w\n0,0,0,0,1\n0.5,-0.7071068,0,0,-0.7071068\n3,1,0,0,0\n"
    );
    let keyed = read(&mechanism, &text, None).unwrap();
    assert!(keyed.motion.check(&mechanism).is_ok());
    let part = read(&mechanism, &format!("time,{name}.x\n0,0\n1,0\n"), None).unwrap_err();
    assert!(part.to_string().contains("four columns"), "{part}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Motions pass through every key, and stay between the two keys around them.
    #[test]
    fn curves_stay_between_their_keys(
        steps in proptest::collection::vec((1_u32..200, -25.0..0.0_f64, 0_usize..6), 2..12)
    ) {
        let easings = ["step", "linear", "in", "out", "both", "cubic"];
        let (mut text, mut row, mut keys) = ("time,jaw_deg,easing\n".to_owned(), 0, Vec::new());
        for (step, deg, easing) in steps {
            text.extend([format!("{},{deg},{}\n", f64::from(row) / 100.0, easings[easing])]);
            keys.push((row as usize, deg));
            row += step;
        }
        let jaw = joint(&of_face(&text).unwrap(), "jaw");
        // Many near keys get a rate above 100 Hz.
        let rate = (jaw.len() - 1) as f64 / keys[keys.len() - 1].0 as f64;
        for pair in keys.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let [first, last] = [from, to].map(|(row, _)| row as f64 * rate);
            let [least, most] = [from.1.min(to.1) - 1e-9, from.1.max(to.1) + 1e-9];
            for (row, deg) in jaw.iter().enumerate() {
                if (first + 1e-6..=last - 1e-6).contains(&(row as f64)) {
                    prop_assert!((least..=most).contains(deg), "{text}: {row}: {deg}");
                }
                if (row as f64 - last).abs() < 1e-6 {
                    prop_assert!((deg - to.1).abs() < 1e-6, "{text}: {row}: {deg}");
                }
            }
        }
    }
}
