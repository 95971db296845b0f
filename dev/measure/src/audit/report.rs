//! Formats results as text in aligned columns.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use super::rules::{Finding, Rule};
use crate::elf::{Elf, Lines, SourceLine};
use sinew_steps::step;

/// Largest number of instructions that are shown for one function and one violation.
const SHOWN: usize = 3;

/// Formats the code that each part of the image can run.
pub(super) fn contents(elf: &Elf, parts: &[&str]) -> String {
    let mut text = row("part", ["functions", "instructions", "bytes"]);
    for part in parts {
        if let Some(root) = elf.named(part) {
            text += &counts(part, elf, elf.reachable_from(&[root]));
        }
    }
    text + &counts("the whole image", elf, 0..elf.functions().len())
}

fn counts(name: &str, elf: &Elf, functions: impl IntoIterator<Item = usize>) -> String {
    let (mut count, mut instructions, mut bytes) = (0usize, 0usize, 0u64);
    for index in functions {
        let function = &elf.functions()[index];
        count += 1;
        instructions += function.instructions.len();
        bytes += function.size;
    }
    row(name, [count.to_string(), instructions.to_string(), bytes.to_string()])
}

fn row<T: AsRef<str>>(name: &str, [a, b, c]: [T; 3]) -> String {
    format!("{name:<40} {:>10} {:>13} {:>9}\n", a.as_ref(), b.as_ref(), c.as_ref())
}

/// Formats the number of violations of each rule.
pub(super) fn verdict(elf: &Elf, findings: &[Finding]) -> String {
    let mut text = String::from("must not be there                             found\n");
    for rule in Rule::ALL {
        let count = findings.iter().filter(|finding| finding.rule == rule).count();
        let _ = writeln!(text, "{:<40} {count:>10}", rule.name());
    }
    let chained = elf
        .functions()
        .iter()
        .flat_map(|function| &function.instructions)
        .filter(|found| ["vmla", "vmls", "vnmla", "vnmls"].contains(&found.operation.as_str()))
        .count();
    let _ = write!(
        text,
        "\n{chained} of its instructions are vmla, vmls, vnmla or vnmls. They are not fused: they round the product \
         and the sum, as vmul and vadd do.\n"
    );
    text
}

/// Formats the findings by rule and function: the place in the source, and the calls that lead to it from a part of
/// the image.
pub(super) fn findings(findings: &[Finding], elf: &Elf, lines: &Lines, parts: &[&str]) -> String {
    let mut groups = BTreeMap::<_, Vec<u64>>::new();
    for Finding { rule, function, what, at } in findings {
        groups.entry((rule, function, what)).or_default().push(*at);
    }
    let mut text = String::new();
    for ((rule, function, what), addresses) in groups {
        let name = &elf.functions()[*function].name;
        let _ = write!(text, "{}: {what}, in {name}", rule.name());
        let _ = match addresses.len() {
            1 => writeln!(text),
            many => writeln!(text, ", {many} times"),
        };
        let _ = writeln!(text, "  reached by  {}", way(elf, parts, *function));
        for at in addresses.iter().take(SHOWN) {
            let _ = write!(text, "  at {at:#x}");
            let places = lines.at(*at);
            for (index, SourceLine { function, file, line }) in places.iter().enumerate() {
                let inlined = if index == 0 { " " } else { "\n    inlined in" };
                let _ = write!(text, "{inlined} {}:{line} {function}", short(file));
            }
            text.push('\n');
        }
        if addresses.len() > SHOWN {
            let _ = writeln!(text, "  and {} more", addresses.len() - SHOWN);
        }
        text.push('\n');
    }
    text
}

/// Returns the shortest path of calls from a part of the image, or from its start, to a function.
fn way(elf: &Elf, parts: &[&str], function: usize) -> String {
    let from = |root: &str| elf.path_from(elf.named(root)?, function);
    let path = parts
        .iter()
        .filter_map(|part| from(part))
        .min_by_key(Vec::len)
        .or_else(|| from("Reset"))
        .unwrap_or_else(|| vec![function]);
    let names: Vec<_> = path.iter().map(|step| elf.functions()[*step].name.as_str()).collect();
    names.join(" > ")
}

/// Shortens a file's path: relative to the workspace, to the standard library's sources, or to its crate's folder.
fn short(file: &str) -> &str {
    if let Some(start) = file.rfind("/library/") {
        return &file[start + 1..];
    }
    if let Some((_, in_registry)) = file.rsplit_once("/registry/src/") {
        return in_registry.split_once('/').map_or(in_registry, |(_, in_crate)| in_crate);
    }
    Path::new(file).strip_prefix(step::root()).ok().and_then(Path::to_str).unwrap_or(file)
}
