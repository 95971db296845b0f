//! Runs `docs/first-rig.md`, from its first command to its last, in the simulator.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

const PAGE: &str = include_str!("../../../docs/first-rig.md");

/// Returns the steps of the page, each with the lines of its command blocks. Blocks for real hardware and lines with
/// `cargo` are left out.
fn steps() -> Vec<(String, Vec<String>)> {
    let (mut steps, mut is_block, mut is_metal) =
        (Vec::<(String, Vec<String>)>::new(), false, false);
    for line in PAGE.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            steps.push((heading.to_owned(), Vec::new()));
        }
        match line {
            "<!-- metal -->" => is_metal = true,
            "```sh" => is_block = true,
            "```" => (is_block, is_metal) = (false, is_metal && !is_block),
            _ if is_block && !is_metal && !line.starts_with("cargo ") => {
                if let Some((_, lines)) = steps.last_mut() {
                    lines.push(line.to_owned());
                }
            }
            _ => {}
        }
    }
    steps.retain(|(_, lines)| !lines.is_empty());
    steps
}

/// Returns the page's estimate of a person's work besides the commands, min.
fn person_min() -> f64 {
    let row = PAGE.lines().find_map(|line| line.strip_prefix("| **without shopping")).unwrap();
    row.split("**").nth(2).unwrap().parse().unwrap()
}

/// Runs the lines of a step in a shell, and returns their duration, s.
fn run(folder: &Path, lines: &[String]) -> f64 {
    let bin = Path::new(env!("CARGO_BIN_EXE_sinew")).parent().unwrap();
    let path = std::env::var("PATH").unwrap();
    // On a busy machine, simulated servos may answer late. Boards need no such patience.
    let patient = |line: &String| {
        let is_of_servos = line.contains("sinew servo ");
        if is_of_servos {
            line.replace("--port ", "--timeout-ms 300 --port ")
        } else {
            line.clone()
        }
    };
    let script = lines.iter().map(patient).collect::<Vec<_>>().join("\n");
    // Without this, a process that a failed line leaves running would keep the output open.
    let script = format!("trap 'kill $! 2>/dev/null || true' EXIT\n{script}");
    let start = Instant::now();
    let done = Command::new("sh")
        .args(["-e", "-c", &script])
        .env("PATH", format!("{}:{path}", bin.display()))
        .current_dir(folder)
        .output()
        .unwrap();
    let said =
        String::from_utf8_lossy(&done.stdout).into_owned() + &String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{script}\n{said}");
    start.elapsed().as_secs_f64()
}

#[test]
fn every_command_of_the_page_does_what_it_says() {
    let folder = tempfile::tempdir().unwrap();
    let steps = steps();
    // The steps: see it move, stop, check, ids, clip, teach, face, board.
    assert_eq!(steps.len(), 8, "{steps:?}");
    println!("| step | lines | s |\n|---|---:|---:|");
    let mut all_s = 0.0;
    for (heading, lines) in &steps {
        let took_s = run(folder.path(), lines);
        println!("| {heading} | {} | {took_s:.1} |", lines.len());
        all_s += took_s;
    }
    let lines: usize = steps.iter().map(|(_, lines)| lines.len()).sum();
    println!("| **all commands** | **{lines}** | **{all_s:.1}** |");
    // Not asserted: the speed of a machine is not a fault of the page.
    println!("with what a person takes: {:.0} min", all_s / 60.0 + person_min());
    for made in ["arm.html", "punch.show", "taught.csv", "led.show", "talk.show", "doctor.txt"] {
        assert!(folder.path().join(made).is_file(), "{made}");
    }
}
