use super::*;
use crate::scene::keys::{Absent, Form, Key, KeyKind};
use crate::scene::units;
use crate::scene::{SceneErrors, parse};

/// Keys that a table must have, with their examples, or with values that suit the others' bounds,
/// for one that has key `name`.
fn needed(table: &KeyTable, name: &str) -> Vec<(&'static str, String)> {
    let must_be = |key: &&Key| matches!(key.absent, Absent::Needed);
    let examples = table.keys().filter(must_be).filter(|key| key.name != "code");
    let mut keys: Vec<_> = examples.map(|key| (key.name, key.example_toml())).collect();
    let more: &[(&str, &str)] = match table.path {
        "detector" => &[("dead_time", "\"14 ns\""), ("cells", "2")],
        "path" => &[("distance", "\"100 m\"")],
        "source.code" => &[("degree", "5")],
        "scan.steps" if ["around", "halfwidth"].contains(&name) => {
            &[("around", "\"3.2 m\""), ("halfwidth", "8")]
        }
        "scan.steps" => &[("first", "0"), ("count", "20")],
        "path.link" => &[("divergence", "\"20 mrad\""), ("field_of_view", "\"10 mrad\"")],
        "detector.background" | "array.background" => &[("irradiance", "\"100 mW/m2/nm\"")],
        "detector.sampler" if !["widths", "file"].contains(&name) => {
            &[("second_pin_skew", "\"0 s\"")]
        }
        _ => &[],
    };
    keys.extend(more.iter().map(|(key, value)| (*key, (*value).to_owned())));
    for (key, value) in &mut keys {
        match (table.path, *key) {
            ("scan", "integration") => *value = "\"20 us\"".to_owned(),
            ("path.fluctuation", "std") => *value = "\"1 um\"".to_owned(),
            ("detector.background", "field_of_view") => *value = "\"1 mrad\"".to_owned(),
            _ => {}
        }
    }
    keys
}

/// A table's keys in a scene that gives key `name` of table `changed` a value.
fn written(table: &KeyTable, changed: &str, name: &'static str, value: &str) -> String {
    let mut keys = needed(table, name);
    if table.path == changed {
        match (table.path, name) {
            ("path", "delay") => keys.retain(|(key, _)| *key != "distance"),
            ("source.code", "interleave") => keys[1].1 = "3".to_owned(),
            ("detector.background" | "array.background", "illuminance") => {
                keys.retain(|(key, _)| *key != "irradiance");
            }
            _ => {}
        }
        keys.retain(|(key, _)| *key != name);
        keys.push((name, value.to_owned()));
    }
    let keys = keys.iter().map(|(key, value)| format!("{key} = {value}"));
    keys.collect::<Vec<_>>().join(", ")
}

/// A scene with every table, whose keys are those given; what is not given has a
/// right value, if it must have one.
fn scene_with(changed: &str, name: &'static str, value: &str) -> String {
    let mut text = String::new();
    let written = |table: &KeyTable| written(table, changed, name, value);
    let lines = |table: &KeyTable| written(table).replace(", ", "\n") + "\n";
    for (header, table, nested) in [
        ("[clock]", &CLOCK, &[][..]),
        ("[[source]]", &SOURCE, &[("code", &CODE)][..]),
        (
            "[[detector]]",
            &DETECTOR,
            &[
                ("afterpulsing", &AFTERPULSING),
                ("counter", &COUNTER),
                ("jitter_tail", &JITTER_TAIL),
                ("background", &BACKGROUND),
                ("sampler", &SAMPLER),
                ("crosstalk", &CROSSTALK),
                ("cell_crosstalk", &CELL_CROSSTALK),
            ][..],
        ),
        ("[[path]]", &PATH, &[("fluctuation", &FLUCTUATION), ("link", &LINK)][..]),
        ("[scan]", &SCAN, &[("steps", &STEPS)][..]),
        ("[estimate]", &ESTIMATE, &[][..]),
        ("[hardware]", &HARDWARE, &[][..]),
        (
            "[array]",
            &ARRAY,
            &[("background", &AMBIENT), ("plane", &PLANE), ("sphere", &SPHERE), ("light", &LIGHT)]
                [..],
        ),
    ] {
        // An array is in place of paths.
        if header == if changed.starts_with("array") { "[[path]]" } else { "[array]" } {
            continue;
        }
        text += &format!("{header}\n{}", lines(table));
        if header == "[[source]]" {
            for (key, value) in [("wavelength", "\"783 nm\""), ("mean_power", "\"4 pW\"")] {
                if (changed, name) != ("source", key) {
                    text += &format!("{key} = {value}\n");
                }
            }
        }
        for (key, table) in nested {
            let lists = if header == "[array]" { table_lists(key) } else { 0 };
            let (open, close) = ("[".repeat(lists), "]".repeat(lists));
            text += &format!("{key} = {open}{{ {} }}{close}\n", written(table));
        }
        text += "\n";
    }
    text
}

