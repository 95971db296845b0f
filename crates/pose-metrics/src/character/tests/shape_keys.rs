use std::path::Path;

use super::*;

const FOLDER: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/fuzz/corpus/readers/shape_keys");

fn text(name: &str) -> String {
    std::fs::read_to_string(Path::new(FOLDER).join(name)).unwrap()
}

fn read(text: &str) -> Result<ShapeKeys, String> {
    gltf::parse_shape_keys(text.as_bytes(), Path::new("")).map_err(|refusal| refusal.to_string())
}

#[test]
fn weights_are_those_of_the_keys_and_of_the_way_between_them() {
    let keys = read(&text("linear.gltf")).unwrap();
    assert_eq!((keys.animations, keys.animation.as_deref()), (1, Some("talk")));
    assert_eq!(keys.names, ["jawOpen", "eyeBlink_L"]);
    assert_eq!((keys.rows.len(), keys.times_s.len()), (101, 101));
    let near = |row: usize, expected: [f64; 2]| {
        let found = &keys.rows[row];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    };
    near(0, [0.0, 0.0]);
    near(25, [0.5, 0.2]);
    near(50, [1.0, 0.1]);
    near(75, [0.5, 0.05]);
    near(100, [0.0, 0.0]);
    // With zero tangents, the weight is half at half of the time.
    let cubic = read(&text("cubic.gltf")).unwrap();
    assert!((cubic.rows[75][0] - 0.5).abs() < 1e-6 && cubic.rows[60][0] > 0.85);
}

#[test]
fn files_without_animated_shape_keys_are_refused() {
    let good = text("linear.gltf");
    for (from, to, words) in [
        (
            "\"weights\"\n     }",
            "\"translation\"\n     }",
            "an animation of shape keys (`weights`), found none",
        ),
        ("targetNames", "names", "expected `targetNames` in its extras with 2 names"),
        (
            "\"eyeBlink_L\"",
            "\"eyeBlink_L\", \"more\"",
            "with 2 names, as Blender writes them, found 3",
        ),
        ("\"count\": 8", "\"count\": 7", "its output: expected 2 weights of 4 keys, found 7"),
    ] {
        assert!(good.contains(from), "{from}");
        let refused = read(&good.replace(from, to)).unwrap_err();
        assert!(refused.contains(words), "{refused}");
    }
    let refused = read("HIERARCHY").unwrap_err();
    assert!(refused.contains("glTF 2.0"), "{refused}");
}
