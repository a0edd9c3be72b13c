//! `goldtof image`: maps that other readers read, theory that photons bear out, and rooms with more
//! light than one laser's.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use optics_support::repeated;
use serde_json::Value;

use super::program::{goldtof, json, said};

const IMAGE: &str = "scenes/image.toml";
/// An array that takes little time, and sees the same room.
const SMALL: [&str; 6] =
    ["--set", "array.rows=24", "--set", "array.columns=32", "--set", "array.focal_length=0.375 mm"];
/// The same window of the scene of one path in fewer phase steps, which theory takes in half of the time.
const COARSE: [&str; 6] = [
    "--set",
    "clock.samples_per_chip=4",
    "--set",
    "scan.steps={ first = 0, count = 36 }",
    "--set",
    "source.code.degree=5",
];

fn image(scene: &str, out: &Path, more: &[&str]) -> Value {
    let out = ["--out", out.to_str().expect("text"), "--json", "--quiet"];
    json(&[&["image", scene], &SMALL[..], &out, more].concat())
}

fn coarse_image(scene: &str, out: &Path, more: &[&str]) -> Value {
    image(scene, out, &[&COARSE, more].concat())
}

/// The scene's image from theory, which several tests read: its document and its folder.
static THEORY: LazyLock<(Value, PathBuf)> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("image");
    (coarse_image(IMAGE, &folder, &[]), folder)
});

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

/// A map as NumPy reads it.
fn map(folder: &Path, name: &str) -> Vec<f64> {
    let file = folder.join(format!("{name}.npy"));
    let script = "import json, numpy, sys; a = numpy.load(sys.argv[1]); assert a.dtype == 'float32'; \
                  assert a.shape == (24, 32), a.shape; print(json.dumps([float(x) for x in a.ravel()]))";
    let told = python(script, &[file.to_str().expect("text")]);
    let told = told.replace("NaN", "null");
    let values: Vec<Option<f64>> = serde_json::from_str(&told).expect("a list");
    values.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect()
}

fn python(script: &str, arguments: &[&str]) -> String {
    let python = concat!(env!("CARGO_TARGET_TMPDIR"), "/../python/bin/python");
    let output = Command::new(python).args(["-c", script]).args(arguments).output();
    let output = output.expect("scripts/test installs Python's tools");
    assert!(output.status.success(), "{}", said(&output));
    String::from_utf8(output.stdout).expect("text")
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.iter().sum::<f64>() / values.len() as f64
}

/// The interpolated expectation of pixels is what `plan` says of each of them alone.
#[test]
fn theory_is_that_of_each_pixel_alone() {
    let (told, folder) = &*THEORY;
    assert_eq!((&told["rows"], &told["columns"]), (&24.into(), &32.into()));
    assert!(number(&told["interpolation"]["worst_error_in_std"]) < 0.1, "{told}");
    let [bias, std, depth] = ["bias_m", "std_m", "true_depth_m"].map(|name| map(folder, name));
    for (row, column) in [(2, 3), (12, 16), (20, 17), (23, 31), (10, 27), (15, 2)] {
        let place = [format!("array.row={row}"), format!("array.column={column}")];
        let more = ["--set", &place[0], "--set", &place[1], "--json"];
        let plan = json(&[&["plan", IMAGE], &SMALL[..], &COARSE, &more].concat());
        let expected = &plan["expected"][0];
        let pixel = row * 32 + column;
        let exact_m = number(&expected["expected_std_m"]);
        let off = (bias[pixel] - number(&expected["expected_bias_m"])) / exact_m;
        assert!(off.abs() < 0.1, "{row},{column}: bias off by {off} std");
        assert!(
            (std[pixel] / exact_m - 1.0).abs() < 0.1,
            "{row},{column}: {} {exact_m}",
            std[pixel]
        );
        // Depth is along the axis, the path's distance along the ray.
        let (x, y) =
            (0.032 * (f64::from(column as u32) - 15.5), 0.032 * (f64::from(row as u32) - 11.5));
        let ray = (1.0 + x * x + y * y).sqrt();
        let true_m = number(&expected["true_distance_m"]);
        assert!((depth[pixel] * ray / true_m - 1.0).abs() < 1e-6, "{row},{column}");
    }
}

