//! Emits a scene's Verilog into a folder and runs it beside the reference model, as a build
//! does that must not go on with wrong hardware.
//!
//! ```sh
//! cargo run --example check_verilog [SCENE [FOLDER]]
//! ```

use std::error::Error;
use std::path::PathBuf;

use goldtof::cosim::{StimulusKind, Verdict};
use goldtof::{CosimOptions, EmitOptions, Jobs as _, OwnRtl, Sensor};

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args_os().skip(1).map(PathBuf::from);
    let scene = words.next().unwrap_or_else(|| "scenes/quick.toml".into());
    let folder = words.next().unwrap_or_else(|| "target/check_verilog".into());
    check(scene, folder)
}

fn check(scene: PathBuf, folder: PathBuf) -> Result<(), Box<dyn Error>> {
    let sensor = Sensor::load(scene)?;
    let emission = sensor.emit(&EmitOptions::default())?;
    goldtof::deliver::write(&emission, &folder)?;
    println!("{} files in {}", emission.files.len(), folder.display());

    // What is in the folder, not what was just made: an edited file is found out.
    let own = OwnRtl::folder(&folder);
    let stimulus = StimulusKind::Adversarial;
    let mut found = sensor.cosim(&CosimOptions { own, stimulus, ..Default::default() })?;
    println!("{}: {} clocks", found.report.verdict, found.report.clocks);
    if let Some(first) = &found.report.first_mismatch {
        eprintln!("clock {}: {}", first.clock, first.text());
        found.write_vcd(&folder.join("mismatch.vcd"))?;
    }
    match found.report.verdict {
        Verdict::Match => Ok(()),
        other => Err(format!("co-simulation: {other}").into()),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_is_emitted_matches_and_is_written_whole_again() {
        let folder = tempfile::tempdir().unwrap();
        let scene = || "scenes/quick.toml".into();
        super::check(scene(), folder.path().to_owned()).unwrap();
        // A folder that is written again is whole again.
        let file = folder.path().join("updown_correlator.v");
        std::fs::write(&file, "module updown_correlator; endmodule\n").unwrap();
        super::check(scene(), folder.path().to_owned()).unwrap();
        assert!(std::fs::read_to_string(&file).unwrap().len() > 1000);
    }
}
