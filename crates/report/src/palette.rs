//! The colours of the report, distinguishable for readers with colour blindness, on light and on dark backgrounds.

use std::fmt::Write as _;

/// Name of each colour, its value on light, and its value on dark.
const COLORS: [(&str, &str, &str); 15] = [
    ("text", "#1b2530", "#e4e9ee"),
    ("muted", "#5a6673", "#9ba8b5"),
    ("line", "#dfe4ea", "#2d3742"),
    ("paper", "#ffffff", "#12171d"),
    ("surface", "#f5f7f9", "#1a2129"),
    ("focus", "#0b62c4", "#7ab8ff"),
    ("alert", "#a8410a", "#ffb074"),
    ("local", "#2468ad", "#74b3ee"),
    ("world", "#a85a06", "#f2a64a"),
    ("linear-compensation", "#08785a", "#45cca0"),
    ("egocentric", "#8547a6", "#cf9fe8"),
    ("accumulated", "#66707a", "#a9b3bd"),
    ("manifold-projection", "#b3265e", "#ff8fb8"),
    ("resolved-acceleration", "#6b6a00", "#c9c74a"),
    ("recommended", "#0b7285", "#5fd0e3"),
];

/// Colours of charts, for the page and for files of their own.
const CHART: &str = include_str!("assets/chart.css");

/// Returns the page's styles: the colours as variables, light or dark by the reader's system setting. On paper
/// they are always light.
pub(super) fn page() -> String {
    let variables = |of: fn(&(&str, &str, &str)) -> String| -> String {
        COLORS.iter().map(of).collect::<Vec<_>>().join(" ")
    };
    let light = variables(|(name, light, _)| format!("--{name}: {light};"));
    let dark = variables(|(name, _, dark)| format!("--{name}: {dark};"));
    let mut css = String::new();
    write!(
        css,
        ":root {{ color-scheme: light dark; {light} }}\n\
         @media screen and (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n"
    )
    .expect("a string takes everything");
    css + CHART + include_str!("assets/page.css")
}

/// Returns the styles of a picture that is a file of its own: the light colours.
pub(super) fn picture() -> String {
    COLORS.iter().fold(CHART.to_owned(), |css, (name, light, _)| {
        css.replace(&format!("var(--{name})"), light)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_have_no_variables() {
        assert!(!picture().contains("var("));
    }

    /// Checks the contrast of text and of lines against the page, as defined in WCAG 2.2.
    #[test]
    fn everything_can_be_read_on_light_and_on_dark() {
        let luminance = |color: &str| {
            let channel = |at: usize| {
                let value = u8::from_str_radix(&color[at..at + 2], 16).unwrap();
                let value = f64::from(value) / 255.0;
                if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
            };
            0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
        };
        let contrast = |a: &str, b: &str| {
            let (a, b) = (luminance(a), luminance(b));
            (a.max(b) + 0.05) / (a.min(b) + 0.05)
        };
        let color = |wanted: &str| *COLORS.iter().find(|(name, ..)| *name == wanted).unwrap();
        let (_, paper_light, paper_dark) = color("paper");
        let (_, surface_light, surface_dark) = color("surface");
        for (name, light, dark) in COLORS {
            if ["paper", "surface", "line"].contains(&name) {
                continue;
            }
            for (color, page) in [
                (light, paper_light),
                (dark, paper_dark),
                (light, surface_light),
                (dark, surface_dark),
            ] {
                assert!(contrast(color, page) >= 4.5, "{name} {color} on {page}");
            }
        }
    }
}