/// Photon by photon, through the bit-exact model: z of 150 pixels (of a release 400). Its root mean square is known
/// to 6 % (3.5 %).
#[test]
fn photons_bear_theory_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let pixels = repeated(150, 400);
    let more = ["--check", &pixels.to_string(), "--pixel", "12,16"];
    let told = coarse_image(IMAGE, folder.path(), &more);
    let check = &told["check"];
    assert_eq!(check["fidelity"], "sampled");
    assert_eq!(number(&check["pixels"]), pixels as f64);
    let (rms, mean) = (&check["rms_deviation_in_std"], &check["mean_deviation_in_std"]);
    assert!((number(rms) - 1.0).abs() < 2.4 / (pixels as f64).sqrt(), "{check}");
    assert!(number(mean).abs() < 4.0 / (pixels as f64).sqrt(), "{check}");
    let missed = number(&check["missed"]);
    let expected = number(&check["expected_missed_fraction"]) * pixels as f64;
    assert!((missed - expected).abs() < 4.0 * expected.max(1.0).sqrt(), "{check}");
    let pixel = &told["pixels"][0];
    assert!(number(&pixel["deviation_in_std"]).abs() < 5.0, "{pixel}");
    assert!((number(&pixel["true_depth_m"]) - 4.5).abs() < 1e-9, "{pixel}");
    // All pixels of a simulated image, in continuous time.
    let told = coarse_image(IMAGE, folder.path(), &["--fidelity", "events"]);
    let check = &told["check"];
    assert_eq!(check["fidelity"], "events");
    let rms = number(&check["rms_deviation_in_std"]);
    assert!(number(&check["pixels"]) > 700.0 && (rms - 1.0).abs() < 0.1, "{check}");
}

/// A theory of another light is accused.
#[test]
fn a_wrong_theory_shows() {
    let scene = fs::read_to_string(IMAGE).expect("it is there");
    // Photons have a tail of late detections, which the check's own theory has, too; so the
    // check is held against the theory of a scene without it.
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("tail.toml");
    let tail = "jitter_tail = { share = 0.5, time_constant = \"3 ns\" }\njitter = [\"100 ps\"]";
    fs::write(&file, scene.replace("jitter = [\"100 ps\"]", tail)).expect("it can be written");
    let more = ["--fidelity", "events"];
    let tailed = coarse_image(file.to_str().expect("text"), folder.path(), &more);
    let with_tail = map(folder.path(), "error_m");
    assert!((number(&tailed["check"]["rms_deviation_in_std"]) - 1.0).abs() < 0.12, "{tailed}");
    let [bias, std] = ["bias_m", "std_m"].map(|name| map(&THEORY.1, name));
    let z = with_tail.iter().zip(bias.iter().zip(&std)).map(|(e, (bias, std))| (e - bias) / std);
    let square = mean(z.filter(|z| z.abs() < 20.0).map(|z| z * z));
    assert!(square > 1.3, "{square}");
}

