//! Timing of a board's tasks: a table, in microseconds and in cycles of its processor.

use sinew_board_client::{ClientError, Line};
use sinew_host_util::command::table;
use sinew_link::message::{Applied, Command, Cycles, Health};

/// Reads the counts since the last read; the board then counts from zero again. Returns `None` if the board answers
/// something else.
///
/// # Errors
/// The board's refusal, or an error of the host link.
pub(super) fn read<L: Line>(
    board: &mut sinew_board_client::Board<L>,
) -> Result<Option<Health>, ClientError> {
    match board.ask(Command::ReadHealth)? {
        Applied::Health(health) => Ok(Some(health)),
        _ => Ok(None),
    }
}

/// Formats minimum, mean, maximum and jitter of each task's time. Returns `None` if the board counts no cycles.
pub(super) fn spreads(health: &Health) -> Option<String> {
    if health.cycles_hz == 0 {
        return None;
    }
    let header = [
        "part",
        "times",
        "min us",
        "mean us",
        "max us",
        "jitter us",
        "min",
        "mean",
        "max",
        "jitter",
    ];
    let mut spreads = table(header, 1..header.len());
    let Health { cycles_hz, tick, bus, link, period, .. } = *health;
    for (part, Cycles { least, mean, most, count }) in
        [("tick", tick), ("bus", bus), ("link", link), ("period", period)]
    {
        if count == 0 {
            continue;
        }
        let cycles = [least, mean, most, most.saturating_sub(least)];
        let us = |cycles: u32| format!("{:.1}", f64::from(cycles) * 1e6 / f64::from(cycles_hz));
        let mut row = vec![part.to_owned(), count.to_string()];
        row.extend(cycles.map(us));
        row.extend(cycles.map(|cycles| cycles.to_string()));
        spreads.add_row(row);
    }
    let lines: String =
        spreads.lines().flat_map(|line| [line.trim_end().to_owned(), "\n".to_owned()]).collect();
    Some(format!("cycles of {cycles_hz} Hz since they were read last:\n{lines}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycles_are_told_in_microseconds_too_and_what_never_came_is_left_out() {
        let spread = |least, mean, most| Cycles { least, mean, most, count: 500 };
        let health = Health {
            cycles_hz: 180_000_000,
            tick: spread(90_000, 180_000, 270_000),
            period: spread(359_100, 360_000, 360_900),
            ..Health::default()
        };
        let told = spreads(&health).unwrap();
        let rows: Vec<Vec<&str>> =
            told.lines().skip(2).map(|line| line.split_whitespace().collect()).collect();
        let tick = [
            "tick", "500", "500.0", "1000.0", "1500.0", "1000.0", "90000", "180000", "270000",
            "180000",
        ];
        let period = [
            "period", "500", "1995.0", "2000.0", "2005.0", "10.0", "359100", "360000", "360900",
            "1800",
        ];
        assert_eq!(rows, [tick, period]);
        assert_eq!(spreads(&Health::default()), None);
    }
}
