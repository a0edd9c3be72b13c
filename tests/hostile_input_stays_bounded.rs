//! Inputs of the fuzz targets, from their corpora and changed at random: no
//! panic, no hang, no memory beyond a bound. `scripts/fuzz` does the same for
//! longer, guided by coverage.

use std::fs;
use std::path::Path;
use std::sync::mpsc;
use std::time::Duration;

use rand::{Rng as _, RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;

#[path = "../fuzz/src/inputs.rs"]
mod inputs;
#[path = "../fuzz/src/memory.rs"]
mod memory;

#[global_allocator]
static ALLOCATOR: memory::Counting = memory::Counting;

/// Longest time for one input, on a machine that has much else to do.
const MOST_TIME: Duration = Duration::from_secs(30);
/// Longest input.
const MOST_INPUT_BYTES: usize = 4096;

/// The corpus of a target and `mutations` changed inputs.
fn stays_bounded(name: &str, mutations: usize) {
    let target = inputs::TARGETS.iter().find(|t| t.name == name).unwrap();
    let folder = Path::new("fuzz");
    let corpus: Vec<Vec<u8>> = {
        let files = fs::read_dir(folder.join("corpus").join(name)).unwrap();
        let mut paths: Vec<_> = files.map(|file| file.unwrap().path()).collect();
        paths.sort();
        paths.iter().map(|path| fs::read(path).unwrap()).collect()
    };
    let dictionary = folder.join("dictionaries").join(format!("{name}.dict"));
    let words = words(&fs::read_to_string(dictionary).unwrap());
    assert!(!corpus.is_empty() && !words.is_empty());

    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut changed = Vec::new();
    for i in 0..mutations {
        let mut input = corpus[i % corpus.len()].clone();
        for _ in 0..random.random_range(1..5) {
            change(&mut input, &corpus, &words, &mut random);
        }
        input.truncate(MOST_INPUT_BYTES);
        changed.push(input);
    }

    let (begin, begun) = mpsc::channel::<Option<Vec<u8>>>();
    let (run, most_bytes) = (target.run, target.most_bytes);
    let work = std::thread::spawn(move || {
        for input in corpus.into_iter().chain(changed) {
            begin.send(Some(input.clone())).unwrap();
            let held = memory::most_held(|| run(&input));
            assert!(held <= most_bytes, "{held} bytes are held at a time");
        }
        begin.send(None).unwrap();
    });
    let mut last = Vec::new();
    loop {
        match begun.recv_timeout(MOST_TIME) {
            Ok(Some(input)) => last = input,
            Ok(None) => break,
            Err(reason) => panic!("{reason} at the input \"{}\"", last.escape_ascii()),
        }
    }
    work.join().unwrap();
}

/// The words of a libFuzzer dictionary.
fn words(dictionary: &str) -> Vec<Vec<u8>> {
    let lines = dictionary
        .lines()
        .filter_map(|line| line.strip_prefix('"').and_then(|line| line.strip_suffix('"')));
    lines.map(unescaped).collect()
}

fn unescaped(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        rest = match (byte, after) {
            (b'\\', [b'x', digits @ ..]) => {
                let digits_text = std::str::from_utf8(&digits[..2]).unwrap();
                bytes.push(u8::from_str_radix(digits_text, 16).unwrap());
                &digits[2..]
            }
            (b'\\', [escaped, after @ ..]) => {
                bytes.push(*escaped);
                after
            }
            _ => {
                bytes.push(byte);
                after
            }
        };
    }
    bytes
}

/// One change at a random place.
fn change(
    input: &mut Vec<u8>,
    corpus: &[Vec<u8>],
    words: &[Vec<u8>],
    random: &mut Xoshiro256PlusPlus,
) {
    let at = random.random_range(0..=input.len());
    let to = (at + random.random_range(0..24)).min(input.len());
    match random.random_range(0..6) {
        0 => drop(input.drain(at..to)),
        1 => {
            let copied = input[at..to].to_vec();
            input.splice(to..to, copied);
        }
        2 | 3 => {
            let word = words[random.random_range(0..words.len())].clone();
            let replaced = if random.random() { at..to } else { at..at };
            input.splice(replaced, word);
        }
        4 => {
            let other = &corpus[random.random_range(0..corpus.len())];
            let from = random.random_range(0..=other.len());
            input.truncate(at);
            input.extend(&other[from..]);
        }
        _ => {
            if let Some(byte) = input.get_mut(at) {
                *byte = random.next_u32() as u8;
            }
        }
    }
}

#[test]
fn scenes() {
    stays_bounded("scene", 4_000);
}

#[test]
fn quantities() {
    stays_bounded("quantity", 20_000);
}

#[test]
fn codes() {
    stays_bounded("codes", 600);
}

#[test]
fn manifests() {
    stays_bounded("manifest", 50_000);
}

#[test]
fn ports_of_verilated_models() {
    stays_bounded("ports", 50_000);
}
