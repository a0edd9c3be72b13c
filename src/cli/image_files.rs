//! The files of an image: maps as NumPy arrays and pictures, points, and a page.

use std::io::{self, Write};

use crate::files::{FileError, OutputFolder};
use crate::image::{Image, ImageReport, Map};
use crate::report::image::page;
use crate::report::raster::{Picture, picture};

pub(super) const PAGE: &str = "index.html";
const POINTS: &str = "points.ply";

/// Writes all files, all or none; gives their names, the page last.
///
/// # Errors
/// When one cannot be written.
pub(super) fn write(
    image: &Image,
    report: &ImageReport,
    command: &str,
    folder: &OutputFolder,
) -> Result<Vec<String>, FileError> {
    let mut names: Vec<String> = Vec::new();
    let mut staged = Vec::new();
    for named in image.maps() {
        let (array, shown) = (format!("{}.npy", named.name), format!("{}.png", named.name));
        staged.push(folder.stage(&array, |out| npy(&named.map, out))?);
        staged.push(folder.stage(&shown, |out| png(&picture(&named), out))?);
        names.extend([array, shown]);
    }
    staged.push(folder.stage(POINTS, |out| ply(image, out))?);
    staged.push(folder.stage(PAGE, |out| out.write_all(page(report, command).as_bytes()))?);
    names.extend([POINTS.to_owned(), PAGE.to_owned()]);
    folder.publish(staged)?;
    Ok(names)
}

/// A map as a NumPy array of 32-bit floating-point numbers, version 1.0 of the format: a header of
/// text, padded so that the numbers begin at a multiple of 64 bytes.
fn npy(map: &Map, out: &mut dyn Write) -> io::Result<()> {
    const BEFORE_TEXT: usize = 10;
    let text = format!(
        "{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}",
        map.rows(),
        map.columns
    );
    let length = (BEFORE_TEXT + text.len() + 1).next_multiple_of(64) - BEFORE_TEXT;
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&(length as u16).to_le_bytes())?;
    writeln!(out, "{text:<width$}", width = length - 1)?;
    let numbers = map.values.iter().flat_map(|value| (*value as f32).to_le_bytes());
    out.write_all(&numbers.collect::<Vec<u8>>())
}

fn png(picture: &Picture, out: &mut dyn Write) -> io::Result<()> {
    let mut encoder = png::Encoder::new(out, picture.width as u32, picture.height as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(picture.palette.concat());
    encoder.set_compression(png::Compression::High);
    // Numbers of colours are no measure of anything: their differences are no smaller.
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&picture.pixels)?;
    Ok(writer.finish()?)
}

/// The measured points, in metres: x to the right, y down, z away from the lens; with the
/// detections per second, the confidence, and the standard deviation where it is known.
fn ply(image: &Image, out: &mut dyn Write) -> io::Result<()> {
    let (seen, measured) = (&image.seen, &image.measured);
    let pixels = 0..measured.distance_m.values.len();
    let known: Vec<usize> =
        pixels.filter(|&pixel| measured.distance_m.values[pixel].is_finite()).collect();
    writeln!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {}", known.len())?;
    for property in ["x", "y", "z", "intensity_cps", "confidence", "std_m"] {
        writeln!(out, "property float {property}")?;
    }
    writeln!(out, "end_header")?;
    let mut bytes = Vec::with_capacity(known.len() * 24);
    for pixel in known {
        let light = &seen.lights[pixel];
        let depth = measured.distance_m.values[pixel] * light.depth_per_distance();
        let beside = [&measured.detected_rate_cps, &measured.found_fraction, &measured.std_m];
        let place = light.ray.iter().map(|along| along * depth);
        for value in place.chain(beside.map(|map| map.values[pixel])) {
            bytes.extend((value as f32).to_le_bytes());
        }
    }
    out.write_all(&bytes)
}
