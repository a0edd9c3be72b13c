use std::path::Path;

use super::*;
use crate::scene;

fn contract(file: &str) -> Contract {
    let scene = scene::load(Path::new(file)).unwrap_or_else(|error| panic!("{error}"));
    Contract::of(&scene)
}

#[test]
fn every_cover_point_of_the_test_scenes_is_reached() {
    for file in std::env::var("SCENES").unwrap().split(' ') {
        for skips in [true, false] {
            let contract = contract(file);
            let started = std::time::Instant::now();
            let mut adversary = Adversarial::with_means(&contract, 1, Means::cosim(skips)).unwrap();
            let clocks = adversary.clone().clocks_to_cover(LONGEST_DEFAULT);
            let elapsed = started.elapsed();
            while adversary.decided < clocks {
                adversary.decide();
            }
            let table = adversary.scout.cover_table();
            let covered = &adversary.scout.exercise().covered;
            println!("{file} {skips}: {clocks} clocks {} of {} {elapsed:?}", covered.count(), table.points().len());
            for (number, point) in table.points().iter().enumerate() {
                if !covered.contains(number) {
                    println!("    {point:?} {:?}", Adversarial::hindrance(&contract, Means::cosim(skips), *point));
                }
            }
            for p in table.unreachable() { println!("    unreachable {p:?}"); }
        }
    }
}
