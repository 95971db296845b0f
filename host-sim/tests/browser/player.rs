//! Controls of the player in a show's page: clock, scrubber, button.

use crate::page::Page;

pub(crate) fn clock(page: &Page) -> f64 {
    let text = page.ask("document.getElementById('clock').textContent");
    text.as_str().unwrap().trim_end_matches(" s").parse().unwrap()
}

pub(crate) fn seek(page: &Page, time_s: f64) {
    page.ask(&format!(
        "(s => {{ s.value = {time_s}; s.dispatchEvent(new Event('input')); }})
            (document.getElementById('scrubber')) ?? 0"
    ));
    page.settle();
}

pub(crate) fn it_plays_and_stops(page: &Page) {
    let before = page.pixels();
    page.wait_ms(300);
    assert_ne!(page.pixels(), before, "it moves");
    page.ask("document.getElementById('play').click()");
    page.settle();
    let time = clock(page);
    page.wait_ms(300);
    assert!((clock(page) - time).abs() < 1e-9, "it stands");
}
