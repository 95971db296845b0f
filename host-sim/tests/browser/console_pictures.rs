//! The console's page on the screens of a desktop and of a phone, with rigs of several kinds. With `SINEW_PICTURES`,
//! the pages are written there as pictures.

use std::path::Path;

use crate::common::sinew_in;
use crate::console::{Served, arm, wait_for_state};
use crate::page::Page;

/// Widths of screens, and the height of each.
const SCREENS: [[u32; 2]; 2] = [[1280, 800], [400, 850]];
/// Smallest contrast between a text and its background (WCAG AA).
const CONTRAST: f64 = 4.5;

/// Shows a rig limp, armed, and with a joint that is moved, on all screens, light and dark.
fn show_on_all_screens(name: &str, arguments: &[&str], folder: &Path) {
    let console = Served::start_in(folder, arguments);
    console.with_page(|page| {
        wait_for_state(page, "limp");
        for [width, height] in SCREENS {
            page.assert_fits(width);
            page.resize(width, height);
            page.picture(&format!("{name}-limp-{width}"));
        }
        arm(page);
        for [width, height] in SCREENS {
            for tab in ["joints", "servos", "log"] {
                page.resize(width, height);
                page.hold(&format!("#tab-{tab}"), 30);
                page.settle();
                page.ask("scrollTo(0, 0)");
                assert_nothing_overlaps(page);
                page.picture(&format!("{name}-{tab}-{width}"));
            }
            page.hold("#tab-joints", 30);
            for scheme in ["dark", "light"] {
                page.emulate("", scheme);
                // Colours fade.
                page.wait_ms(300);
                assert_contrast(page, scheme);
            }
            page.drag("#joint-0", [0.5, 0.7], || {
                page.wait_ms(700);
                page.picture(&format!("{name}-jog-{width}"));
            });
            wait_for_state(page, "holding");
        }
        page.emulate("", "dark");
        page.resize(1280, 800);
        page.picture(&format!("{name}-dark-1280"));
    });
}

/// Checks that no visible button covers another, and that no button cuts its own words.
fn assert_nothing_overlaps(page: &Page) {
    let wrong = page.ask(
        "(() => {
            const all = [...document.querySelectorAll('button, select, h1, .state, .vitals, #role')]
                .filter(e => e.checkVisibility() && !e.closest('.cues') && e.id !== 'hold');
            const box = e => e.getBoundingClientRect();
            const cut = all.filter(e => e.tagName === 'BUTTON' && e.scrollWidth > e.clientWidth + 1)
                .map(e => `cut: ${e.textContent}`);
            const over = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
                && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
            const head = all.filter(e => e.closest('header'));
            const pairs = head.flatMap((a, i) => head.slice(i + 1)
                .filter(b => !a.contains(b) && !b.contains(a) && over(box(a), box(b)))
                .map(b => `over: ${a.textContent} / ${b.textContent}`));
            return [...cut, ...pairs];
        })()",
    );
    assert_eq!(wrong, serde_json::json!([]));
}

/// Checks the contrast of the visible texts with the nearest opaque background above them.
fn assert_contrast(page: &Page, scheme: &str) {
    let wrong = page.ask(&format!(
        "(() => {{
            const paint = document.createElement('canvas').getContext('2d', {{ willReadFrequently: true }});
            const rgba = text => {{
                paint.clearRect(0, 0, 1, 1);
                paint.fillStyle = text;
                paint.fillRect(0, 0, 1, 1);
                return [...paint.getImageData(0, 0, 1, 1).data];
            }};
            const light = ([r, g, b]) => [r, g, b].map(c => c / 255)
                .map(c => c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
                .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
            const behind = e => {{
                for (let up = e; up; up = up.parentElement) {{
                    const color = rgba(getComputedStyle(up).backgroundColor);
                    if (color[3] === 255) return color;
                }}
                return [255, 255, 255, 255];
            }};
            const texts = [...document.querySelectorAll('body *')].filter(e => e.checkVisibility()
                && [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim() !== '')
                && !e.closest('noscript, canvas, option, .hidden, .skip'));
            return texts.map(e => {{
                const [a, b] = [light(rgba(getComputedStyle(e).color)), light(behind(e))];
                return [(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), e.textContent.slice(0, 40), e.className];
            }}).filter(([ratio]) => ratio < {CONTRAST});
        }})()"
    ));
    assert_eq!(wrong, serde_json::json!([]), "{scheme}");
}

#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn the_starter_arm_is_shown_on_all_screens() {
    let folder = tempfile::tempdir().unwrap();
    show_on_all_screens("arm", &["punches_01"], folder.path());
}

#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn the_face_is_shown_on_all_screens() {
    let folder = tempfile::tempdir().unwrap();
    let new = ["rig", "new", "--face", "--output", "face.toml"];
    assert!(sinew_in(folder.path(), &new).status.success());
    show_on_all_screens("face", &["--rig", "face.toml"], folder.path());
}

#[test]
#[ignore = "needs SINEW_CHROMIUM and SINEW_DATA"]
fn robots_of_the_data_are_shown_on_all_screens() {
    let folder = tempfile::tempdir().unwrap();
    let data = std::env::var_os("SINEW_DATA").expect("SINEW_DATA names the data");
    let op3 = Path::new(&data).join("urdf/robotis-op3/robotis_op3.urdf");
    let rig = op3.display().to_string();
    let import = ["rig", "import", &rig, "--repair-inertia", "--output", "op3.toml"];
    let imported = sinew_in(folder.path(), &import);
    assert!(imported.status.success(), "{}", String::from_utf8_lossy(&imported.stderr));
    show_on_all_screens(
        "op3",
        &["--rig", "op3.toml", "--servo", "xm430", "--drive", "position"],
        folder.path(),
    );
}
