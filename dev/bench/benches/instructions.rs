//! Counts the instructions of each kernel and tick on the host, for each number of bodies, with Valgrind: the numbers
//! are the same on every run of a program, whatever else the machine does.
//!
//! Needs `valgrind` and `cargo install gungraun-runner --version 0.20.0`, the version of the library. Skipped if one
//! is missing, and with `--quick`.

#[path = "common/kernels.rs"]
mod kernels;
#[path = "common/options.rs"]
mod options;

use std::process::{Command, ExitCode, Stdio};

fn main() -> ExitCode {
    // Valgrind runs this program again for each case, after all checks have passed.
    let again = std::env::args().nth(1).is_some_and(|argument| argument == "--gungraun-run");
    if !again {
        if let Some(name) = counted::forgotten() {
            println!("instructions: {name} is not in the list of what is counted, add it");
            return ExitCode::FAILURE;
        }
        if options::quick() {
            println!("instructions: left out, counting takes minutes (run it without --quick)");
            return ExitCode::SUCCESS;
        }
        for (tool, remedy) in [
            ("valgrind", "install Valgrind"),
            ("gungraun-runner", "cargo install gungraun-runner --version 0.20.0"),
        ] {
            let found = Command::new(tool).arg("--version").stdout(Stdio::null()).status();
            if found.is_err() {
                println!("instructions: left out, there is no {tool} here ({remedy})");
                return ExitCode::SUCCESS;
            }
        }
    }
    counted::enter();
    ExitCode::SUCCESS
}

mod counted {
    use gungraun::prelude::*;
    use gungraun::{Callgrind, CallgrindMetrics, EventKind, OutputFormat};

    use crate::kernels::{Kernel, of_size};

    /// Returns a kernel after some runs, since the first runs may take a different number of instructions.
    fn warm(name: &str, bodies: usize) -> Kernel {
        let mut kernels = of_size(bodies).expect("the rigs of the bench can be");
        let index = kernels.iter().position(|kernel| kernel.name == name);
        let mut kernel = kernels.swap_remove(index.expect("a kernel of that name"));
        for _ in 0..3 {
            (kernel.run)();
        }
        kernel
    }

    /// Makes one benchmark of gungraun for each kernel, with its name, and a group of all of them.
    macro_rules! count {
        ($($name:ident)*) => {
            $(
                #[library_benchmark]
                #[bench::bodies_1(args = (stringify!($name), 1), setup = warm)]
                #[bench::bodies_6(args = (stringify!($name), 6), setup = warm)]
                #[bench::bodies_18(args = (stringify!($name), 18), setup = warm)]
                #[bench::bodies_32(args = (stringify!($name), 32), setup = warm)]
                #[bench::bodies_64(args = (stringify!($name), 64), setup = warm)]
                #[bench::bodies_128(args = (stringify!($name), 128), setup = warm)]
                fn $name(mut kernel: Kernel) -> Kernel {
                    (kernel.run)();
                    kernel
                }
            )*

            library_benchmark_group!(name = of_kernels, benchmarks = [$($name),*]);

            const NAMES: &[&str] = &[$(stringify!($name)),*];
        };
    }

    count! {
        forward_kinematics
        error_local
        error_world
        error_accumulated
        error_linear_compensation
        error_linear_compensation_all
        rnea
        mass_matrix
        forward_dynamics
        resolved_acceleration
        forward_differences
        aligned_targets
        backward_differences
        projection
        line_distance
        position_distance
        angle_distance
        tick_world
        tick_linear_compensation
        tick_resolved_acceleration
        tick_recommended
    }

    // Only instructions are counted: simulated caches and cycles would be those of no real machine.
    main!(
        config = LibraryBenchmarkConfig::default()
            .tool(Callgrind::default().format([CallgrindMetrics::from(EventKind::Ir)]))
            .output_format(OutputFormat::default().truncate_description(Some(0))),
        library_benchmark_groups = of_kernels
    );

    pub(super) fn enter() {
        main();
    }

    /// Returns the first kernel that is missing in the list above.
    pub(super) fn forgotten() -> Option<&'static str> {
        let kernels = of_size(1).expect("the rigs of the bench can be");
        kernels.iter().map(|kernel| kernel.name).find(|name| !NAMES.contains(name))
    }
}
