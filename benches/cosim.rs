//! Co-simulation against the same verilated model in a bare C++ loop.
//!
//! Both in one process, in turn: the bare loop clocks the model with constant
//! inputs and compares nothing; the co-simulation adds photons, the reference
//! model and the comparison of every port at every clock. Prints the ratio of
//! clocks per second (at least 0.8 is asked for), of a sensor of each architecture.
//!
//!     cargo bench --bench cosim

use goldtof::scene::DetectorIndex;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

use goldtof::cosim::TOP;
use goldtof::cosim::build::{build, cache_dir};
use goldtof::cosim::lockstep::Lockstep;
use goldtof::cosim::source::sources_of;
use goldtof::cosim::verilated::Verilated;
use goldtof::cosim::window::Window;
use goldtof::photons::DetectorModel;
use goldtof::reference::photons::Photons;
use goldtof::reference::predictor::ReferenceModel;
use goldtof::sensor::Sensor;
use goldtof::sensor::interface::Interface;
use goldtof::sensor::layout::Layout;
use goldtof::sensor::port::PortRole;
use goldtof::{deliver, scene};

const CLOCKS: u64 = 20_000_000;
const ROUNDS: usize = 7;

fn main() -> Result<(), Box<dyn Error>> {
    compare("scenes/paper-single.toml")?;
    compare("scenes/histogram.toml")
}

fn compare(file: &str) -> Result<(), Box<dyn Error>> {
    let scene = scene::load(Path::new(file))?;
    let sources = sources_of(&deliver::emit(&Sensor::new(&scene), "goldtof emit")?.files);
    let interface = Interface::of(&scene);
    let layout = Layout::of(&interface);
    let library = build(TOP, &sources, &interface, &cache_dir()?)?;
    let detectors = [DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0))];

    let mut ratios = Vec::new();
    for round in 0..ROUNDS {
        let mut model = Verilated::load(&library, &layout)?;
        let mut ready = vec![0; layout.inputs.words];
        let field = layout.inputs.field(PortRole::Ready);
        ready[field.word] = 1 << field.shift;
        let started = Instant::now();
        model.run_bare(&ready, CLOCKS)?;
        let bare = CLOCKS as f64 / started.elapsed().as_secs_f64();

        let mut model = Verilated::load(&library, &layout)?;
        let outcome = Lockstep {
            model: &mut model,
            reference: &mut ReferenceModel::new(interface.clone())?,
            stimulus: &mut Photons::new(&detectors, &interface, round as u64),
            layout: &layout,
            window: Window::Found,
        }
        .run(CLOCKS, |_| (), |_| ())?;
        if outcome.first.is_some() {
            return Err("the two sides differ".into());
        }
        let cosim = outcome.clocks as f64 / outcome.elapsed.as_secs_f64();
        println!(
            "bare {:6.2} M clocks/s   co-simulation {:6.2} M clocks/s   ratio {:.3}",
            bare / 1e6,
            cosim / 1e6,
            cosim / bare
        );
        ratios.push(cosim / bare);
    }
    ratios.sort_by(f64::total_cmp);
    println!("{file}: median ratio {:.3}", ratios[ROUNDS / 2]);
    Ok(())
}