/// How many lists there are round a table of an array.
fn table_lists(key: &str) -> usize {
    ARRAY.key(key).lists()
}

/// All complaints about a scene, or none.
fn complaints(text: &str) -> Vec<String> {
    match parse("x.toml", text) {
        Ok(_) => Vec::new(),
        Err(SceneErrors::Invalid { errors, .. }) => {
            errors.into_iter().map(|error| error.message).collect()
        }
        Err(other) => panic!("{other}"),
    }
}

/// A value just within or beyond a bound, as a scene writes it, for each bound:
/// at the bound, and beyond it.
fn values(key: &Key) -> Vec<(String, String)> {
    match key.kind {
        KeyKind::Quantity { least, most, .. } => [(least, -1.0), (most, 1.0)]
            .iter()
            .map(|(bound, sign)| {
                let (number, unit) = bound.split_once(' ').unwrap();
                let number: f64 = number.parse().unwrap();
                let beyond = number + sign * (1e-9 + 1e-9 * number.abs());
                (format!("\"{bound}\""), format!("\"{beyond} {unit}\""))
            })
            .collect(),
        KeyKind::Number { least, most, .. } => vec![
            (least.to_string(), (least - 1e-9).to_string()),
            (format!("{most:?}"), format!("{:?}", most * 1.000_000_001)),
        ],
        KeyKind::Integer { least, most } => vec![
            (least.to_string(), (least - 1).to_string()),
            (most.to_string(), (most + 1).to_string()),
        ],
        KeyKind::Words(..) => Vec::new(),
    }
}

/// A value in as many lists as its key has round it.
fn listed(key: &Key, value: &str) -> String {
    let lists = key.lists();
    format!("{}{value}{}", "[".repeat(lists), "]".repeat(lists))
}

#[test]
fn a_value_at_its_bound_is_within_and_one_beyond_is_refused_with_the_bound() {
    let mut checked = 0;
    for table in TABLES {
        for key in table.keys() {
            for (at, beyond) in values(key) {
                let place = format!("{}.{}: ", table.path, key.name);
                let found = complaints(&scene_with(table.path, key.name, &listed(key, &beyond)));
                let refusal = key.outside(&beyond);
                let refusal = format!("{place}{refusal}");
                assert!(
                    found.iter().any(|message| message.starts_with(&refusal)),
                    "{place}{beyond}: {found:?}"
                );
                let found = complaints(&scene_with(table.path, key.name, &listed(key, &at)));
                let outside = key.outside(&at);
                assert!(
                    !found.iter().any(|message| message.ends_with(&outside)),
                    "{place}{at}: {found:?}"
                );
                checked += 1;
            }
        }
    }
    assert!(checked > 50, "{checked} bounds");
}

#[test]
fn the_numbers_of_the_issue_are_refused() {
    for (table, name, value, most) in [
        ("path", "delay", "\"1e6 s\"", "10.01 s"),
        ("path", "distance", "\"1e18 m\"", "1500000 km"),
        ("detector.counter", "rising_delay", "\"1e303 s\"", "1 ms"),
    ] {
        let found = complaints(&scene_with(table, name, value));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(
            found[0].contains(&format!("{value} is outside")) && found[0].contains(most),
            "{found:?}"
        );
    }
}

#[test]
fn bounds_that_hold_together_are_told_too() {
    let short_chips = scene_with("clock", "chip_period", "\"1 ps\"");
    for (text, told) in [
        (
            short_chips.replace("\"20 us\"", "\"99999 s\""),
            "scan.integration: this is more than 2^53 chips; integrate for at most \"9007 s\"",
        ),
        (
            short_chips
                .replace("\"20 us\"", "\"9000 s\"")
                .replace("steps = { first = 0, count = 20 }", "steps = \"all\""),
            "scan.integration: 248 phase steps of this length are more than 2^60 samples; \
             integrate for less",
        ),
        (
            scene_with("detector.counter", "transition", "\"1 us\"")
                .replace("\"8 ns\"", "\"10 ps\""),
            "detector.counter.transition: \"1 us\" is more than 65536 chips; write at most \
             \"655 ns\"",
        ),
    ] {
        let found = complaints(&text);
        assert!(found.contains(&told.to_owned()), "{told}: {found:?}");
    }
}

