//! A drawing of the report: SVG with a title and a description for those who do not
//! see it, in colours of the page.

use super::prelude::*;

/// A drawing.
pub(super) struct SvgFigure {
    /// Unique on the page: letters, digits and hyphens.
    pub id: String,
    /// What it is.
    pub title: String,
    /// What it shows, in words.
    pub description: String,
    /// Width and height in units of its own.
    pub size: (f64, f64),
    /// Whether it stands alone in its row.
    pub wide: bool,
    /// Its shapes.
    pub content: Markup,
}

impl SvgFigure {
    /// With its title above.
    pub fn markup(&self) -> Markup {
        let (title, description) = (format!("{}-title", self.id), format!("{}-desc", self.id));
        html! {
            figure.wide[self.wide] {
                figcaption { (self.title) }
                // Wide as the page while it is ticked.
                label.larger { input type="checkbox"; span { "larger" } }
                svg role="img"
                    viewBox={ "0 0 " (coordinate(self.size.0)) " " (coordinate(self.size.1)) }
                    aria-labelledby={ (title) " " (description) } {
                    title id=(title) { (self.title) }
                    desc id=(description) { (self.description) }
                    (self.content)
                }
            }
        }
    }
}

/// A coordinate to tenths.
pub(super) fn coordinate(value: f64) -> String {
    let text = format!("{value:.1}");
    text.trim_end_matches(".0").to_owned()
}

/// Points of a polyline.
pub(super) fn points(points: impl IntoIterator<Item = (f64, f64)>) -> String {
    let points = points.into_iter();
    let texts = points.map(|(x, y)| format!("{},{}", coordinate(x), coordinate(y)));
    texts.collect::<Vec<_>>().join(" ")
}

/// Text at a place; `class` has its alignment.
pub(super) fn label(x: f64, y: f64, class: &str, text: &str) -> Markup {
    html! { text x=(coordinate(x)) y=(coordinate(y)) class=(class) { (text) } }
}

/// A name of no more than `most` characters.
pub(super) fn shortened(name: &str, most: usize) -> String {
    match name.chars().count() > most {
        true => name.chars().take(most - 1).chain(['\u{2026}']).collect(),
        false => name.to_owned(),
    }
}
