//! Measures the wall time of each kernel and tick, for each number of bodies, with criterion.
//!
//! `cargo bench -p sinew-bench --bench wall -- rnea/18` runs one; `-- --save-baseline NAME` and `-- --baseline NAME`
//! compare two states of the code.

#[path = "common/kernels.rs"]
mod kernels;

use std::time::Duration;

use criterion::Criterion;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut criterion = Criterion::default()
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(800))
        .sample_size(50)
        .configure_from_args();
    for bodies in kernels::SIZES {
        for mut kernel in kernels::of_size(bodies)? {
            let name = format!("{}/{bodies}", kernel.name);
            criterion.bench_function(&name, |bencher| bencher.iter(&mut kernel.run));
        }
    }
    criterion.final_summary();
    Ok(())
}
