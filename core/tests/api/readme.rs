//! The README contains the first example unchanged.

#[test]
fn the_readme_has_the_example_as_it_is() {
    let (readme, example) =
        (include_str!("../../README.md"), include_str!("../../examples/first_torque.rs"));
    assert!(readme.contains(&format!("```rust\n{example}```\n")), "copy the example to README.md");
}
