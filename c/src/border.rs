//! Pointers of the caller's: each is looked at once, by one of these.

use crate::status::{Fault, Status};
use std::ffi::{CStr, c_char};

fn null(name: &str, expected: &str) -> Fault {
    Fault(Status::NullArgument, format!("`{name}` is null; expected {expected}"))
}

/// A text that ends with a zero.
///
/// # Safety
/// `text` is null or points to a string that ends with a zero and does not change during the call.
pub(crate) unsafe fn text<'a>(name: &str, text: *const c_char) -> Result<&'a str, Fault> {
    if text.is_null() {
        return Err(null(name, "a path as a string"));
    }
    // SAFETY: not null, and the caller promised the rest.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|_| Fault::bad(format!("`{name}` is no UTF-8")))
}

/// So many bytes.
///
/// # Safety
/// `bytes` is null or points to `length` bytes that do not change during the call.
pub(crate) unsafe fn bytes<'a>(name: &str, bytes: *const u8, length: usize) -> Result<&'a [u8], Fault> {
    if bytes.is_null() {
        return Err(null(name, "a network's bytes"));
    }
    if isize::try_from(length).is_err() {
        return Err(Fault::bad(format!("`length` is {length}; no array is as long")));
    }
    // SAFETY: not null, no longer than an array can be, and the caller promised the rest.
    Ok(unsafe { std::slice::from_raw_parts(bytes, length) })
}

/// Three finite numbers.
///
/// # Safety
/// `axes` is null or points to three doubles.
pub(crate) unsafe fn axes(name: &str, axes: *const f64) -> Result<[f64; 3], Fault> {
    if axes.is_null() {
        return Err(null(name, "three doubles: x, y, z"));
    }
    // SAFETY: not null, and the caller promised three doubles; unaligned ones are read too.
    let values = unsafe { axes.cast::<[f64; 3]>().read_unaligned() };
    match values.iter().all(|v| v.is_finite()) {
        true => Ok(values),
        false => Err(Fault::bad(format!("`{name}` is {values:?}; expected three finite numbers"))),
    }
}

/// Where a result goes, checked before there is one.
pub(crate) struct Out<T>(*mut T);

impl<T> Out<T> {
    /// # Safety
    /// `out` is null or may be written to until the call returns.
    pub(crate) unsafe fn new(name: &str, out: *mut T) -> Result<Self, Fault> {
        if out.is_null() {
            return Err(null(name, "where to write the result"));
        }
        Ok(Self(out))
    }

    pub(crate) fn write(self, value: T) {
        // SAFETY: `new` checked that it is not null, and was promised that it may be written to; what was there needs no drop.
        unsafe { self.0.write_unaligned(value) }
    }
}
