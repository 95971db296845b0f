//! Measures the core and the images, and compares the numbers with the committed file.

mod boards;
mod cycles;
mod figures;
mod file;
mod hashes;
mod images;
mod kernels;
mod page;
mod printed;
mod stack;
mod tables;
mod trace;

use std::fs;

use anyhow::{Context, Result, ensure};

use crate::elf::Elf;
use kernels::{Kernel, Kernels};
use sinew_steps::{arm, image, step};
use trace::Mix;

pub(crate) use boards::sizes;
use figures::{FigureKey, Figures};
use file::{Budget, FILE};

/// Number of bodies of the rig to which promises refer.
const BODIES: &str = "18";

/// Measures everything and checks the promises of the committed file. With `accept`, updates the file. The boards'
/// images must have been built.
pub(crate) fn run(accept: bool) -> Result<()> {
    let path = step::root().join(FILE);
    let text = fs::read_to_string(&path).with_context(|| FILE.to_owned())?;
    let budget = Budget::parse(&text)?;
    let toolchain = arm::toolchain()?;
    ensure!(
        !accept || toolchain == arm::Toolchain::Rustup,
        "{FILE} has the figures of rustup's compiler, and this is {}",
        toolchain.name()
    );
    let mut figures = boards::all()?;
    images::build()?;
    let kernels = kernels::measure()?;
    figures.extend(kernels.iter().flat_map(|measured| measured.figures.clone()));
    figures.extend(images::core_alone()?);
    let whole_loop = images::whole_loop(&kernels::LOOPS, &figures)?;
    figures.extend(whole_loop);

    print(&figures, &budget, &kernels);
    let verdicts = budget.verdicts(&figures)?;
    println!("{}", tables::promises(&verdicts));
    let mut problems = Vec::new();
    for verdict in verdicts.iter().filter(|verdict| !verdict.holds()) {
        explain(&verdict.place, &kernels)?;
        problems.push(format!(
            "{} is {}, at most {} is promised: {}",
            verdict.place,
            verdict.measured,
            verdict.bound_text(),
            verdict.reason()
        ));
    }
    if accept {
        let text = file::accepting(&text, &figures)?;
        fs::write(&path, &text)?;
        fs::write(step::root().join(page::PAGE), page::print(&text)?)?;
        println!("{FILE} and {} have these figures now.", page::PAGE);
    } else {
        // A changed number is not an error: the author of a change sees it here, and accepts it.
        for change in budget.changes(&figures) {
            println!("{change}");
        }
    }
    ensure!(problems.is_empty(), "{FILE} does not hold:\n  {}", problems.join("\n  "));
    println!("All promises of {FILE} hold.");
    Ok(())
}

fn print(figures: &Figures, budget: &Budget, measured: &[Kernels]) {
    for section in figures.names(|place| Some(&place.section)) {
        println!("{}", tables::section(figures, Some(budget), section));
    }
    for kernels in measured {
        for (place, depth) in kernels.stacks.iter().filter(|(place, _)| place.column == BODIES) {
            println!("deepest stack of {} for {BODIES} bodies:", place.row);
            for (function, bytes) in &depth.path {
                println!("{bytes:>8}  {}", tables::short_name(&kernels.elf, *function));
            }
            println!();
        }
    }
    let of_all: Vec<_> = measured
        .iter()
        .flat_map(|kernels| &kernels.executed)
        .filter(|kernel| kernel.place.column == BODIES)
        .map(|kernel| (&kernel.place.row, kernel.runs, Mix::sum(kernel.mixes.values())))
        .collect();
    let title = format!("executed, {BODIES} bodies");
    let rows = of_all.iter().map(|(name, runs, mix)| ((*name).clone(), *runs, mix));
    println!("{}", tables::mixes(&title, rows));
}

/// Number of functions that are listed for a broken promise.
const LARGEST: usize = 25;

/// Prints the largest contributions to a number that breaks a promise, by function: instructions of a kernel, or
/// bytes of an image.
fn explain(place: &FigureKey, measured: &[Kernels]) -> Result<()> {
    let FigureKey { section, row, column } = place;
    if section == images::SECTION {
        let elf = Elf::load(&image::path_of(arm::TARGET, row))?;
        let mut functions: Vec<_> = (0..elf.functions().len()).collect();
        functions.sort_by_key(|function| std::cmp::Reverse(elf.functions()[*function].size));
        let mut rows = vec![vec![format!("largest of {row}"), "bytes".to_owned()]];
        rows.extend(functions.into_iter().take(LARGEST).map(|function| {
            let bytes = elf.functions()[function].size.to_string();
            vec![tables::short_name(&elf, function), bytes]
        }));
        println!("{}", tables::aligned(&rows));
    }
    let all = measured
        .iter()
        .flat_map(|kernels| kernels.executed.iter().map(move |kernel| (&kernels.elf, kernel)));
    let is_meant = |place: &FigureKey| place.row == *row && place.column == *column;
    if let Some((elf, Kernel { runs, mixes, .. })) =
        all.into_iter().find(|(_, kernel)| is_meant(&kernel.place))
    {
        let mut functions: Vec<_> = mixes.iter().collect();
        functions.sort_by_key(|(_, mix)| std::cmp::Reverse(mix.instructions));
        let rows = functions
            .into_iter()
            .map(|(function, mix)| (tables::short_name(elf, *function), *runs, mix));
        println!("{}", tables::mixes(&format!("{row}, {column} bodies, by function"), rows));
    }
    Ok(())
}
