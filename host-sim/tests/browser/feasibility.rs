//! Tests of the page of a show's feasibility.

use sinew_report::feasibility::Page as Feasibility;
use sinew_retarget::feasibility::{Curve, Limits, RigMotion, check};
use sinew_rig::Mechanism;
use sinew_rig::review::Servos;

use crate::page::{Page, with_page};
use crate::player::{clock, it_plays_and_stops, seek};

const RATE_HZ: f64 = 100.0;

/// Two seconds of motion. The first joint exceeds its speed limit once.
fn motion(mechanism: &Mechanism, speed: f64) -> RigMotion {
    let home = mechanism.home();
    let row = |row: u32| {
        // Half a cosine in 0.4 s: its largest speed is π / 0.4 s times half its amplitude.
        let phase = ((f64::from(row) / RATE_HZ - 0.8) / 0.4).clamp(0.0, 1.0);
        let way = 1.2 * speed * 0.4 / std::f64::consts::PI;
        let mut q = home.clone();
        q[0] += way * (1.0 - libm::cos(std::f64::consts::PI * phase));
        q[1] += 0.1 * libm::sin(0.05 * f64::from(row));
        q
    };
    RigMotion { dt_s: RATE_HZ.recip(), rows: (0..=200).map(row).collect() }
}

#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn a_builder_sees_what_a_show_asks_of_a_rig() {
    let description = sinew_rig::new::arm(6).unwrap();
    let mechanism = description.mechanism().unwrap();
    let servos = Servos::of(&description, &mechanism).unwrap();
    let limits = Limits::of(&mechanism, &servos);
    let motion = motion(&mechanism, limits.dofs[0].speed);
    let curve = Curve::new(&mechanism, &motion).unwrap();
    let report = check(&mechanism, &limits, &curve, 250.0).unwrap();
    assert!(report.excesses.iter().any(|excess| excess.dof == 0));
    let page = Feasibility {
        rig: &description.name,
        // A name that would be markup if it were not escaped.
        clip: "wave</script><script>throw 1</script>",
        mechanism: &mechanism,
        limits: &limits,
        report: &report,
        performance: &curve,
        fitted: None,
        strange: None,
        summary: "one line",
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("feasibility.html");
    std::fs::write(&file, page.html().unwrap()).unwrap();
    with_page(&file, |page| {
        it_plays_and_stops(page);
        the_keyboard_goes_through_time(page);
        the_plots_say_what_was_checked(page, &motion);
        an_excess_leads_to_its_time(page, report.excesses.len());
        a_joint_is_chosen_by_its_row(page);
        a_plot_leads_to_its_time(page);
        for width in [1280, 768, 400] {
            page.assert_fits(width);
        }
    });
}

fn the_keyboard_goes_through_time(page: &Page) {
    seek(page, 1.0);
    page.ask("document.activeElement.blur()");
    page.press("ArrowRight");
    assert!((clock(page) - 1.1).abs() < 1e-9);
    page.press("ArrowLeft");
    page.press("ArrowLeft");
    assert!((clock(page) - 0.9).abs() < 1e-9);
    page.press(" ");
    let label = "document.getElementById('play').getAttribute('aria-label')";
    assert_eq!(page.ask(label), "Pause");
    page.press(" ");
    assert_eq!(page.ask(label), "Play");
}

/// Checks that the plots show the checked numbers, although the page stores them in 16 bits and three digits.
fn the_plots_say_what_was_checked(page: &Page, motion: &RigMotion) {
    page.ask("(s => { s.value = 0; s.dispatchEvent(new Event('change')); })(document.getElementById('joint')) ?? 0");
    for row in [0, 90, 100, 110] {
        seek(page, row as f64 * motion.dt_s);
        let text = page.ask("document.querySelector('#charts .value').textContent");
        let text = text.as_str().unwrap().replace('−', "-");
        let degrees: f64 = text.trim_end_matches('°').parse().unwrap();
        let given = motion.rows[row][0].to_degrees();
        assert!(
            (degrees - given).abs() <= 0.5_f64.min(0.006 * given.abs() + 0.006),
            "{text} {given}"
        );
    }
}

fn an_excess_leads_to_its_time(page: &Page, count: usize) {
    let listed = page.ask("document.querySelectorAll('[data-excess]').length");
    assert_eq!(listed.as_u64().unwrap(), count as u64);
    seek(page, 0.0);
    page.ask("document.querySelector('[data-excess]').click()");
    page.settle();
    assert!((0.8..=1.2).contains(&clock(page)), "{}", clock(page));
    assert_eq!(page.ask("document.getElementById('joint').value"), "0");
    assert_eq!(page.ask("document.querySelectorAll('#joints tr.now').length"), 1);
    assert_ne!(page.ask("document.querySelectorAll('#charts .excess').length"), 0);
}

fn a_joint_is_chosen_by_its_row(page: &Page) {
    let titles = "[...document.querySelectorAll('#charts .area')].map(e => e.ariaLabel)";
    let before = page.ask(titles);
    page.ask("document.querySelectorAll('#joints tbody button')[1].focus()");
    page.press("Enter");
    assert_eq!(page.ask("document.getElementById('joint').value"), "1");
    assert_ne!(page.ask(titles), before);
    assert_eq!(page.ask("document.querySelectorAll('#joints [aria-pressed=true]').length"), 1);
}

fn a_plot_leads_to_its_time(page: &Page) {
    page.ask(
        "(area => { const box = area.getBoundingClientRect(); area.dispatchEvent(new PointerEvent('pointerdown',
            { bubbles: true, buttons: 1, clientX: box.left + box.width / 4 }));
        })(document.querySelector('.area')) ?? 0",
    );
    page.settle();
    assert!((clock(page) - 0.5).abs() < 0.02, "{}", clock(page));
}
