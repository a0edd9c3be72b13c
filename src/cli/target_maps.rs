//! Maps of depth and reflectance that stand for a scene's surfaces.

use std::io::Cursor;

use anyhow::{Context as _, anyhow, bail, ensure};

use super::prelude::*;
use crate::files::read_bytes;
use crate::image::MapTarget;
use crate::scene::{Lens, MAX_PIXELS};

/// Largest file: an array of the most pixels, in doubles, and its header.
const MOST_BYTES: u64 = MAX_PIXELS as u64 * 8 + (1 << 16);
/// Reflectance of a target that has no map of it.
const GREY: f64 = 0.5;
/// A 16-bit PNG has depths in millimetres.
const PNG_DEPTH_M: f64 = 1e-3;

/// Reads a target from its maps, each as large as the array.
///
/// # Errors
/// When a file cannot be read, is in none of the formats, has another size, or has
/// reflectances beyond 0 to 1.
pub(super) fn read_target(
    depth: &Path,
    reflectance: Option<&Path>,
    lens: &Lens,
) -> anyhow::Result<MapTarget> {
    let depth_m = read(depth, lens, |_| PNG_DEPTH_M)?;
    let reflectance = match reflectance {
        None => vec![GREY; depth_m.len()],
        Some(path) => {
            let shares = read(path, lens, |most| 1.0 / most)?;
            if let Some(pixel) = shares.iter().position(|share| !(0.0..=1.0).contains(share)) {
                let [row, column] = lens.place(pixel);
                bail!(
                    "{}: row {row}, column {column} is {}; a reflectance is a share, 0 to 1",
                    printable_path(path),
                    shares[pixel]
                );
            }
            shares
        }
    };
    Ok(MapTarget { depth_m, reflectance })
}

/// The numbers of a map, row by row from the top; `png_unit` is what one step of a PNG's is, given
/// its largest.
fn read(path: &Path, lens: &Lens, png_unit: impl Fn(f64) -> f64) -> anyhow::Result<Vec<f64>> {
    let shown = printable_path(path);
    let bytes = read_bytes(path, MOST_BYTES).with_context(|| format!("{shown}: cannot be read"))?;
    let map = match bytes.as_slice() {
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => npy(&bytes),
        [0x89, b'P', b'N', b'G', ..] => png(&bytes, png_unit),
        [b'P', b'f', ..] => pfm(&bytes),
        _ => Err(anyhow!("it is neither NPY nor PFM (one channel, \"Pf\") nor PNG")),
    };
    let map = map.with_context(|| format!("{shown}: this is not a map"))?;
    let (rows, columns) = (lens.rows as usize, lens.columns as usize);
    ensure!(
        (map.rows, map.columns) == (rows, columns),
        "{shown}: it has {} rows of {} pixels, and the scene's array {rows} of {columns}; give the \
         array its size: --set array.rows={0} --set array.columns={1}",
        map.rows,
        map.columns
    );
    Ok(map.values)
}

struct Read {
    rows: usize,
    columns: usize,
    values: Vec<f64>,
}

/// The type of a NPY file's numbers: their bytes, and how one is read.
type Number = (usize, fn(&[u8]) -> f64);

fn npy(bytes: &[u8]) -> anyhow::Result<Read> {
    let short = || anyhow!("its header is torn");
    let (length, start) = match bytes.get(6).ok_or_else(short)? {
        1 => (bytes.get(8..10).map(|b| usize::from(u16::from_le_bytes([b[0], b[1]]))), 10),
        2 | 3 => {
            let length = bytes.get(8..12).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            (length.map(|length| length as usize), 12)
        }
        version => bail!("its version {version} of the NPY format is not known"),
    };
    let end = start + length.ok_or_else(short)?;
    let header = bytes.get(start..end).and_then(|text| std::str::from_utf8(text).ok());
    let header = header.ok_or_else(short)?;
    let value = |key: &str| {
        let behind = header.split_once(&format!("'{key}':")).map(|(_, rest)| rest.trim_start());
        behind.ok_or_else(|| anyhow!("its header has no '{key}'"))
    };
    ensure!(
        value("fortran_order")?.starts_with("False"),
        "it is stored column by column; save it row by row (numpy.ascontiguousarray)"
    );
    let descr = value("descr")?.split('\'').nth(1).unwrap_or_default();
    let (size, number): Number = match descr {
        "<f4" => (4, |b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))),
        "<f8" => (8, |b| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]])),
        other => bail!(
            "its numbers are of type \"{other}\"; save it as float32 or float64 (\"<f4\", \"<f8\")"
        ),
    };
    let shape = value("shape")?.trim_start_matches('(').split(')').next().unwrap_or_default();
    let sides: Vec<usize> = shape.split(',').filter_map(|side| side.trim().parse().ok()).collect();
    let [rows, columns] = sides[..] else {
        bail!("its shape is ({shape}); a map has rows and columns");
    };
    let numbers = bytes.get(end..).unwrap_or_default();
    of_numbers(rows, columns, numbers, size, number)
}

