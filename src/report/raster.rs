//! Maps as pictures of pixels, with a bar of what the colours mean.
//!
//! Colours are perceptually uniform by their making: lightness, hue and chroma go evenly in Oklab
//! (B. Ottosson, *A perceptual color space for image processing*, 2020). The lightness alone orders
//! those from least to most, so that they are read without colour vision, and printed in grey.

use super::coordinate::{AxisScale, Coordinate};
use crate::image::{Map, MapScale, NamedMap};

/// Colours of a scale.
const COLOURS: usize = 240;
const WHITE: u8 = 240;
const INK: u8 = 241;
/// Pixels without a number.
const NONE: u8 = 242;
/// A picture is about as wide.
const WIDTH: usize = 512;
const MARGIN: usize = 10;
const BAR: usize = 18;
/// Dots of a letter's dot, and from letter to letter.
const DOT: usize = 2;
const ADVANCE: usize = 6 * DOT;
const LETTER_HEIGHT: usize = 7 * DOT;
/// Letters of the longest number at the bar.
const LONGEST: usize = 7;

/// A picture whose pixels are numbers of colours.
pub(crate) struct Picture {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<u8>,
    pub palette: Vec<[u8; 3]>,
}

/// From numbers to places in a scale.
struct Colouring {
    unit: Unit,
    /// In the unit.
    axis: Coordinate,
    scale: AxisScale,
}

/// A unit in which numbers are short.
#[derive(Clone, Copy)]
struct Unit {
    name: &'static str,
    per_base: f64,
}

impl Colouring {
    fn of(named: &NamedMap) -> Colouring {
        let map = &named.map;
        let [low, high] = [0.005, 0.995].map(|share| map.quantile(share).unwrap_or(0.0));
        let most = low.abs().max(high.abs());
        let unit = unit(named.name, most);
        let (low, high) = match named.scale {
            MapScale::Share => (0.0, 1.0),
            MapScale::Signed => (-most, most),
            MapScale::Range | MapScale::Logarithmic => (low, high),
        };
        let (low, high) = (low * unit.per_base, high * unit.per_base);
        let scale = match named.scale {
            MapScale::Logarithmic if low > 0.0 && high > 3.0 * low => AxisScale::Log,
            _ => AxisScale::Linear,
        };
        // A map that is the same everywhere has a scale all the same.
        let spread = (high - low).max(1e-6 * high.abs()).max(1e-12);
        let axis = Coordinate::of(scale, 0.0, [low, low + spread].into_iter());
        Colouring { unit, axis, scale }
    }

    /// Place of a number in the unit, 0 to 1.
    fn place(&self, value: f64) -> f64 {
        self.axis.share(self.axis.clamp(value))
    }

    fn colour(&self, value: f64) -> u8 {
        match value.is_finite() {
            true => (self.place(value * self.unit.per_base) * (COLOURS - 1) as f64).round() as u8,
            false => NONE,
        }
    }

    /// Numbers at the bar, in the unit: of a scale by orders of magnitude 1, 2 and 5 of each.
    fn ticks(&self) -> Vec<f64> {
        self.axis.ticks(if self.scale == AxisScale::Log { usize::MAX } else { 5 })
    }
}

/// The unit that a map is shown in, whose numbers are no larger than `most` in the unit that its
/// name ends in.
fn unit(name: &str, most: f64) -> Unit {
    let of = |name, per_base| Unit { name, per_base };
    match name.rsplit('_').next() {
        Some("m") if most < 1.0 => of("mm", 1e3),
        Some("m") => of("m", 1.0),
        Some("cps") if most >= 1e6 => of("Mcps", 1e-6),
        Some("cps") if most >= 1e3 => of("kcps", 1e-3),
        Some("cps") => of("cps", 1.0),
        _ => of("", 1.0),
    }
}

/// A map as a picture.
pub(crate) fn picture(named: &NamedMap) -> Picture {
    let Map { columns, values } = &named.map;
    let (columns, rows) = ((*columns).max(1), named.map.rows().max(1));
    let zoom = (WIDTH / columns).max(1);
    let (inner_width, inner_height) = (columns * zoom, (rows * zoom).max(64));
    let top = 2 * MARGIN + LETTER_HEIGHT;
    let bar_left = 2 * MARGIN + inner_width;
    let letters = bar_left + BAR + MARGIN;
    let colouring = Colouring::of(named);
    let title = match colouring.unit.name {
        "" => named.meaning.to_owned(),
        unit => format!("{}, {unit}", named.meaning),
    };
    let width = (letters + LONGEST * ADVANCE + MARGIN).max(2 * MARGIN + title.len() * ADVANCE);
    let height = top + inner_height + MARGIN + LETTER_HEIGHT / 2;
    let mut canvas = Canvas { width, height, pixels: vec![WHITE; width * height] };
    canvas.text(MARGIN, MARGIN, &title);
    for (pixel, value) in values.iter().enumerate() {
        let (x, y) = (MARGIN + pixel % columns * zoom, top + pixel / columns * zoom);
        canvas.fill(x, y, [zoom, zoom], colouring.colour(*value));
    }
    for y in 0..inner_height {
        let share = 1.0 - y as f64 / (inner_height - 1) as f64;
        let colour = (share * (COLOURS - 1) as f64).round() as u8;
        canvas.fill(bar_left, top + y, [BAR, 1], colour);
    }
    for tick in colouring.ticks() {
        let from_top = (1.0 - colouring.place(tick)) * (inner_height - 1) as f64;
        let y = top + from_top.round() as usize;
        canvas.fill(bar_left + BAR, y, [5, 1], INK);
        canvas.text(letters, y - LETTER_HEIGHT / 2, &short(tick));
    }
    Picture { width, height, pixels: canvas.pixels, palette: palette(named.scale) }
}

