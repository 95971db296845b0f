//! Imports the robots of `SINEW_DATA`, and files that made other readers fail.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use sinew_rig::Mechanism;
use sinew_rig::import::{self, ImportError, Imported, Options};
use sinew_rig::mechanism::Link;

fn read(file: &str, options: &Options) -> Result<Imported, ImportError> {
    let data = std::env::var_os("SINEW_DATA").expect("SINEW_DATA names the folder of the data");
    let text = std::fs::read_to_string(PathBuf::from(data).join(file)).expect("the file");
    let read = if file.ends_with("mjcf.xml") { import::mjcf } else { import::urdf };
    read(&text, options)
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn robots_are_imported_by_name_and_with_notes() {
    let repair = Options { repair_inertia: true, ..Options::default() };
    let open = Options { open_loops: true, ..Options::default() };
    for (file, options, bodies, moving) in [
        ("urdf/poppy-humanoid/Poppy_Humanoid.urdf", &Options::default(), 26, 25),
        ("urdf/robotis-op3/robotis_op3.urdf", &Options::default(), 23, 20),
        ("urdf/open-duck-mini/open_duck_mini_v2.urdf", &Options::default(), 21, 16),
        ("urdf/open-duck-mini/open_duck_mini_v2.mjcf.xml", &Options::default(), 22, 16),
        ("urdf/reachy-mini/reachy_mini.urdf", &open, 45, 30),
        ("foreign/urdf/so100.urdf", &Options::default(), 7, 6),
        ("foreign/urdf/panda.urdf", &Options::default(), 13, 9),
        ("foreign/urdf/h1.urdf", &Options::default(), 58, 51),
        ("foreign/urdf/reachy.URDF", &Options::default(), 31, 21),
        ("foreign/urdf/allegro_left.urdf", &repair, 21, 16),
        ("foreign/urdf/anymal_c.urdf", &repair, 78, 12),
        ("foreign/urdf/talos_reduced.urdf", &repair, 60, 32),
        ("deepmimic/humanoid.urdf", &Options::default(), 16, 12),
    ] {
        let imported = read(file, options).unwrap_or_else(|error| panic!("{file}:{error}"));
        println!("{file}");
        imported.notes.iter().for_each(|note| println!("  {note}"));
        assert_eq!(imported.description.bodies.len(), bodies, "{file}");
        let mechanism = imported.description.mechanism().unwrap_or_else(|e| panic!("{file}: {e}"));
        assert_eq!(mechanism.bodies.len(), moving + 1, "{file}");
        mechanism.tree::<64>().unwrap_or_else(|error| panic!("{file}: {error}"));
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn what_cannot_be_is_refused_in_words() {
    for (file, expected, found) in [
        ("foreign/urdf/allegro_left.urdf", "repair-inertia", "also refused: `link_10.0`"),
        ("foreign/urdf/anymal_c.urdf", "repair-inertia", "`depth_camera_rear_camera`"),
        ("foreign/urdf/unitree_a1.xacro", "xacro FILE", "`xacro:arg`"),
        ("urdf/reachy-mini/reachy_mini.urdf", "open-loops", "5 closed loops"),
    ] {
        let error = read(file, &Options::default()).expect_err(file);
        println!("{file}:{error}");
        assert!(error.expected.contains(expected) && error.found.contains(found), "{file}:{error}");
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn files_that_broke_readers_are_refused_at_once() {
    for (file, expected) in [
        ("attack/urdf_links20k.urdf", "one link that no joint moves"),
        ("attack/urdf_xmlns_nest.urdf", "256 name spaces"),
    ] {
        let start = Instant::now();
        let error = read(file, &Options::default()).expect_err(file);
        println!("{file}: {:?}", start.elapsed());
        assert!(error.expected.contains(expected), "{file}:{error}");
        // A refusal takes milliseconds; the limit of 10 s is for a busy machine.
        assert!(start.elapsed() < Duration::from_secs(10), "{file}: {:?}", start.elapsed());
    }
}

/// Returns the largest difference between the numbers that `of` selects in two mechanisms.
fn largest_difference(one: &Mechanism, other: &Mechanism, of: &dyn Fn(&Link) -> Vec<f64>) -> f64 {
    let pairs = one.bodies.iter().map(|link| {
        let named = other.bodies.iter().find(|other| other.joint_name == link.joint_name);
        (of(link), of(named.unwrap_or_else(|| panic!("no joint `{}`", link.joint_name))))
    });
    pairs.flat_map(|(a, b)| a.into_iter().zip(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// A selection of a link's numbers.
type Numbers<'a> = &'a dyn Fn(&Link) -> Vec<f64>;

/// Compares the two files of the Open Duck Mini, whose makers publish both formats. The files differ only in the points
/// asserted here.
#[test]
#[ignore = "needs SINEW_DATA"]
fn a_urdf_and_an_mjcf_of_one_robot_are_the_same_tree() {
    let mechanism = |file: &str| {
        let imported = read(file, &Options::default()).unwrap_or_else(|error| panic!("{error}"));
        imported.description.mechanism().expect("a mechanism")
    };
    let mut urdf = mechanism("urdf/open-duck-mini/open_duck_mini_v2.urdf");
    let mut mjcf = mechanism("urdf/open-duck-mini/open_duck_mini_v2.mjcf.xml");
    // In the MJCF the trunk is welded to a base that floats 0.22 m above the ground.
    assert!((mjcf.bodies[0].position_m.y - 0.22).abs() < 1e-12);
    for base in [&mut urdf.bodies[0], &mut mjcf.bodies[0]] {
        base.joint_name = "base".to_owned();
        base.position_m.y = 0.0;
    }
    let parents = |rig: &Mechanism| -> Vec<(String, String)> {
        let name = |link: &Link| {
            link.parent.map_or(String::new(), |parent| rig.bodies[parent].joint_name.clone())
        };
        let mut parents: Vec<_> =
            rig.bodies.iter().map(|link| (link.joint_name.clone(), name(link))).collect();
        parents.sort();
        parents
    };
    assert_eq!(parents(&urdf), parents(&mjcf));
    // The MJCF has six digits of every number, the URDF has all digits. Limits and rotors differ between the files.
    let vector = |numbers: &[f64]| numbers.to_vec();
    let digits: [(&str, f64, Numbers<'_>); 6] = [
        ("position, m", 5e-7, &|link| vector(&link.position_m.to_array())),
        ("rotation", 2e-6, &|link| vector(&glam::DMat3::from_quat(link.rotation).to_cols_array())),
        ("mass, kg", 1e-6, &|link| vec![link.mass_kg]),
        ("center, m", 5e-7, &|link| vector(&link.center_of_mass_m.to_array())),
        ("inertia, kg m2", 1e-8, &|link| vector(&link.inertia_kg_m2.to_cols_array())),
        ("range, rad", 5e-6, &|link| link.ranges.concat()),
    ];
    for (what, limit, of) in digits {
        let difference = largest_difference(&urdf, &mjcf, of);
        println!("{what}: {difference:.1e}");
        assert!(difference < limit, "{what}: {difference:e}");
    }
    let of_all = |rig: &Mechanism, of: &dyn Fn(&Link) -> f64| -> Vec<f64> {
        rig.bodies.iter().skip(1).map(of).collect()
    };
    assert_eq!(of_all(&urdf, &|link| link.effort), [1.0; 16]);
    assert_eq!(of_all(&mjcf, &|link| link.effort), [3.69; 16]);
    assert_eq!(of_all(&urdf, &|link| link.rotor_inertia), [0.0; 16]);
    assert_eq!(of_all(&mjcf, &|link| link.rotor_inertia), [0.012; 16]);
}

/// Without its rods, the Stewart platform of Reachy Mini has only joints with a drive.
#[test]
#[ignore = "needs SINEW_DATA"]
fn a_parallel_platform_can_be_cut_off() {
    let cut = (1..=6).map(|rod| format!("passive_{rod}_x")).collect();
    let options = Options { cut, ..Options::default() };
    let imported = read("urdf/reachy-mini/reachy_mini.urdf", &options).expect("a rig");
    let mechanism = imported.description.mechanism().expect("a mechanism");
    let joints: Vec<&str> =
        mechanism.bodies.iter().skip(1).map(|link| link.joint_name.as_str()).collect();
    let horns =
        ["yaw_body", "stewart_1", "stewart_2", "stewart_3", "stewart_4", "stewart_5", "stewart_6"];
    assert_eq!(joints, horns);
    assert!(imported.notes.iter().any(|note| note.items.iter().any(|item| item == "xl_330")));
}