#[test]
fn the_files_are_those_of_other_programs() {
    let folder = &THEORY.1;
    let depth = map(folder, "depth_m");
    let bytes = fs::read(folder.join("points.ply")).expect("it is there");
    let end = bytes.windows(11).position(|text| text == b"end_header\n").expect("a header") + 11;
    let header = std::str::from_utf8(&bytes[..end]).expect("text");
    let known = depth.iter().filter(|depth| depth.is_finite()).count();
    assert!(header.starts_with("ply\nformat binary_little_endian 1.0\n"), "{header}");
    assert!(header.contains(&format!("element vertex {known}\n")), "{header}");
    assert_eq!(bytes.len() - end, known * 6 * 4);
    let float =
        |at: usize| f32::from_le_bytes(bytes[end + at * 4..end + at * 4 + 4].try_into().unwrap());
    // The first pixel, the upper left: to the left and above.
    let (x, y, z) = (float(0), float(1), float(2));
    assert_eq!(f64::from(z), depth[0]);
    assert!((x / z + 0.496).abs() < 1e-5 && (y / z + 0.368).abs() < 1e-5, "{x} {y} {z}");
    // Every picture, by a decoder that is not the encoder's: zlib and the rows' length.
    let script = "import struct, sys, zlib\n\
        data = open(sys.argv[1], 'rb').read()\n\
        assert data[:8] == b'\\x89PNG\\r\\n\\x1a\\n'\n\
        at, chunks = 8, {}\n\
        while at < len(data):\n    \
            n, kind = struct.unpack('>I4s', data[at:at + 8])\n    \
            body = data[at + 8:at + 8 + n]\n    \
            assert zlib.crc32(kind + body) == struct.unpack('>I', data[at + 8 + n:at + 12 + n])[0]\n    \
            chunks[kind] = chunks.get(kind, b'') + body\n    \
            at += 12 + n\n\
        width, height, depth, colour = struct.unpack('>IIBB', chunks[b'IHDR'][:10])\n\
        assert (depth, colour) == (8, 3)\n\
        rows = zlib.decompress(chunks[b'IDAT'])\n\
        assert len(rows) == height * (width + 1)\n\
        print(len(set(rows)), width, height)";
    for name in
        ["depth_m", "true_depth_m", "error_m", "bias_m", "std_m", "confidence", "intensity_cps"]
    {
        let file = folder.join(format!("{name}.png"));
        let told = python(script, &[file.to_str().expect("text")]);
        let colours: usize = told.split(' ').next().and_then(|n| n.parse().ok()).expect("a number");
        assert!(colours > 30, "{name}: {told}");
    }
    let page = fs::read_to_string(folder.join("index.html")).expect("it is there");
    roxmltree::Document::parse(page.trim_start_matches("<!DOCTYPE html>")).ok();
    for name in ["depth_m.png", "error_m.png", "points.ply"] {
        assert!(page.contains(name), "{name}");
    }
    assert!(!page.contains("<script"));
}

