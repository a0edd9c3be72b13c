//! How a call ended, and the words of the last error.

use std::cell::RefCell;
use std::ffi::{CString, c_char};

/// How a call ended.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// As it should.
    Ok = 0,
    /// A port differs from what the reference model expects.
    Mismatch = 1,
    /// An argument, the scene or an input is wrong.
    Invalid = 2,
    /// Every port was as expected, but too little has happened to tell.
    Inconclusive = 3,
    /// A mistake in goldtof itself; the handle cannot be used any more.
    Internal = 4,
}

thread_local! {
    static LAST_ERROR: RefCell<CString> = RefCell::default();
}

/// Why a call failed.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) status: Status,
    pub(crate) text: String,
}

impl Failure {
    pub(crate) fn invalid(reason: impl ToString) -> Failure {
        Failure { status: Status::Invalid, text: reason.to_string() }
    }
}

/// Keeps the words of an error for whoever asks.
pub(crate) fn remember(failure: Failure) -> Status {
    let text = failure.text.replace('\0', "\u{fffd}");
    LAST_ERROR.with(|last| *last.borrow_mut() = CString::new(text).unwrap_or_default());
    failure.status
}

/// What the last call of this thread that failed had to say; an empty text if none has.
/// It stays valid until the thread's next call that fails.
#[unsafe(no_mangle)]
pub extern "C" fn goldtof_last_error() -> *const c_char {
    LAST_ERROR.with(|last| last.borrow().as_ptr())
}

/// The version of goldtof, for as long as the program runs.
#[unsafe(no_mangle)]
pub extern "C" fn goldtof_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}
