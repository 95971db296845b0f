//! Prints the page that compares published figures of servos with simulated ones: `docs/simulated-servos.md`.

use sinew_servo_sim::published::{page, table};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    print!("{}", page(&table()?));
    Ok(())
}
