//! Prints the size of a show for several errors: 10 minutes of the 20 joint angles that move most in each of CMU's
//! fights, and in its walks, low-passed at 6 Hz.
//!
//! `SINEW_DATA=.../data cargo run --release -p sinew-show --example size` prints rows of `docs/show-format.md`.

mod performance;

use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use performance::{CHANNELS, RATE, SECONDS, motion, performance};
use sinew_show::write::{Settings, Written, write};
use sinew_show::{Player, Position, Show};

fn main() -> Result<(), Box<dyn Error>> {
    let Some(data) = std::env::var_os("SINEW_DATA") else {
        return Err("set SINEW_DATA to the folder of recordings".into());
    };
    let cmu = Path::new(&data).join("cmu");
    let bounds: Vec<f64> = std::env::args().skip(1).map(|a| a.parse()).collect::<Result<_, _>>()?;
    let bounds = if bounds.is_empty() { vec![0.05, 0.1, 0.25, 0.5, 1.0] } else { bounds };
    for class in ["fight", "walk"] {
        let q = performance(&cmu, class)?;
        for bound in &bounds {
            row(class, &q, *bound)?;
        }
    }
    Ok(())
}

fn row(class: &str, q: &[f64], bound_deg: f64) -> Result<(), Box<dyn Error>> {
    let settings = Settings { angle_rad: bound_deg.to_radians(), ..Settings::default() };
    let begun = Instant::now();
    let Written { bytes, angles, knots, .. } = write(&motion(q), &settings)?;
    let write_s = begun.elapsed().as_secs_f64();
    let rate_hz = f64::from(RATE.hz());
    let mut player = Player::<CHANNELS>::new(Show::open(&bytes)?)?;
    let samples = q.len() / CHANNELS;
    // Compared with central differences of the samples.
    let (mut squares, mut all) = (0.0, 0.0);
    let [mut p, mut v, mut a] = [[0.0; CHANNELS]; 3];
    for sample in 1..samples - 1 {
        player.state_at(Position::from_samples(u32::try_from(sample)?), &mut p, &mut v, &mut a)?;
        for (c, a) in a.iter().enumerate() {
            let at = |k: usize| q[k * CHANNELS + c];
            let wanted = (at(sample - 1) - 2.0 * at(sample) + at(sample + 1)) * rate_hz * rate_hz;
            squares += (wanted - f64::from(*a)).powi(2);
            all += wanted.powi(2);
        }
    }
    let count = (CHANNELS * (samples - 2)) as f64;
    // 500 ticks per second.
    let pace = player.show().pace(0.002);
    let ticks = u32::try_from(samples)? / 120 * 500;
    let begun = Instant::now();
    for tick in 0..ticks {
        player.state_at(pace.position(tick), &mut p, &mut v, &mut a)?;
        black_box((&p, &v, &a));
    }
    let ns = begun.elapsed().as_secs_f64() * 1e9 / f64::from(ticks);
    println!(
        "| {class} | {bound_deg}° | {} | {:.4}° | {:.4}° | {:.2} rad/s² | {:.1} |",
        bytes.len(),
        angles.largest.to_degrees(),
        angles.rms.to_degrees(),
        (squares / count).sqrt(),
        knots as f64 / SECONDS,
    );
    eprintln!(
        "written in {write_s:.1} s, {ns:.0} ns a frame; accelerations {:.2} rad/s²",
        (all / count).sqrt()
    );
    Ok(())
}