/// A portable float map of one channel: its rows stand from the bottom up.
fn pfm(bytes: &[u8]) -> anyhow::Result<Read> {
    let lines: Vec<&[u8]> = bytes.splitn(4, |byte| *byte == b'\n').collect();
    let [_, sides, scale, numbers] = lines[..] else {
        bail!("its header has less than three lines")
    };
    let text = |line| std::str::from_utf8(line).unwrap_or_default().trim();
    let sides: Vec<usize> = text(sides).split_whitespace().filter_map(|n| n.parse().ok()).collect();
    let [columns, rows] = sides[..] else { bail!("its second line is not a width and a height") };
    let scale: f64 = text(scale).parse().map_err(|_| anyhow!("its third line is not a number"))?;
    let number: fn(&[u8]) -> f64 = match scale < 0.0 {
        true => |b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        false => |b| f64::from(f32::from_be_bytes([b[0], b[1], b[2], b[3]])),
    };
    let upside_down = of_numbers(rows, columns, numbers, 4, number)?;
    let values = upside_down.values.chunks(columns.max(1)).rev().flatten().copied().collect();
    Ok(Read { values, ..upside_down })
}

fn of_numbers(
    rows: usize,
    columns: usize,
    bytes: &[u8],
    size: usize,
    number: fn(&[u8]) -> f64,
) -> anyhow::Result<Read> {
    let needed = rows.checked_mul(columns).and_then(|pixels| pixels.checked_mul(size));
    ensure!(
        needed == Some(bytes.len()),
        "{rows} rows of {columns} numbers of {size} bytes are not the {} bytes behind its header",
        bytes.len()
    );
    Ok(Read { rows, columns, values: bytes.chunks_exact(size).map(number).collect() })
}

fn png(bytes: &[u8], unit: impl Fn(f64) -> f64) -> anyhow::Result<Read> {
    let mut decoder = png::Decoder::new_with_limits(
        Cursor::new(bytes),
        png::Limits { bytes: MOST_BYTES as usize },
    );
    decoder.set_transformations(png::Transformations::IDENTITY);
    let mut reader = decoder.read_info()?;
    let info = reader.info();
    let (rows, columns) = (info.height, info.width);
    ensure!(
        info.color_type == png::ColorType::Grayscale,
        "its pixels are not grey; save it with one channel, without transparency"
    );
    let wide = match info.bit_depth {
        png::BitDepth::Sixteen => true,
        png::BitDepth::Eight => false,
        _ => bail!("its pixels have neither 8 nor 16 bits"),
    };
    ensure!(
        u64::from(rows) * u64::from(columns) <= u64::from(MAX_PIXELS),
        "it has more than {MAX_PIXELS} pixels"
    );
    let size = reader.output_buffer_size().ok_or_else(|| anyhow!("it is too large"))?;
    let mut pixels = vec![0; size];
    reader.next_frame(&mut pixels)?;
    let unit = unit(if wide { 65_535.0 } else { 255.0 });
    let values = match wide {
        true => pixels
            .chunks_exact(2)
            .map(|b| f64::from(u16::from_be_bytes([b[0], b[1]])) * unit)
            .collect(),
        false => pixels.iter().map(|byte| f64::from(*byte) * unit).collect(),
    };
    Ok(Read { rows: rows as usize, columns: columns as usize, values })
}
