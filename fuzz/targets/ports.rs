#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| goldtof_fuzz::run("ports", data));
