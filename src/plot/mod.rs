//! Charts, in PNG or SVG.
//!
//! Text in a PNG uses an embedded font, so it needs none on the machine; an SVG leaves the font to its viewer.

mod axis;
mod bars;
mod curves;
mod file;
mod heatmap;
mod page;
mod text;

pub use axis::{Axis, Scale};
pub use bars::{Bar, BarPanel, Bars};
pub use curves::{Curves, Line, Look, Panel};
pub use file::{PlotFile, svg_text};
pub use heatmap::{Heatmap, magma};
pub use page::Plot;
pub use text::{round_limit, short};

#[cfg(test)]
mod tests {
    use super::*;

    fn curves() -> Curves {
        let points = |slope: f64| (0..20).map(|i| (f64::from(i), slope * f64::from(i))).collect();
        let line = |name: &str, points| Line { name: name.to_owned(), points, ..Line::default() };
        let reference = || line("reference", vec![(0.0, f64::INFINITY), (3.0, 0.1)]);
        let panel = |name: &str| Panel::linear(name, vec![line("image", points(0.01)), reference()]);
        Curves {
            title: "Title".to_owned(),
            x: Axis::linear("frame"),
            panels: vec![panel("RMSE"), panel("FLIP"), panel("SSIM")],
            ..Curves::default()
        }
    }

    #[test]
    fn plots_are_drawn_in_both_formats() {
        let folder = tempfile::tempdir().unwrap();
        let save = |name: &str| {
            let file = PlotFile::new(folder.path().join(name)).unwrap();
            file.save(&curves()).unwrap();
            file.file().path().to_path_buf()
        };
        let text = std::fs::read_to_string(save("a.svg")).unwrap();
        for part in ["<svg", "Title", "RMSE", "FLIP", "SSIM", "reference", "frame", "polyline"] {
            assert!(text.contains(part), "{part}");
        }
        let picture = image::open(save("a.PNG")).unwrap().into_rgb8();
        let dark = picture.pixels().filter(|pixel| pixel.0.iter().all(|&channel| channel < 96)).count();
        // The letters of titles and labels.
        assert!(dark > 500, "{dark}");
    }

    #[test]
    fn plots_without_points_are_drawn_too() {
        let folder = tempfile::tempdir().unwrap();
        let file = PlotFile::new(folder.path().join("a.png")).unwrap();
        let mut curves = curves();
        for line in curves.panels.iter_mut().flat_map(|panel| &mut panel.lines) {
            line.points.clear();
        }
        file.save(&curves).unwrap();
        curves.panels.clear();
        file.save(&curves).unwrap();
    }

    #[test]
    fn the_name_says_which_kind_of_plot() {
        let error = PlotFile::new("a.pdf").unwrap_err();
        assert!(error.is_usage() && error.to_string().contains("must end in .svg or .png"), "{error}");
        let error = PlotFile::new("no such folder/a.svg").unwrap_err();
        assert!(!error.is_usage() && error.to_string().contains("no folder"), "{error}");
    }
}
