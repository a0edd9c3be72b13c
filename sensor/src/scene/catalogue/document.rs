//! The bounds as a document.

use std::fmt::Write as _;

use super::TABLES;
use crate::code::MAX_CODE_CHIPS;
use crate::scene::{array, detector, read, reader, whole};

/// `docs/scene.md`: every key of a scene, with unit, range, default and an example.
pub fn reference() -> String {
    let mut text = "# Keys of a scene\n\n\
        Made from the keys declared in `sensor/src/scene` by `GOLDTOF_UPDATE=1 cargo test -p goldtof-sensor scene::catalogue`, and with it \
        [scene.schema.json](scene.schema.json), a JSON Schema by which editors complete and check \
        scenes: with [taplo](https://taplo.tamasfe.dev) the line `#:schema` at the top of a scene \
        names it. Tests compare both. [scenes.md](scenes.md) tells how keys go together.\n\n\
        A quantity is a text of a number and a unit, in any unit of its kind: times in fs, ps, ns, \
        us, ms, s, min, h; lengths in nm, um, mm, cm, m, km; rates in cps, kcps, Mcps, Gcps; powers \
        in fW, pW, nW, uW, mW, W, dBm; speeds in um/s, mm/s, m/s, km/s, km/h; offsets of a clock in \
        ppb, ppm, its drifts in ppb/s, ppm/s; angles in urad, mrad, rad, deg; illuminances in lux, klux; \
        spectral irradiances in uW/m2/nm, mW/m2/nm, W/m2/nm.\n\n\
        A value at a bound is allowed. One outside is refused when the scene is read, with file, \
        line, column and the bound. Bounds are what the arithmetic keeps precise, or what is \
        physical, whichever is narrower. Time in a simulation is whole chips in 64 bits and an \
        offset within the chip (2^-53 of a chip at any time); delays are doubles, which keep 2 fs \
        up to 10 s; numbers of samples and counts have 64 bits.\n"
        .to_owned();
    for table in TABLES {
        let _ = writeln!(text, "\n## `{}`\n", table.path);
        text += "| key | meaning | range | when left out | example | why these bounds |\n";
        text += "|---|---|---|---|---|---|\n";
        for key in table.keys() {
            let default = key.when_left_out();
            let _ = writeln!(
                text,
                "| `{}` | {} | {} | {default} | `{}` | {} |",
                key.name,
                key.meaning,
                key.range(),
                key.example_toml(),
                key.why
            );
        }
    }
    text + &together()
}

/// What depends on several keys.
fn together() -> String {
    format!(
        "\n## Several keys together\n\n\
        | what | most |\n|---|---|\n\
        | bytes of a scene file | {} |\n\
        | tables of a kind | {} |\n\
        | pixels of an array | {} |\n\
        | planes of an array that let light through | {} |\n\
        | chips of a code, interleaving included | {MAX_CODE_CHIPS} |\n\
        | chips of all codes of a scene | {} |\n\
        | samples of a scan: phase steps x chips of a step x samples per chip | 2^60 |\n\
        | chips of a step | 2^53 |\n\
        | all jitters of a detector together, and each delay of its counter | 65,536 chips |\n\
        | afterpulsing without a dead time | probability below 1 - 1/e |\n\
        | correlation time of a fluctuation | 2^50 chips; 16 chips at least |\n\
        | standard deviation of a fluctuation | correlation time x 10^-5 of the speed of light; \
        a sixth of the distance |\n\
        | detectors with crosstalk | {} |\n\
        | sum of a sampler's widths | a chip, to 0.1 % |\n\
        | skew of a second pin | 99 % of a sample |\n\
        | duty-cycle distortion and edges of a source together | less than a chip |\n\
        | distance of a path that moves | it may not come to the sensor within a scan |\n",
        read::MOST_SCENE_BYTES,
        reader::MAX_TABLES,
        array::MAX_PIXELS,
        array::MAX_PANES,
        whole::MAX_SCENE_CHIPS,
        detector::MOST_TALKING,
    )
}
