//! A verilated model, loaded.

use std::ffi::{CStr, c_char, c_void};
use std::ptr::NonNull;

use libloading::Library;

use super::build::Built;
use super::error::CosimError;
use crate::model::layout::Layout;

type New = unsafe extern "C" fn(i32) -> *mut c_void;
type Run = unsafe extern "C" fn(*mut c_void, *const u64, *mut u64, u64) -> i32;
type RunBare = unsafe extern "C" fn(*mut c_void, *const u64, u64) -> i32;
type Error = unsafe extern "C" fn(*mut c_void) -> *const c_char;
type Delete = unsafe extern "C" fn(*mut c_void);

/// One instance of a verilated model (`testbench/cosim.cpp` is its other side).
pub struct Verilated {
    handle: NonNull<c_void>,
    run: Run,
    run_bare: RunBare,
    error: Error,
    delete: Delete,
    input_words: usize,
    output_words: usize,
    /// After the handle, so that the code outlives it.
    _library: Library,
}

// SAFETY: the handle is used by one thread at a time (all methods that reach it
// take &mut self), and the C++ side keeps no thread-local state.
unsafe impl Send for Verilated {}

impl Verilated {
    /// Loads the library that [`super::build::build`] made for this layout.
    ///
    /// # Errors
    /// When it cannot be loaded or the model cannot be made.
    pub fn load(built: &Built, layout: &Layout) -> Result<Verilated, CosimError> {
        let failed = |source| CosimError::Load {
            path: built.path.clone(),
            source,
        };
        // SAFETY: the library was built from testbench/cosim.cpp, whose
        // functions have the types above; its initialisers only set up C++
        // statics.
        unsafe {
            let library = Library::new(built.image.path()).map_err(failed)?;
            let new: New = *library.get(b"goldtof_new\0").map_err(failed)?;
            let run: Run = *library.get(b"goldtof_run\0").map_err(failed)?;
            let run_bare: RunBare = *library.get(b"goldtof_run_bare\0").map_err(failed)?;
            let error: Error = *library.get(b"goldtof_error\0").map_err(failed)?;
            let delete: Delete = *library.get(b"goldtof_delete\0").map_err(failed)?;
            // The seed of the registers' initial values: any fixed number.
            let handle = NonNull::new(new(1)).ok_or(CosimError::NoModel)?;
            Ok(Verilated {
                handle,
                run,
                run_bare,
                error,
                delete,
                input_words: layout.inputs.words,
                output_words: layout.outputs.words,
                _library: library,
            })
        }
    }

    /// Runs one clock per input record and writes one output record each.
    ///
    /// # Errors
    /// The Verilog's own words when it ended the simulation.
    ///
    /// # Panics
    /// When the lengths are not those of the same number of records.
    pub fn run(&mut self, input: &[u64], output: &mut [u64]) -> Result<(), String> {
        let clocks = input.len() / self.input_words;
        assert_eq!(input.len(), clocks * self.input_words);
        assert_eq!(output.len(), clocks * self.output_words);
        // SAFETY: the slices hold `clocks` records of the widths that the
        // library was built for.
        let status = unsafe {
            (self.run)(
                self.handle.as_ptr(),
                input.as_ptr(),
                output.as_mut_ptr(),
                clocks as u64,
            )
        };
        self.outcome(status)
    }

    /// Runs clocks with one constant input record and reads nothing: the speed
    /// that co-simulation is measured against.
    ///
    /// # Errors
    /// As [`Verilated::run`].
    ///
    /// # Panics
    /// When `input` is not one record.
    pub fn run_bare(&mut self, input: &[u64], clocks: u64) -> Result<(), String> {
        assert_eq!(input.len(), self.input_words);
        // SAFETY: one input record, as the function reads.
        let status = unsafe { (self.run_bare)(self.handle.as_ptr(), input.as_ptr(), clocks) };
        self.outcome(status)
    }

    fn outcome(&mut self, status: i32) -> Result<(), String> {
        if status == 0 {
            return Ok(());
        }
        // SAFETY: the text is NUL-terminated and lives as long as the model.
        let text = unsafe { CStr::from_ptr((self.error)(self.handle.as_ptr())) };
        Err(text.to_string_lossy().into_owned())
    }
}

impl Drop for Verilated {
    fn drop(&mut self) {
        // SAFETY: made by goldtof_new, deleted once.
        unsafe { (self.delete)(self.handle.as_ptr()) }
    }
}
