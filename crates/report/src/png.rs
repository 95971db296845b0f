//! Converts SVG to PNG with an embedded font, which gives the same bytes on every machine.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

/// Pixels per unit of a picture.
const SCALE: f32 = 2.0;

static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    fonts.load_font_data(dejavu::sans::bold().to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    Arc::new(fonts)
});

/// Renders the picture as PNG.
pub(super) fn png(svg: &str) -> Vec<u8> {
    let options = Options {
        fontdb: Arc::clone(&FONTS),
        font_family: "DejaVu Sans".into(),
        ..Options::default()
    };
    let tree = Tree::from_str(svg, &options).expect("our pictures are SVG");
    let size = tree.size().to_int_size().scale_by(SCALE).expect("our pictures have a size");
    let mut pixels = Pixmap::new(size.width(), size.height()).expect("our pictures are not empty");
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
    pixels.encode_png().expect("memory takes everything")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_shapes_are_drawn() {
        let picture = |content: &str| {
            let svg = format!(
                "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 60 20'>{content}</svg>"
            );
            png(&svg)
        };
        let empty = picture("");
        assert_ne!(
            picture("<text x='2' y='15' font-family='system-ui, sans-serif'>deg</text>"),
            empty
        );
        assert_ne!(picture("<rect width='9' height='9'/>"), empty);
    }
}