/// The reader's own list of the keys that it asks for, from what it says of one
/// that it does not know.
#[test]
fn every_key_that_is_read_is_in_the_table() {
    for table in TABLES {
        // A window without its `first` is not a window.
        let text = match table.path {
            "scan.steps" => {
                scene_with("scan.steps", "first", "0").replace("first = 0", "first = 0, qqqqqq = 0")
            }
            path => scene_with(path, "qqqqqq", "0"),
        };
        let found = complaints(&text);
        let told =
            found.iter().find_map(|message| message.split_once("has no key `qqqqqq`; it takes "));
        let (_, told) = told.unwrap_or_else(|| panic!("{}: {found:?}", table.path));
        let mut told: Vec<&str> = told.split(", ").flat_map(|n| n.split(" or ")).collect();
        let mut known: Vec<&str> = table.keys().map(|key| key.name).collect();
        told.sort_unstable();
        known.sort_unstable();
        assert_eq!(told, known, "{}", table.path);
    }
}

#[test]
fn every_bound_can_be_read_and_every_example_is_within() {
    for table in TABLES {
        for key in table.keys() {
            let value = match key.kind {
                KeyKind::Quantity { quantity, .. } => {
                    let [least, most] = key.bounds();
                    assert!(least < most, "{}", key.name);
                    units::parse(key.example, quantity, "").unwrap()
                }
                KeyKind::Words(..) => continue,
                _ => key.example.parse().unwrap(),
            };
            assert!(key.holds(value), "{}.{}: {value}", table.path, key.name);
        }
    }
}

/// A default that could not be read would be no value at all, without a word.
#[test]
fn every_default_that_is_a_value_can_be_read() {
    for table in TABLES {
        for key in table.keys() {
            let (Some(text), place) = (key.default(), (table.path, key.name)) else {
                continue;
            };
            match key.kind {
                KeyKind::Words(_, Form::Boolean) => {
                    assert!(text.parse::<bool>().is_ok(), "{place:?}")
                }
                KeyKind::Words(_, Form::Choice(names)) => {
                    assert!(names.contains(&text.trim_matches('"')), "{place:?}");
                }
                KeyKind::Words(..) => panic!("{place:?} has a default that nothing reads"),
                KeyKind::Integer { .. } => {
                    assert!(key.holds(text.parse::<i64>().unwrap() as f64), "{place:?}");
                }
                _ => assert!(key.default_number().is_some_and(|n| key.holds(n)), "{place:?}"),
            }
        }
    }
}

/// What the bounds promise of the arithmetic, from the bounds themselves.
#[test]
fn doubles_and_64_bits_hold_what_the_bounds_allow() {
    let most = |table: &KeyTable, name: &str| table.key(name).bounds()[1];
    let shortest_chip_ps = CLOCK.key("chip_period").bounds()[0];
    let delay_ps = most(&PATH, "delay");
    // 2 fs between neighbouring doubles.
    assert!(delay_ps.next_up() - delay_ps < 2e-3);
    let distance_ps = crate::light::round_trip_ps(most(&PATH, "distance"));
    assert!(distance_ps <= delay_ps && distance_ps > 0.99 * delay_ps);
    let chips = |ps: f64| ps / shortest_chip_ps;
    assert!(chips(delay_ps).next_up() - chips(delay_ps) < 2e-3);
    // Chips before a step, of 10^5 dead times or 30 time constants.
    let warm_up = 1e5 * chips(most(&DETECTOR, "dead_time"))
        + 30.0 * chips(most(&AFTERPULSING, "time_constant"))
        + chips(most(&DETECTOR, "delay"));
    assert!(warm_up < 2.0_f64.powi(52));
}

/// A document that is made from the keys is as they are.
fn check_current(file: &str, text: &str) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file);
    if std::env::var_os("GOLDTOF_UPDATE").is_some() {
        std::fs::write(&path, text).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == text,
        "{file} is out of date; make it again with GOLDTOF_UPDATE=1 cargo test -p goldtof-sensor scene::catalogue"
    );
}

#[test]
fn keys_are_documented() {
    check_current("docs/scene.md", &reference());
    check_current("docs/scene.schema.json", &schema());
}

#[test]
fn choices_are_those_that_the_reader_takes() {
    for table in TABLES {
        for key in table.keys() {
            let KeyKind::Words(_, Form::Choice(choices)) = key.kind else {
                continue;
            };
            for choice in choices {
                let text = scene_with(table.path, key.name, &format!("\"{choice}\""));
                let unknown = format!("\"{choice}\" is not known");
                let found = complaints(&text);
                assert!(!found.iter().any(|message| message.contains(&unknown)), "{found:?}");
            }
        }
    }
}
