//! Checks the page `docs/link.md`: it must show the compact form of a rig, and the wiring stored after it, as the
//! code defines them.

use std::fmt::Write;

use serde_reflection::{
    ContainerFormat, Format, Named, Registry, Samples, Tracer, TracerConfig, VariantFormat,
};
use sinew_core::tracker::Settings as TrackerSettings;
use sinew_wiring::{BusLine, Servo, VERSION};

const PAGE: &str = include_str!("../../../docs/link.md");
/// Source of the crate that documents the compact form.
const RIG: &str = include_str!("../../../crates/rig/src/board/mod.rs");

/// All enumerations. If one is missing in this list, `Tracer::registry` reports missing variants.
const ENUMERATIONS: [&str; 15] = [
    "AimName",
    "DesiredVelocity",
    "Differences",
    "DriveOf",
    "DynamixelModeOf",
    "FamilyOf",
    "FeetechModeOf",
    "GainsName",
    "LineServo",
    "MethodName",
    "Name",
    "Protocol",
    "RateTerm",
    "Sharing",
    "WeightsName",
];
/// Number of passes. No enumeration has more variants; each is traced by name and by number.
const PASSES: usize = 48;

fn assert_on_page(text: &str) {
    assert!(PAGE.contains(text), "docs/link.md lacks this:\n{text}");
}

#[test]
fn the_compact_form_is_on_the_page() {
    let (_, format) = RIG.split_once("//! # Format, version 1\n").expect("it has a format");
    let lines = format.lines().take_while(|line| line.starts_with("//!"));
    let lines: Vec<&str> = lines.map(|line| line.strip_prefix("//! ").unwrap_or("")).collect();
    let text = lines.join("\n");
    assert_on_page(text.trim());
}

/// Returns a type's name on the page: `TimingOf` stands for another crate's `Timing`.
fn name(of: &str) -> &str {
    match of {
        "Name" => "Law",
        "Settings" => "Tracker",
        "Dynamixel" => "DynamixelServo",
        "DynamixelOf" => "DynamixelLine",
        "FeetechOf" => "FeetechLine",
        "Pulses" => "PulseLine",
        of => of.strip_suffix("Of").unwrap_or(of),
    }
}

fn words(format: &Format) -> String {
    match format {
        Format::TypeName(of) => name(of).to_owned(),
        Format::Bool => "bool".to_owned(),
        Format::U8 => "u8".to_owned(),
        Format::U16 => "u16".to_owned(),
        // A `usize` is traced as `U64`, too.
        Format::U32 | Format::U64 => "u32".to_owned(),
        Format::F32 => "f32".to_owned(),
        Format::Option(of) => format!("optional {}", words(of)),
        Format::Seq(of) => format!("list of {}", words(of)),
        Format::TupleArray { content, size } => format!("{size} x {}", words(content)),
        Format::Tuple(of) => of.iter().map(words).collect::<Vec<_>>().join(", "),
        other => panic!("{other:?}"),
    }
}

fn fields(of: &[Named<Format>]) -> String {
    if of.is_empty() {
        return "none".to_owned();
    }
    of.iter()
        .map(|field| format!("{} {}", field.name, words(&field.value)))
        .collect::<Vec<_>>()
        .join(", ")
}

fn rows(registry: &Registry) -> String {
    let mut text = String::from("| type | fields, or kinds by number |\n|---|---|\n");
    let mut types: Vec<_> = registry.iter().map(|(of, format)| (name(of), format)).collect();
    types.sort_by_key(|(of, _)| *of);
    for (of, format) in types {
        let content = match format {
            ContainerFormat::Struct(of) => fields(of),
            ContainerFormat::NewTypeStruct(of) => words(of),
            ContainerFormat::Enum(kinds) => {
                let kinds = kinds.values().enumerate().map(|(number, kind)| match &kind.value {
                    VariantFormat::Unit => format!("{number} {}", kind.name),
                    VariantFormat::NewType(of) => format!("{number} {} ({})", kind.name, words(of)),
                    VariantFormat::Struct(of) => format!("{number} {} ({})", kind.name, fields(of)),
                    other => panic!("{other:?}"),
                });
                kinds.collect::<Vec<_>>().join(", ")
            }
            other => panic!("{of}: {other:?}"),
        };
        writeln!(text, "| {of} | {content} |").expect("into a string");
    }
    text
}

#[test]
fn the_wiring_is_on_the_page() {
    let mut tracer = Tracer::new(TracerConfig::default().is_human_readable(false));
    let samples = Samples::new();
    // Each pass shows another variant of each enumeration.
    for _ in 0..PASSES {
        for of in ENUMERATIONS {
            let _ = tracer.check_incomplete_enum(of);
        }
        tracer.trace_type::<TrackerSettings>(&samples).expect("it can be traced");
        tracer.trace_type::<BusLine>(&samples).expect("it can be traced");
        tracer.trace_type::<Servo>(&samples).expect("it can be traced");
    }
    let registry = tracer.registry().expect("all kinds are known");
    assert_on_page(&rows(&registry));
    assert_on_page(&format!("version u8, which is {VERSION}"));
}
