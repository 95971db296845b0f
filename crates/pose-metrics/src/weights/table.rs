//! Writes weights as tables, JSON and CSV.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use comfy_table::{CellAlignment, Table, presets};
use serde::Serialize;

use super::{Method, Weighing};
use crate::character::Character;

/// Number of decimals of a weight in tables, as in the article's list.
const DECIMALS: usize = 8;

/// Returns an aligned table: a row per joint, indented by its depth, with the length of the bone that ends there,
/// the radius if cylinders were used, and the methods' weights.
pub fn text(character: &Character, radii_m: Option<&[f64]>, weighings: &[Weighing]) -> String {
    let mut table = Table::new();
    let mut header = vec!["joint".to_owned(), "length cm".to_owned()];
    header.extend(radii_m.map(|_| "radius cm".to_owned()));
    header.extend(weighings.iter().map(|weighing| weighing.method.to_string()));
    table.load_style(presets::NOTHING).set_header(header);
    for (index, joint) in character.joints().iter().enumerate() {
        let mut cells =
            vec![format!("{:indent$}{}", "", joint.name, indent = depth(character, index))];
        cells.push(format!("{:.2}", 100.0 * character.bone_length_m(index)));
        cells.extend(radii_m.map(|radii_m| format!("{:.2}", 100.0 * radii_m[index])));
        cells.extend(weighings.iter().map(|w| format!("{:.DECIMALS$}", w.weights[index])));
        table.add_row(cells);
    }
    for (index, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 2));
        if index > 0 {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let mut text = String::new();
    let mut line = |line: &str| writeln!(text, "{line}").expect("a string takes everything");
    line(&format!("{}, {} joints; weights sum to 1", character.name(), character.joints().len()));
    for Weighing { method, base, .. } in weighings {
        line(&format!("{method:<9}  base {base} {}", method.unit()));
    }
    line("");
    line(&table.trim_fmt());
    text
}

/// Returns the number of a joint's ancestors.
fn depth(character: &Character, joint: usize) -> usize {
    let joints = character.joints();
    std::iter::successors(joints[joint].parent, |parent| joints[*parent].parent).count()
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    character: &'a str,
    /// Initial weight of every joint, by method.
    base: BTreeMap<Method, f64>,
    methods: BTreeMap<Method, Vec<JointWeight<'a>>>,
}

#[derive(Serialize)]
struct JointWeight<'a> {
    joint: &'a str,
    weight: f64,
}

/// Returns one JSON object, schema `sinew-weights/1`. `methods` contains a list of joints and weights for each
/// method, in the character's order; `base` contains the initial weight of every joint.
pub fn json(character: &Character, weighings: &[Weighing]) -> String {
    let list = |weighing: &Weighing| {
        let joints = character.joints().iter().zip(&weighing.weights);
        let list =
            joints.map(|(joint, weight)| JointWeight { joint: &joint.name, weight: *weight });
        (weighing.method, list.collect())
    };
    let document = Document {
        schema: "sinew-weights/1",
        character: character.name(),
        base: weighings.iter().map(|weighing| (weighing.method, weighing.base)).collect(),
        methods: weighings.iter().map(list).collect(),
    };
    serde_json::to_string_pretty(&document).expect("names and numbers are JSON") + "\n"
}

/// Returns a row per joint: its name, its parent's name, the length of the bone that ends there, its radius if
/// cylinders were used, and a column per method.
pub fn csv(character: &Character, radii_m: Option<&[f64]>, weighings: &[Weighing]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut write = |row: Vec<String>| writer.write_record(row).expect("memory takes everything");
    let mut header = vec!["joint".to_owned(), "parent".to_owned(), "length_m".to_owned()];
    header.extend(radii_m.map(|_| "radius_m".to_owned()));
    header.extend(weighings.iter().map(|weighing| weighing.method.to_string()));
    write(header);
    let joints = character.joints();
    for (index, joint) in joints.iter().enumerate() {
        let parent = joint.parent.map_or(String::new(), |parent| joints[parent].name.clone());
        let mut row = vec![joint.name.clone(), parent];
        row.push(character.bone_length_m(index).to_string());
        row.extend(radii_m.map(|radii_m| radii_m[index].to_string()));
        row.extend(weighings.iter().map(|weighing| weighing.weights[index].to_string()));
        write(row);
    }
    let bytes = writer.into_inner().expect("memory takes everything");
    String::from_utf8(bytes).expect("only text was written")
}
