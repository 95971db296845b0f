//! Draws the times and targets of idle life.

use sinew_host_util::random::{Random, Subject};

use super::actor::Actor;
use super::moves::{Event, Moves};
use super::role::Role;

/// Number of random streams for each attempt.
const STREAMS: u64 = 1000;

/// Draws the moves of every actor on a loop. Actors of the same role move together, except arms.
pub(super) fn moves(actors: &[Actor], loop_s: f64, seed: u64, attempt: u64) -> Vec<Moves> {
    let stream = |number: u64| Random::numbered(seed, attempt * STREAMS + number, Subject::Sway);
    let group = |roles: &[Role]| -> Vec<&Actor> {
        actors.iter().filter(|actor| roles.contains(&actor.role)).collect()
    };
    let together = |group: &[&Actor], change: f64| {
        group.iter().map(|actor| actor.span_s(change)).fold(0.0, f64::max)
    };
    let (eyes, heads) =
        (group(&[Role::EyeTurn, Role::EyeNod]), group(&[Role::HeadTurn, Role::HeadNod]));
    let glances = glances(&mut stream(0), loop_s, together(&eyes, 2.0).max(0.08));
    let followed = followed(&glances, loop_s, together(&heads, 2.0).max(0.7));
    let of_eyes = |axis: usize| {
        let event = |glance: &Glance| Event {
            start_s: glance.start_s,
            target: glance.at[axis],
            least_s: 0.08,
        };
        Moves::new(loop_s, glances.iter().map(event).collect(), |change| together(&eyes, change))
    };
    let of_head = |axis: usize| {
        let event = |glance: &Glance| Event {
            start_s: glance.start_s,
            target: 0.8 * glance.at[axis],
            least_s: 0.7,
        };
        Moves::new(loop_s, followed.iter().map(event).collect(), |change| together(&heads, change))
    };
    let of_group = |role: Role, number: u64, drawn: fn(&mut Random, f64, f64) -> Vec<Event>| {
        let actors = group(&[role]);
        let events = drawn(&mut stream(number), loop_s, together(&actors, 2.0));
        Moves::new(loop_s, events, |change| together(&actors, change))
    };
    let groups = [
        (Role::Blink, of_group(Role::Blink, 1, blinks)),
        (Role::Brow, of_group(Role::Brow, 2, raises)),
        (Role::Breath, of_group(Role::Breath, 3, breaths)),
        (Role::Weight, of_group(Role::Weight, 4, shifts)),
        (Role::HeadTilt, of_group(Role::HeadTilt, 5, shifts)),
        (Role::EyeTurn, of_eyes(0)),
        (Role::EyeNod, of_eyes(1)),
        (Role::HeadTurn, of_head(0)),
        (Role::HeadNod, of_head(1)),
    ];
    (100..)
        .zip(actors)
        .map(|(number, actor)| {
            let of_role = groups.iter().find(|(role, _)| *role == actor.role);
            of_role.map_or_else(
                || {
                    let events = shifts(&mut stream(number), loop_s, actor.span_s(2.0));
                    Moves::new(loop_s, events, |change| actor.span_s(change))
                },
                |(_, moves)| moves.clone(),
            )
        })
        .collect()
}

/// A look at a point: its start, and its position to the side and up, each from -1 to 1.
#[derive(Debug, Clone, Copy)]
struct Glance {
    start_s: f64,
    at: [f64; 2],
}

/// Draws looks at random points. Most of them last less than 2 s.
fn glances(random: &mut Random, loop_s: f64, span_s: f64) -> Vec<Glance> {
    let mut glances = Vec::new();
    let mut start_s = random.between(0.0, 1.0);
    while start_s + span_s <= loop_s {
        // A quarter of the glances, at random, stay near the middle.
        let reach = if random.unit() < 0.25 { 0.15 } else { 1.0 };
        let at = [0, 1].map(|_| reach * random.between(-1.0, 1.0));
        glances.push(Glance { start_s, at });
        let rest = random.unit();
        start_s += span_s + 0.5 + 3.5 * rest * rest;
    }
    glances
}

/// Returns the glances that the head follows, 0.12 s later than the eyes. It leaves out glances for which the head has
/// no time.
fn followed(glances: &[Glance], loop_s: f64, span_s: f64) -> Vec<Glance> {
    let mut followed: Vec<Glance> = Vec::new();
    for glance in glances {
        let start_s = glance.start_s + 0.12;
        let free_s = followed.last().map_or(0.0, |last| last.start_s + span_s + 0.1);
        if start_s >= free_s && start_s + span_s <= loop_s {
            followed.push(Glance { start_s, ..*glance });
        }
    }
    followed
}

