//! goldtof's inputs for libFuzzer. Each one must end without a panic and within
//! its bound of memory; libFuzzer itself bounds the time.

pub mod inputs;
pub mod memory;

#[global_allocator]
static ALLOCATOR: memory::Counting = memory::Counting;

/// Runs one input of the kind `name`.
///
/// # Panics
/// When it holds more memory than it may; and whenever goldtof panics.
pub fn run(name: &str, data: &[u8]) {
    let target = inputs::TARGETS
        .iter()
        .find(|target| target.name == name)
        .expect("a kind of input");
    let held = memory::most_held(|| (target.run)(data));
    assert!(held <= target.most_bytes, "{held} bytes are held at a time");
}