/// A number with no more digits than it has.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

impl Canvas {
    fn fill(&mut self, left: usize, top: usize, [width, height]: [usize; 2], colour: u8) {
        let right = (left + width).min(self.width);
        for y in top..(top + height).min(self.height) {
            self.pixels[y * self.width + left.min(right)..y * self.width + right].fill(colour);
        }
    }

    fn text(&mut self, left: usize, top: usize, text: &str) {
        for (number, letter) in text.chars().enumerate() {
            for (row, line) in glyph(letter).split('/').enumerate() {
                for (column, dot) in line.chars().enumerate() {
                    if dot == '#' {
                        let x = left + number * ADVANCE + column * DOT;
                        self.fill(x, top + row * DOT, [DOT, DOT], INK);
                    }
                }
            }
        }
    }
}

/// The colours of a scale, and behind them ground, ink, and what has no number.
fn palette(scale: MapScale) -> Vec<[u8; 3]> {
    let scale = (0..COLOURS).map(|number| {
        let place = number as f64 / (COLOURS - 1) as f64;
        match scale {
            MapScale::Signed => {
                let (side, from_middle) = (place >= 0.5, (2.0 * place - 1.0).abs());
                let hue = if side { 30.0 } else { 255.0 };
                srgb(0.96 - 0.5 * from_middle, 0.17 * from_middle, hue)
            }
            _ => srgb(0.2 + 0.74 * place, 0.13, 300.0 - 200.0 * place),
        }
    });
    scale.chain([[255; 3], [27, 35, 48], [150, 150, 150]]).collect()
}

/// A colour from its lightness, chroma and hue in Oklab, with no more chroma than a screen has.
fn srgb(lightness: f64, chroma: f64, hue_deg: f64) -> [u8; 3] {
    let (sin, cos) = hue_deg.to_radians().sin_cos();
    let mut chroma = chroma;
    loop {
        let linear = linear_srgb(lightness, chroma * cos, chroma * sin);
        if linear.iter().all(|part| (0.0..=1.0).contains(part)) || chroma < 1e-3 {
            return linear.map(|part| {
                let part = part.clamp(0.0, 1.0);
                let curved = match part <= 0.003_130_8 {
                    true => 12.92 * part,
                    false => 1.055 * part.powf(1.0 / 2.4) - 0.055,
                };
                (255.0 * curved).round() as u8
            });
        }
        chroma *= 0.97;
    }
}

/// From Oklab to linear sRGB.
fn linear_srgb(lightness: f64, a: f64, b: f64) -> [f64; 3] {
    let long = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let medium = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let short = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * long - 3.307_711_591_3 * medium + 0.230_969_929_2 * short,
        -1.268_438_004_6 * long + 2.609_757_401_1 * medium - 0.341_319_396_5 * short,
        -0.004_196_086_3 * long - 0.703_418_614_7 * medium + 1.707_614_701_0 * short,
    ]
}