/// The wall of the scene, as a depth map of each format, is the wall.
#[test]
fn maps_stand_for_surfaces() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("text").to_owned();
    let script = "import numpy, struct, sys, zlib\n\
        depth = numpy.full((24, 32), 3.0); depth[5, 7] = 2.5; depth[0, 0] = 0\n\
        numpy.save(sys.argv[1], depth)\n\
        with open(sys.argv[2], 'wb') as f:\n    \
            f.write(b'Pf\\n32 24\\n-1.0\\n' + depth[::-1].astype('<f4').tobytes())\n\
        def png(path, values, bits):\n    \
            kind = '>u2' if bits == 16 else 'u1'\n    \
            rows = b''.join(b'\\0' + row.astype(kind).tobytes() for row in values)\n    \
            def chunk(name, body):\n        \
                return struct.pack('>I', len(body)) + name + body + struct.pack('>I', zlib.crc32(name + body))\n    \
            head = struct.pack('>IIBBBBB', 32, 24, bits, 0, 0, 0, 0)\n    \
            data = chunk(b'IHDR', head) + chunk(b'IDAT', zlib.compress(rows)) + chunk(b'IEND', b'')\n    \
            open(path, 'wb').write(b'\\x89PNG\\r\\n\\x1a\\n' + data)\n\
        png(sys.argv[3], depth * 1000, 16)\n\
        png(sys.argv[4], numpy.full((24, 32), 51), 8)\n\
        numpy.save(sys.argv[5], numpy.ones((24, 31)))\n\
        numpy.save(sys.argv[6], numpy.full((24, 32), 1.5))\n\
        numpy.save(sys.argv[7], numpy.ones((24, 32), dtype=complex))\n\
        open(sys.argv[8], 'wb').write(b'GIF89a')";
    let names =
        ["d.npy", "d.pfm", "d.png", "r.png", "narrow.npy", "bright.npy", "complex.npy", "d.gif"];
    let paths = names.map(at);
    python(script, &paths.each_ref().map(String::as_str));
    let mut seen = Vec::new();
    for depth in &paths[..3] {
        let told =
            image(IMAGE, folder.path(), &["--depth", depth, "--pixel", "5,7", "--pixel", "0,0"]);
        let depth_m = map(folder.path(), "true_depth_m");
        assert!((depth_m[5 * 32 + 7] - 2.5).abs() < 1e-6 && (depth_m[100] - 3.0).abs() < 1e-6);
        assert!(depth_m[0].is_nan());
        assert_eq!(told["lit_pixels"], 767);
        assert_eq!(told["pixels"][1]["own_primary_hz"], 0.0);
        seen.push(number(&told["pixels"][0]["own_primary_hz"]));
    }
    assert!((seen[0] / seen[1] - 1.0).abs() < 1e-6 && (seen[0] / seen[2] - 1.0).abs() < 1e-6);
    // White is 255, and 51 a fifth of it; without a map it is a half.
    let more = ["--depth", &paths[0], "--reflectance", &paths[3], "--pixel", "5,7"];
    let dark = number(&image(IMAGE, folder.path(), &more)["pixels"][0]["own_primary_hz"]);
    assert!((dark / seen[0] - 0.4).abs() < 1e-9, "{dark} {}", seen[0]);
    for (more, told) in [
        (
            vec!["--depth", &paths[4]],
            "narrow.npy: it has 24 rows of 31 pixels, and the scene's array 24 of 32",
        ),
        (
            vec!["--depth", &paths[6]],
            "complex.npy: this is not a map: its numbers are of type \"<c16\"",
        ),
        (vec!["--depth", &paths[7]], "d.gif: this is not a map: it is neither NPY nor PFM"),
        (vec!["--depth", "none.npy"], "none.npy: cannot be read"),
        (
            vec!["--depth", &paths[0], "--reflectance", &paths[5]],
            "bright.npy: row 0, column 0 is 1.5; a reflectance is a share",
        ),
    ] {
        let out = ["--out", folder.path().to_str().expect("text")];
        let output = goldtof(&[&["image", IMAGE], &SMALL[..], &out, &more].concat());
        assert_eq!(output.status.code(), Some(2), "{more:?}");
        assert!(said(&output).contains(told), "{told}: {}", said(&output));
    }
}

/// The article's claim, seen: another sensor's laser with another code of the Gold set moves
/// nothing, and with the same code it does.
#[test]
fn another_sensor_is_seen_with_the_same_code_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let bias = |more: &[&str]| {
        let all = [&["--fidelity", "events"], more].concat();
        image("scenes/image-two-sensors.toml", folder.path(), &all);
        mean(map(folder.path(), "error_m").into_iter())
    };
    let alone = bias(&["--set", "source[other].mean_power=0 W"]);
    let gold = bias(&[]);
    let same = bias(&["--set", "source[other].code.index=0"]);
    assert!(alone.abs() < 0.01, "{alone}");
    assert!((gold - alone).abs() < 0.02, "{gold}");
    assert!(same > 0.05, "{same}");
}

/// Pane and wall, both of them, where they are far from each other.
#[test]
fn glass_and_what_is_behind_it_are_both_shown() {
    let folder = tempfile::tempdir().expect("a folder");
    let told = image("scenes/image-glass.toml", folder.path(), &["--fidelity", "events"]);
    assert!(told["interpolation"].is_null());
    let names = ["depth_m", "second_depth_m", "true_depth_m", "untold"];
    let [first, second, nearest, untold] = names.map(|name| map(folder.path(), name));
    // Behind the pane's left part the wall is 2 m away from it.
    let (mut far, mut near) = (Vec::new(), Vec::new());
    for pixel in (0..first.len()).filter(|&pixel| nearest[pixel] < 4.4) {
        let group = if nearest[pixel] < 2.8 { &mut far } else { &mut near };
        group.push(untold[pixel]);
        if nearest[pixel] < 2.8 {
            let both = [first[pixel], second[pixel]];
            let pane = both.iter().any(|depth| (depth - nearest[pixel]).abs() < 0.25);
            let wall = both.iter().any(|depth| (depth - 4.5).abs() < 0.25);
            assert!(pane && wall, "{both:?} for {} and 4.5", nearest[pixel]);
        }
    }
    assert!(far.len() > 50 && near.len() > 50);
    assert_eq!(far.iter().sum::<f64>(), 0.0);
    assert!(near.iter().sum::<f64>() > 0.0, "the paths meet towards the right edge");
    let theory =
        goldtof(&["image", "scenes/image-glass.toml", "--out", folder.path().to_str().unwrap()]);
    assert!(
        said(&theory)
            .contains("pixels have more of them, of panes or of other lasers; --fidelity events")
    );
}

