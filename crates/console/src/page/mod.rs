//! Files of the page. They are served as they are, without a build step, and load nothing from other servers.

/// Content types.
const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const JAVASCRIPT: &str = "text/javascript; charset=utf-8";
const SVG: &str = "image/svg+xml; charset=utf-8";

/// Name, content type and bytes of each file.
pub(crate) const FILES: &[(&str, &str, &[u8])] = &[
    ("index.html", HTML, include_bytes!("index.html")),
    ("console.css", CSS, include_bytes!("console.css")),
    ("icon.svg", SVG, include_bytes!("icon.svg")),
    ("renderer.js", JAVASCRIPT, sinew_report::rig::RENDERER.as_bytes()),
    ("charts.js", JAVASCRIPT, include_bytes!("charts.js")),
    ("dom.js", JAVASCRIPT, include_bytes!("dom.js")),
    ("frame.js", JAVASCRIPT, include_bytes!("frame.js")),
    ("history.js", JAVASCRIPT, include_bytes!("history.js")),
    ("joints.js", JAVASCRIPT, include_bytes!("joints.js")),
    ("log.js", JAVASCRIPT, include_bytes!("log.js")),
    ("main.js", JAVASCRIPT, include_bytes!("main.js")),
    ("ping.js", JAVASCRIPT, include_bytes!("ping.js")),
    ("record.js", JAVASCRIPT, include_bytes!("record.js")),
    ("safety.js", JAVASCRIPT, include_bytes!("safety.js")),
    ("servos.js", JAVASCRIPT, include_bytes!("servos.js")),
    ("show.js", JAVASCRIPT, include_bytes!("show.js")),
    ("socket.js", JAVASCRIPT, include_bytes!("socket.js")),
    ("sound.js", JAVASCRIPT, include_bytes!("sound.js")),
    ("state.js", JAVASCRIPT, include_bytes!("state.js")),
    ("tabs.js", JAVASCRIPT, include_bytes!("tabs.js")),
    ("view.js", JAVASCRIPT, include_bytes!("view.js")),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_the_folder_is_served() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/page");
        for entry in std::fs::read_dir(folder).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            let is_served = FILES.iter().any(|(served, ..)| *served == name);
            assert!(is_served || name == "mod.rs", "{name}");
        }
    }

    #[test]
    fn the_page_has_no_script_or_style_of_its_own() {
        let (.., page) = FILES[0];
        let page = std::str::from_utf8(page).unwrap();
        assert!(!page.contains("<style") && !page.contains("style=") && !page.contains(" onclick"));
        assert_eq!(page.matches("<script").count(), 1, "the module main.js alone");
        for (name, _, bytes) in FILES.iter().filter(|(_, kind, _)| *kind == JAVASCRIPT) {
            let script = std::str::from_utf8(bytes).unwrap();
            assert!(!script.contains("innerHTML") && !script.contains("eval("), "{name}");
        }
    }
}
