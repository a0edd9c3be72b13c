//! Where C meets Rust: pointers become references, and panics errors.

use std::any::Any;
use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard};

use crate::status::{Failure, Status, remember};

/// Runs what a call is to do; gives its status and, if it ended well, what it made.
pub(crate) fn call<T>(job: impl FnOnce() -> Result<T, Failure>) -> Result<T, Status> {
    // What a panic leaves behind is behind a lock that is poisoned then.
    let done = catch_unwind(AssertUnwindSafe(job)).unwrap_or_else(|panic| {
        Err(Failure {
            status: Status::Internal,
            text: format!("goldtof made a mistake: {}", words_of(&*panic)),
        })
    });
    done.map_err(remember)
}

/// The status of a call that makes nothing.
pub(crate) fn status_of(job: impl FnOnce() -> Result<(), Failure>) -> Status {
    call(job).err().unwrap_or(Status::Ok)
}

/// What C holds a pointer to: something behind a lock.
pub(crate) trait Handle {
    /// What is behind the lock.
    type Inside;

    fn of(inside: Self::Inside) -> Self;

    fn lock(&self) -> &Mutex<Self::Inside>;
}

/// Makes a handle of a struct round a lock, which C sees by its name alone.
macro_rules! handle {
    ($handle:ident, $inside:ident) => {
        impl crate::border::Handle for $handle {
            type Inside = $inside;

            fn of(inside: $inside) -> $handle {
                $handle(Mutex::new(inside))
            }

            fn lock(&self) -> &Mutex<$inside> {
                &self.0
            }
        }
    };
}
pub(crate) use handle;

/// A new handle, or null.
pub(crate) fn new_handle<H: Handle>(job: impl FnOnce() -> Result<H::Inside, Failure>) -> *mut H {
    match call(job) {
        Ok(inside) => Box::into_raw(Box::new(H::of(inside))),
        Err(_) => std::ptr::null_mut(),
    }
}

/// Ends a handle; nothing happens with null.
///
/// # Safety
/// It is null or from [`new_handle`], and nobody uses it any more.
pub(crate) unsafe fn free<H: Handle>(handle: *mut H) {
    if !handle.is_null() {
        // SAFETY: the caller's word.
        let owned = unsafe { Box::from_raw(handle) };
        // A drop that panics must not reach C either.
        let _ = catch_unwind(AssertUnwindSafe(|| drop(owned)));
    }
}

/// What a handle stands for, alone for the time of the call.
///
/// # Safety
/// The handle is null or from [`new_handle`] and was not freed.
pub(crate) unsafe fn locked<'h, H: Handle + 'h>(
    handle: *const H,
    what: &str,
) -> Result<MutexGuard<'h, H::Inside>, Failure> {
    // SAFETY: the caller's word.
    let Some(handle) = (unsafe { handle.as_ref() }) else {
        return Err(Failure::invalid(format!("the {what} is a null pointer")));
    };
    handle.lock().lock().map_err(|_| Failure {
        status: Status::Internal,
        text: format!(
            "the {what} cannot be used any more: goldtof made a mistake in an earlier call"
        ),
    })
}

/// The text that a pointer stands for.
///
/// # Safety
/// It is null or a text that ends with a zero byte.
pub(crate) unsafe fn text<'t>(pointer: *const c_char, what: &str) -> Result<&'t str, Failure> {
    if pointer.is_null() {
        return Err(Failure::invalid(format!("{what} is a null pointer")));
    }
    // SAFETY: the caller's word.
    let bytes = unsafe { CStr::from_ptr(pointer) };
    bytes.to_str().map_err(|error| Failure::invalid(format!("{what} is not UTF-8: {error}")))
}

/// The array that a pointer stands for; an empty one with null, if that is allowed.
///
/// # Safety
/// It is null or has `length` elements.
pub(crate) unsafe fn array<'a, T>(
    pointer: *const T,
    length: usize,
    what: &str,
) -> Result<&'a [T], Failure> {
    if pointer.is_null() {
        return match length {
            0 => Ok(&[]),
            _ => Err(Failure::invalid(format!("{what} is a null pointer"))),
        };
    }
    // SAFETY: the caller's word.
    Ok(unsafe { std::slice::from_raw_parts(pointer, length) })
}

fn words_of(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    text.unwrap_or("without a reason").to_owned()
}
