//! Whatever happens to a run: a clear message, the right exit status, nothing
//! half-written under its final name, and the next run works.

mod cache;
mod full_disk;
mod hostile_names;
mod interrupted;
mod killed;
mod output_folders;
mod planted;
mod power_cut;
mod rtl_of_others;
mod streams;
mod support;
mod tools;
mod two_at_once;
