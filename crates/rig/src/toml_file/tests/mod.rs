mod page;
mod random;

use proptest::prelude::*;

use super::{read, write};
use crate::description::{Description, Joint};

const ARM: &str = r#"name = "arm"

[[body]]
name = "base"

[[body]]
name = "link"
mass_kg = 0.5
box_m = [0.1, 0.2, 0.1]

[[joint]]
name = "hinge"
parent = "base"
child = "link"
axis = [0, 0, 1]
range_deg = [-90, 90]

[[drive]]
joints = ["hinge"]
servos = ["left"]

[[servo]]
name = "left"
model = "XL330-M288-T"
id = 3
"#;

/// Replaces some text of [`ARM`], and asserts the start of the error.
#[track_caller]
fn refused(cases: &[(&str, &str, &str)]) {
    assert!(read(ARM).is_ok());
    for (right, wrong, told) in cases {
        assert_eq!(ARM.matches(right).count(), 1, "{right}");
        let error = read(&ARM.replace(right, wrong)).expect_err(wrong).to_string();
        assert!(error.starts_with(told), "{error}\n{told}");
    }
}

#[test]
fn what_is_no_toml_is_refused_by_line() {
    refused(&[
        (
            "[[body]]\nname = \"base\"",
            "[[body]\nname = \"base\"",
            "line 3, column 8: this is not TOML: ",
        ),
        ("mass_kg = 0.5", "mass_kg = ", "line 8, column 11: this is not TOML: "),
        (
            "mass_kg = 0.5",
            "mass_kg = 0.5\nmass_kg = 1",
            "line 9, column 1: this is not TOML: duplicate key",
        ),
    ]);
}

#[test]
fn unknown_keys_are_refused_with_the_nearest() {
    refused(&[
        (
            "range_deg",
            "range_dg",
            "line 16, column 1: joint[0].range_dg: expected the key range_deg, found an unknown one",
        ),
        (
            "parent =",
            "parrent =",
            "line 13, column 1: joint[0].parrent: expected the key parent, found an unknown one",
        ),
        (
            "mass_kg = 0.5",
            "colour = 1",
            "line 8, column 1: body[1].colour: expected one of the keys name, mass_kg, center_of_mass_m, box_m, \
             inertia_kg_m2, shape, found an unknown one",
        ),
        (
            "servos = [\"left\"]",
            "servos = [\"left\"]\nmatrix = { rows = [[1]], offset_m = [0] }",
            "line 21, column 26: drive[0].matrix.offset_m: expected the key offset_deg, found an unknown one",
        ),
    ]);
}

#[test]
fn wrong_types_are_refused_with_the_right_one() {
    refused(&[
        (
            "mass_kg = 0.5",
            "mass_kg = \"half\"",
            "line 8, column 11: body[1].mass_kg: expected a number, found the text \"half\"",
        ),
        (
            "[0, 0, 1]",
            "[0, 1]",
            "line 15, column 8: joint[0].axis: expected a list of 3 numbers, found a list of 2",
        ),
        (
            "[0, 0, 1]",
            "[0, true, 1]",
            "line 15, column 12: joint[0].axis[1]: expected a number, found true",
        ),
        (
            "[-90, 90]",
            "90",
            "line 16, column 13: joint[0].range_deg: expected [least, most], found the number 90",
        ),
        (
            "name = \"hinge\"",
            "name = 3",
            "line 12, column 8: joint[0].name: expected a text in quotes, found the number 3",
        ),
        (
            "axis = [0, 0, 1]",
            "type = \"rotary\"",
            "line 15, column 8: joint[0].type: expected \"fixed\", \"revolute\", \"prismatic\", \"universal\", \
             \"spherical\" or \"free\", found the text \"rotary\"",
        ),
        (
            "id = 3",
            "id = 300",
            "line 25, column 6: servo[0].id: expected a whole number from 0 to 255, found the number 300",
        ),
        (
            "id = 3",
            "id = 3\nchannel = 3",
            "line 26, column 11: servo[0].channel: expected one of the keys id, channel, found id as well",
        ),
        (
            "name = \"arm\"",
            "name = \"arm\"\nservo_model = 3",
            "line 2, column 15: servo_model: expected tables that begin with [[servo_model]], found the number 3",
        ),
        (
            "name = \"arm\"",
            "name = \"arm\"\nmount = 1979-05-27",
            "line 2, column 9: mount: expected a table of keys, found a date",
        ),
        (
            "id = 3",
            "id = 3\n[[servo_model]]\nname = \"own\"\ngear_stiffness_nm_rad = 14.8",
            "line 28, column 25: servo_model[0].gear_stiffness_nm_rad: expected { value = .., source = \"who states it\" }, \
             found the number 14.8",
        ),
    ]);
}

#[test]
fn what_is_missing_is_asked_for_at_its_table() {
    refused(&[
        (
            "id = 3\n",
            "",
            "line 22, column 1: servo[0].id of servo \"left\": expected a whole number from 0 to 255, found nothing",
        ),
        (
            "child = \"link\"\n",
            "",
            "line 11, column 1: joint[0].child of joint \"hinge\": expected a text in quotes, found nothing",
        ),
        (
            "parent = \"base\"\n",
            "",
            "line 11, column 1: joint[0].parent of joint \"hinge\", which moves body \"link\": expected a text in \
             quotes, found nothing",
        ),
        (
            "name = \"hinge\"\n",
            "",
            "line 11, column 1: joint[0].name of the joint that moves body \"link\": expected a text in quotes, found \
             nothing",
        ),
    ]);
    assert_eq!(
        read("").unwrap_err().to_string(),
        "line 1, column 1: name: expected a text in quotes, found nothing"
    );
}