/// Rows in shards are the image of one run, bit for bit, of every map.
#[test]
fn shards_of_rows_join_bit_for_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    let more = ["--fidelity", "events", "--repeat", "2", "--seed", "5", "--set", "array.rows=8"];
    let mut told = coarse_image(IMAGE, &whole, &more);
    for shard in ["2/3", "1/3", "3/3"] {
        coarse_image(IMAGE, &parts, &[&more[..], &["--shard", shard]].concat());
    }
    let mut merged = json(&["merge", parts.to_str().expect("text"), "--json", "--quiet"]);
    for document in [&mut told, &mut merged] {
        document.as_object_mut().expect("an object").remove("command");
    }
    assert_eq!(told, merged);
    let maps = told["maps"].as_array().expect("a list");
    assert!(maps.len() >= 9, "{maps:?}");
    for map in maps {
        for kind in ["npy", "png"] {
            let name = format!("{}.{kind}", map["map"].as_str().expect("text"));
            let [a, b] =
                [&whole, &parts].map(|folder| fs::read(folder.join(&name)).expect("a file"));
            assert!(a == b, "{name}");
        }
    }
}

#[test]
fn what_is_no_image_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("text");
    for (arguments, told) in [
        (vec!["scenes/quick.toml"], "the scene has no table [array]"),
        (vec![IMAGE, "--fidelity", "rtl"], "all pixels have the same Verilog"),
        (
            vec![IMAGE, "--pixel", "192,0"],
            "--pixel 192,0: the array has rows 0 to 191 and columns 0 to 255",
        ),
        (vec![IMAGE, "--pixel", "12"], "\"12\" is not a row, a comma and a column"),
        (
            vec![IMAGE, "--set", "source.mean_power=0 W"],
            "no pixel gets light of the detector's source",
        ),
        (vec![IMAGE, "--shard", "1/2"], "leave out --shard"),
        (
            vec![IMAGE, "--set", "detector.recharge=passive", "--set", "array.rows=2"],
            "nothing is expected of 512 pixels: recharge is passive",
        ),
        (vec![IMAGE, "--set", "array.plane[9].z=1 m"], "`array.plane` has 3 of them"),
    ] {
        let output = goldtof(&[&["image"], &arguments[..], &["--out", out]].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(said(&output).contains(told), "{told}: {}", said(&output));
    }
}

/// Other commands take one of the pixels.
#[test]
fn other_commands_take_a_pixel() {
    let of = |row: &str| {
        let set = format!("array.row={row}");
        json(&["plan", IMAGE, "--set", &set, "--json"])
    };
    // The wall in the middle, and the floor below it.
    let middle = number(&of("96")["expected"][0]["true_distance_m"]);
    let below = number(&of("180")["expected"][0]["true_distance_m"]);
    assert!((middle - 4.5).abs() < 0.01 && below < middle, "{middle} {below}");
    let told = said(&goldtof(&["plan", IMAGE, "--set", "array.row=0"]));
    assert!(
        told.contains("of the array's 192 rows of 256 pixels this is row 0, column 128 (array.row"),
        "{told}"
    );
    let simulated = json(&["simulate", IMAGE, "--repeat", "20", "--json"]);
    assert_eq!(simulated["estimates"].as_array().map(Vec::len), Some(1));
}
