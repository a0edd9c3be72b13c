//! A whole scan in lanes against the same verilated model in a bare C++ loop.
//!
//! All in one run, in turn: the bare loop clocks the model with constant inputs and
//! compares nothing; lock-step adds photons, the reference model and the comparison of
//! every port at every clock; lanes do the same for the whole scan of `paper-single`,
//! with the stitch. Prints clocks per second and the ratios to the bare loop (10 is
//! asked of lanes on two cores, 0.95 of lock-step). Lanes use all cores, the bare loop
//! one: on a machine that others use the ratio says little.
//!
//!     cargo bench --bench lanes

use std::error::Error;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use goldtof::cosim::TOP;
use goldtof::cosim::build::{build, cache_dir};
use goldtof::cosim::lanes::PreparedLanes;
use goldtof::cosim::lockstep::Lockstep;
use goldtof::cosim::source::sources_of;
use goldtof::cosim::verilated::Verilated;
use goldtof::photons::DetectorModel;
use goldtof::reference::photons::Photons;
use goldtof::reference::predictor::ReferenceModel;
use goldtof::reference::stimulus::clocks_for_scans;
use goldtof::scene::DetectorIndex;
use goldtof::sensor::Sensor;
use goldtof::sensor::layout::Layout;
use goldtof::sensor::port::PortRole;
use goldtof::{deliver, scene};

const CLOCKS: u64 = 20_000_000;
const ROUNDS: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let sensor = Sensor::new(&scene::load(Path::new("scenes/paper-single.toml"))?);
    let sources = sources_of(&deliver::emit(&sensor, "goldtof emit paper-single.toml")?.files);
    let interface = sensor.interface();
    let layout = Layout::of(interface);
    let scan = clocks_for_scans(interface, 1);
    let cache = cache_dir()?;
    let started = Instant::now();
    let prepared = PreparedLanes::new(TOP, &sources, interface, scan, &cache)?;
    println!("lanes prepared in {:.2} s", started.elapsed().as_secs_f64());
    let library = build(TOP, &sources, interface, &cache)?;
    let detectors = [DetectorModel::new(&sensor, DetectorIndex(0))];
    let mut ratios = [Vec::new(), Vec::new()];
    for round in 0..ROUNDS as u64 {
        let mut model = Verilated::load(&library, &layout)?;
        let mut ready = vec![0; layout.inputs.words];
        let field = layout.inputs.field(PortRole::Ready);
        ready[field.word] = 1 << field.shift;
        let started = Instant::now();
        model.run_bare(&ready, CLOCKS)?;
        let bare = CLOCKS as f64 / started.elapsed().as_secs_f64();

        let outcome = Lockstep {
            model: &mut Verilated::load(&library, &layout)?,
            reference: &mut ReferenceModel::new(interface.clone())?,
            stimulus: &mut Photons::new(&detectors, interface, round),
            layout: &layout,
            window: goldtof::cosim::window::Window::Found,
        }
        .run(CLOCKS, |_| (), |_| ())?;
        if outcome.first.is_some() {
            return Err("the two sides differ".into());
        }
        let lockstep = CLOCKS as f64 / outcome.elapsed.as_secs_f64();

        let started = Instant::now();
        let outcome = prepared.run(&detectors, round, scan, &AtomicBool::new(false), &|_| ())?;
        if outcome.differs.is_some() {
            return Err("the lanes differ".into());
        }
        let lanes = scan as f64 / started.elapsed().as_secs_f64();
        println!(
            "bare {:6.2} M clocks/s   lock-step {:6.2} (ratio {:.3})   lanes {:7.2} (ratio {:.2})",
            bare / 1e6,
            lockstep / 1e6,
            lockstep / bare,
            lanes / 1e6,
            lanes / bare
        );
        ratios[0].push(lockstep / bare);
        ratios[1].push(lanes / bare);
    }
    for (name, ratios) in ["lock-step", "lanes"].iter().zip(&mut ratios) {
        ratios.sort_by(f64::total_cmp);
        println!("{name}: median ratio {:.3}", ratios[ROUNDS / 2]);
    }
    Ok(())
}