/// Draws blinks, with pauses of 1.5 to 6.5 s.
fn blinks(random: &mut Random, loop_s: f64, span_s: f64) -> Vec<Event> {
    let span_s = span_s.max(0.15);
    let mut events = Vec::new();
    let mut start_s = random.between(0.5, 3.0);
    while start_s + 2.0 * span_s + 0.04 <= loop_s {
        events.push(Event { start_s, target: 1.0, least_s: 0.1 });
        events.push(Event { start_s: start_s + span_s + 0.04, target: 0.0, least_s: 0.15 });
        start_s += 2.0 * span_s + 0.04 + random.between(1.5, 6.5);
    }
    events
}

/// Draws raises of the brows, with pauses of 3 to 12 s.
fn raises(random: &mut Random, loop_s: f64, span_s: f64) -> Vec<Event> {
    let span_s = span_s.max(0.25);
    let mut events = Vec::new();
    let mut start_s = random.between(1.0, 6.0);
    loop {
        let held_s = random.between(0.3, 1.5);
        if start_s + 2.0 * span_s + held_s > loop_s {
            return events;
        }
        events.push(Event { start_s, target: random.between(0.4, 1.0), least_s: 0.25 });
        let target = random.between(-0.3, 0.2);
        events.push(Event { start_s: start_s + span_s + held_s, target, least_s: 0.25 });
        start_s += 2.0 * span_s + held_s + random.between(3.0, 12.0);
    }
}

/// Draws breaths of 3.2 to 6 s, or longer if the joints are too slow. Two fifths are for breathing in, the rest for
/// breathing out and a pause. Depths and lengths differ.
fn breaths(random: &mut Random, loop_s: f64, span_s: f64) -> Vec<Event> {
    let mut events = Vec::new();
    let mut start_s = random.between(0.0, 1.0);
    loop {
        let breath_s = random.between(3.2, 6.0).max(2.0 * span_s / 0.8);
        if start_s + breath_s > loop_s {
            return events;
        }
        let in_s = 0.4 * breath_s;
        events.push(Event { start_s, target: random.between(0.3, 1.0), least_s: in_s });
        let target = random.between(-1.0, -0.4);
        let least_s = random.between(0.6, 0.95) * (breath_s - in_s);
        events.push(Event { start_s: start_s + in_s, target, least_s });
        start_s += breath_s;
    }
}

/// Draws slow moves of 1.5 to 3 s, or longer if the joints are too slow, with pauses of 1 to 8 s.
fn shifts(random: &mut Random, loop_s: f64, span_s: f64) -> Vec<Event> {
    let mut events = Vec::new();
    let mut start_s = random.between(0.0, 3.0);
    loop {
        let least_s = random.between(1.5, 3.0);
        let most_s = span_s.max(least_s);
        if start_s + most_s > loop_s {
            return events;
        }
        events.push(Event { start_s, target: random.between(-1.0, 1.0), least_s });
        start_s += most_s + random.between(1.0, 8.0);
    }
}

/// A slow drift: the mean of four sines whose periods, about 12 to 40 s, divide the loop.
#[derive(Debug, Clone)]
pub(super) struct Drift {
    /// For each sine: its number of rounds in the loop, and its phase in rounds.
    sines: [(f64, f64); 4],
    loop_s: f64,
}

impl Drift {
    /// Draws the drift of an actor.
    pub(super) fn new(loop_s: f64, seed: u64, attempt: u64, number: u64) -> Self {
        let number = attempt * STREAMS + 500 + number;
        let mut random = Random::numbered(seed, number, Subject::Sway);
        let [least, most] = [40.0, 12.0].map(|period_s| (loop_s / period_s).max(1.0));
        let sines =
            [(); 4].map(|()| (random.between(least, most).round(), random.between(0.0, 1.0)));
        Self { sines, loop_s }
    }

    /// Returns the drift at a time, s, from -1 to 1.
    pub(super) fn at(&self, time_s: f64) -> f64 {
        let sine = |(rounds, phase): &(f64, f64)| {
            libm::sin(std::f64::consts::TAU * (rounds * time_s / self.loop_s + phase))
        };
        self.sines.iter().map(sine).sum::<f64>() / 4.0
    }
}
