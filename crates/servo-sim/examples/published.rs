//! Prints the page of what is published of servos against what is simulated: `docs/simulated-servos.md`.

use sinew_servo_sim::published::{page, table};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    print!("{}", page(&table()?));
    Ok(())
}
