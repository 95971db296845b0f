//! Tests of the page of a rig.

use sinew_report::rig;
use sinew_rig::review::{Loop, Review, Servos};

use crate::page::{Page, with_page};

#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn a_builder_can_move_a_rig() {
    let description = sinew_rig::new::arm(6).unwrap();
    let mechanism = description.mechanism().unwrap();
    let servos = Servos::of(&description, &mechanism).unwrap();
    let control = Loop { rate_hz: 500.0, latency_ticks: 1, bandwidth_rad_s: None };
    let review = Review::of(&mechanism, &servos, control).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rig.html");
    std::fs::write(&file, rig::page(&description.name, &mechanism, &review)).unwrap();
    with_page(&file, |page| {
        it_moves_by_itself_until_it_is_stopped(page);
        sliders_and_the_view_go_by_keyboard(page);
        loads_are_those_of_the_check(page, &review);
        for width in [1280, 768, 400] {
            page.assert_fits(width);
        }
    });
}

fn positions(page: &Page) -> serde_json::Value {
    page.ask(
        "[...document.querySelectorAll('#sliders label span:last-child')].map(e => e.textContent)",
    )
}

fn it_moves_by_itself_until_it_is_stopped(page: &Page) {
    let before = positions(page);
    page.wait_ms(300);
    assert_ne!(positions(page), before, "it moves");
    page.ask("document.getElementById('home').click()");
    page.settle();
    let home = positions(page);
    page.wait_ms(300);
    assert_eq!(positions(page), home, "it stands");
}

fn sliders_and_the_view_go_by_keyboard(page: &Page) {
    let (before, picture) = (positions(page), page.pixels());
    page.ask("document.querySelectorAll('#sliders input')[1].focus()");
    page.press("ArrowRight");
    let after = positions(page);
    assert_ne!(after[1], before[1]);
    assert_eq!(after[0], before[0], "no other joint moves");
    assert_ne!(page.pixels(), picture, "the rig is seen to move");
    page.ask("document.getElementById('stage').focus()");
    for key in ["ArrowLeft", "ArrowUp", "+", "-"] {
        let picture = page.pixels();
        page.press(key);
        assert_ne!(page.pixels(), picture, "{key}");
    }
}

/// Checks the loads that the page computes: in the worst poses they equal those of the check.
fn loads_are_those_of_the_check(page: &Page, review: &Review) {
    for (index, dof) in review.by_dof.iter().enumerate() {
        page.ask(&format!("document.querySelectorAll('#sliders button')[{index}].click()"));
        page.settle();
        let load =
            page.ask(&format!("document.querySelectorAll('#sliders .load')[{index}].textContent"));
        let load: f64 = load.as_str().unwrap().split(' ').next().unwrap().parse().unwrap();
        // The page shows three decimals.
        assert!((load.abs() - dof.gravity_effort).abs() <= 5.1e-4, "{}: {load}", dof.name);
    }
}
