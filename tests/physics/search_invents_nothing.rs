//! A search for sensors that are not there finds none, with short codes, too, whose
//! correlations with each other are large.

use std::sync::Arc;

use goldtof::code::{Code, CodeSpec, Family};
use goldtof::estimate::CountingTier;
use goldtof::estimate::fit::{Fitter, OtherLight};
use goldtof::photons::DetectorModel;
use goldtof::response::{CountSampler, MeanResponse, SecondMoments};
use goldtof::scene::DetectorIndex;
use goldtof::sensor::Sensor;
use optics_support::table_i_scene;

fn gold(degree: u32, index: i64) -> Arc<Code> {
    let spec = CodeSpec { degree: Some(degree), index: Some(index), ..CodeSpec::new(Family::Gold) };
    Arc::new(spec.build().expect("a code of the set"))
}

/// Scans of the sensor of Table I, alone, in which other light is found, or no distance.
fn finds(degree: u32, periods: u64, scans: u64) -> usize {
    let code = gold(degree, 3);
    let chips = code.len() * periods;
    let mut scene = table_i_scene(code, 5e6, chips);
    scene.paths[0].delay_ps = 77_300.0;
    let sensor = Sensor::new(&scene);
    let model = DetectorModel::new(&sensor, DetectorIndex(0));
    let tier = CountingTier::Events;
    let response = MeanResponse::of_tier(&model, tier).expect("a response");
    let second = SecondMoments::new(&response).expect("second moments");
    let sampler = CountSampler::of(&model, &second).expect("counts can be drawn");
    let fitter = Fitter::new(&sensor, DetectorIndex(0), tier, OtherLight::Search);
    let scans = (0..scans).map(|scan| fitter.fit(&sampler.scan(5, scan)));
    scans.filter(|fit| fit.as_ref().map_or(true, |fit| fit.paths.len() > 1)).count()
}

/// Templates of short codes differ in their power, and the own light passed for others'.
#[test]
fn no_light_is_found_that_is_not_there() {
    for (degree, periods) in [(5, 423), (6, 208)] {
        assert_eq!(finds(degree, periods, 40), 0, "degree {degree}");
    }
}