#[test]
fn what_cannot_be_is_refused_where_it_stands() {
    refused(&[
        (
            "[0, 0, 1]",
            "[0, 0, 2]",
            "line 15, column 8: joint[0].axis of joint \"hinge\": expected length 1 (within 0.001), such as \
             [0, 0, 1], found [0, 0, 2] of length 2",
        ),
        (
            "child = \"link\"",
            "child = \"lnk\"",
            "line 14, column 9: joint[0].child of joint \"hinge\": expected the name of a body, such as \"link\", \
             found \"lnk\", which no body has",
        ),
        (
            "mass_kg = 0.5",
            "mass_kg = nan",
            "line 8, column 11: body[1].mass_kg of body \"link\": expected a number from 0 to 1.0e6 kg, found nan kg",
        ),
        (
            "axis = [0, 0, 1]\n",
            "",
            "line 11, column 1: joint[0].axis of joint \"hinge\": expected the axis as a vector of length 1, such as \
             [0, 0, 1], found nothing",
        ),
        (
            "mass_kg = 0.5",
            "mass_kg = -1e999",
            "line 8, column 11: body[1].mass_kg of body \"link\"",
        ),
    ]);
}

#[test]
fn columns_are_counted_in_characters() {
    let text = "name = \"é\"\nbody = [{ name = \"ééé\", mass = 1 }]";
    let error = read(text).unwrap_err();
    assert_eq!((error.line, error.column), (2, 25), "{error}");
}

#[test]
fn a_written_rig_is_short() {
    let text = write(&read(ARM).unwrap());
    let (header, rest) = text.split_once('\n').unwrap();
    assert!(header.starts_with("# A rig for Sinew"));
    assert_eq!(rest, ARM, "as it was written by hand");
}

#[test]
fn joints_of_a_slide_have_their_drive_in_metres() {
    let sliding = ARM
        .replace(
            "axis = [0, 0, 1]\nrange_deg = [-90, 90]",
            "type = \"prismatic\"\naxis = [0, 0, 1]",
        )
        .replace(
            "servos = [\"left\"]",
            "servos = [\"left\"]\ncurve = { points_deg_m = [[0, 0], [180, 0.02]] }",
        );
    let rig = read(&sliding).unwrap();
    let crate::description::DriveKind::Curve { points } = &rig.drives[0].kind else {
        panic!("{:?}", rig.drives)
    };
    assert_eq!(points[..], [[0.0, 0.0], [std::f64::consts::PI, 0.02]]);
    assert!(write(&rig).contains("points_deg_m = [[0, 0], [180, 0.02]]"));
}

proptest! {
    #[test]
    fn what_is_written_is_read(seed: u64) {
        let rig = random::rig(seed);
        let mechanism = rig.mechanism().unwrap();
        prop_assert!(mechanism.tree::<16>().is_ok(), "what passes the check passes in f32");
        let text = write(&rig);
        let again = read(&text);
        prop_assert_eq!(again.as_ref(), Ok(&rig), "{}", text);
        prop_assert_eq!(write(&rig), text);
    }

    /// Tolerance: half a step of the twelfth digit is 5e-10 degrees below 1000 degrees, and the conversion adds
    /// 1e-15.
    #[test]
    fn angles_of_many_digits_are_kept(angle in -17.0..17.0_f64) {
        let mut rig = read(ARM).unwrap();
        rig.joints[0] = Joint { range_rad: vec![[-20.0, 20.0]], home_rad: Some(angle), ..rig.joints[0].clone() };
        let again = read(&write(&rig)).unwrap();
        let off_deg = (again.joints[0].home_rad.unwrap() - angle).to_degrees();
        prop_assert!(off_deg.abs() < 6e-10, "{}", off_deg);
    }

    #[test]
    fn no_text_makes_the_reader_panic(
        seed: u64,
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0..4_u8, any::<char>(), ".{0,3}"), 1..8),
    ) {
        let mut text = write(&random::rig(seed));
        for (place, edit, character, word) in edits {
            let places: Vec<usize> = text.char_indices().map(|(place, _)| place).collect();
            if places.is_empty() { break }
            let at = *place.get(&places);
            match edit {
                0 => text.insert(at, character),
                1 => text.insert_str(at, &word),
                2 => { text.remove(at); }
                _ => text.truncate(at),
            }
        }
        // An accepted text has passed the check; an error has a valid position.
        match read(&text) {
            Ok(rig) => prop_assert_eq!(rig.check(), Ok(())),
            Err(error) => prop_assert!(error.line <= text.split('\n').count() && error.column > 0, "{}", error),
        }
    }
}

#[test]
fn a_description_that_cannot_be_is_written_and_refused() {
    let mut rig: Description = read(ARM).unwrap();
    rig.bodies[1].mass_kg = f64::NAN;
    let error = read(&write(&rig)).unwrap_err();
    assert!(error.to_string().contains("found nan kg"), "{error}");
}