/// Dots of a letter, row by row, seven of them; two more below the line where it has some there.
fn glyph(letter: char) -> &'static str {
    match letter {
        '0' => " ### /#   #/#  ##/# # #/##  #/#   #/ ### ",
        '1' => "  #  / ##  /  #  /  #  /  #  /  #  / ### ",
        '2' => " ### /#   #/    #/   # /  #  / #   /#####",
        '3' => " ### /#   #/    #/  ## /    #/#   #/ ### ",
        '4' => "   # /  ## / # # /#  # /#####/   # /   # ",
        '5' => "#####/#    /#### /    #/    #/#   #/ ### ",
        '6' => "  ## / #   /#    /#### /#   #/#   #/ ### ",
        '7' => "#####/    #/   # /  #  / #   / #   / #   ",
        '8' => " ### /#   #/#   #/ ### /#   #/#   #/ ### ",
        '9' => " ### /#   #/#   #/ ####/    #/   # / ##  ",
        '-' => "     /     /     /#####/     /     /     ",
        '.' => "     /     /     /     /     / ##  / ##  ",
        ',' => "     /     /     /     /     / ##  / ##  /  #  / #   ",
        '\'' => "  #  /  #  / #   /     /     /     /     ",
        'a' => "     /     / ### /    #/ ####/#   #/ ####",
        'b' => "#    /#    /#### /#   #/#   #/#   #/#### ",
        'c' => "     /     / ### /#    /#    /#   #/ ### ",
        'd' => "    #/    #/ ####/#   #/#   #/#   #/ ####",
        'e' => "     /     / ### /#   #/#####/#    / ### ",
        'f' => "  ## / #   /#### / #   / #   / #   / #   ",
        'g' => "     /     / ####/#   #/#   #/#   #/ ####/    #/ ### ",
        'h' => "#    /#    /#### /#   #/#   #/#   #/#   #",
        'i' => "  #  /     / ##  /  #  /  #  /  #  / ### ",
        'j' => "   # /     /  ## /   # /   # /   # /   # /#  # / ##  ",
        'k' => "#    /#    /#  # /# #  /##   /# #  /#  # ",
        'l' => " ##  /  #  /  #  /  #  /  #  /  #  / ### ",
        'm' => "     /     /## # /# # #/# # #/# # #/# # #",
        'n' => "     /     /#### /#   #/#   #/#   #/#   #",
        'o' => "     /     / ### /#   #/#   #/#   #/ ### ",
        'p' => "     /     /#### /#   #/#   #/#   #/#### /#    /#    ",
        'q' => "     /     / ####/#   #/#   #/#   #/ ####/    #/    #",
        'r' => "     /     /# ## /##   /#    /#    /#    ",
        's' => "     /     / ####/#    / ### /    #/#### ",
        't' => " #   / #   /#### / #   / #   / #   /  ## ",
        'u' => "     /     /#   #/#   #/#   #/#   #/ ####",
        'v' => "     /     /#   #/#   #/#   #/ # # /  #  ",
        'w' => "     /     /#   #/# # #/# # #/# # #/ # # ",
        'x' => "     /     /#   #/ # # /  #  / # # /#   #",
        'y' => "     /     /#   #/#   #/#   #/#   #/ ####/    #/ ### ",
        'z' => "     /     /#####/   # /  #  / #   /#####",
        'M' => "#   #/## ##/# # #/#   #/#   #/#   #/#   #",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE lightness of a colour, from its luminance.
    fn lightness([red, green, blue]: [u8; 3]) -> f64 {
        let linear = |part: u8| {
            let part = f64::from(part) / 255.0;
            if part <= 0.040_45 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
        };
        let luminance = 0.2126 * linear(red) + 0.7152 * linear(green) + 0.0722 * linear(blue);
        116.0 * luminance.cbrt() - 16.0
    }

    /// By another measure of lightness than the one that they are made with.
    #[test]
    fn colours_are_ordered_by_their_lightness() {
        let colours: Vec<f64> =
            palette(MapScale::Range)[..COLOURS].iter().copied().map(lightness).collect();
        let tenth = COLOURS / 10;
        let steps: Vec<f64> =
            (1..10).map(|n| colours[n * tenth] - colours[(n - 1) * tenth]).collect();
        assert!(steps.iter().all(|step| (4.0..12.0).contains(step)), "{steps:?}");
        let signed: Vec<f64> =
            palette(MapScale::Signed)[..COLOURS].iter().copied().map(lightness).collect();
        assert!(signed[0] < 50.0 && signed[COLOURS - 1] < 50.0 && signed[COLOURS / 2] > 90.0);
        assert!((signed[10] - signed[COLOURS - 11]).abs() < 5.0);
    }

    #[test]
    fn a_picture_has_its_pixels_where_they_are() {
        let values = vec![0.0, 1.0, f64::NAN, 2.0];
        let map = Map::new(2, values);
        let named = NamedMap { name: "depth_m", meaning: "depth", scale: MapScale::Range, map };
        let picture = picture(&named);
        assert_eq!(picture.pixels.len(), picture.width * picture.height);
        let top = 2 * MARGIN + LETTER_HEIGHT;
        let at = |x: usize, y: usize| picture.pixels[(top + y) * picture.width + MARGIN + x];
        assert_eq!([at(0, 0), at(300, 0), at(0, 300), at(300, 300)], [0, 120, NONE, 239]);
        assert_eq!(picture.pixels[0], WHITE);
    }

    #[test]
    fn every_letter_of_a_title_has_dots() {
        let titles =
            ["measured less true distance, mm", "detections per second, Mcps", "pixel's -0.5"];
        for letter in titles.concat().chars().filter(|letter| *letter != ' ') {
            let rows: Vec<usize> = glyph(letter).split('/').map(str::len).collect();
            assert!(matches!(rows.len(), 7 | 9) && rows.iter().all(|row| *row == 5), "{letter}");
        }
    }

    #[test]
    fn ticks_are_round_and_within() {
        let shown = |name, scale, low: f64, high: f64| {
            let map = Map::new(2, vec![low, high]);
            let colouring = Colouring::of(&NamedMap { name, meaning: "", scale, map });
            colouring.ticks().iter().map(|t| short(*t)).collect::<Vec<_>>()
        };
        assert_eq!(shown("error_m", MapScale::Signed, 1.0, 3.3), ["-2", "0", "2"]);
        assert_eq!(shown("depth_m", MapScale::Range, 2.9, 3.45), ["3", "3.2", "3.4"]);
        assert_eq!(shown("rate_cps", MapScale::Logarithmic, 3.2, 63.0), ["5", "10", "20", "50"]);
    }
}
