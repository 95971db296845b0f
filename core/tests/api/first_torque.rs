//! The first torque takes at most 10 lines and 5 imported names.

const EXAMPLE: &str = include_str!("../../examples/first_torque.rs");

#[test]
fn the_first_torque_takes_ten_lines_at_most() {
    let (_, body) = EXAMPLE.split_once("fn main()").expect("a program");
    let body = body.trim_end().strip_suffix('}').expect("nothing behind main");
    let lines = body.lines().skip(1).count();
    assert!(lines <= 10, "{lines} lines in the body of main");
}

#[test]
fn it_imports_five_names_at_most() {
    let (imports, _) = EXAMPLE.split_once("fn main()").expect("a program");
    let names: Vec<&str> = imports
        .split(|c: char| c != ':' && c != '_' && !c.is_alphanumeric())
        .filter(|word| word.rsplit(':').next().is_some_and(|n| n.starts_with(char::is_uppercase)))
        .collect();
    assert!(names.len() <= 5 && !imports.contains('*'), "{names:?}");
    assert!(names.contains(&"glam::Vec3"), "names are found: {names:?}");
}
