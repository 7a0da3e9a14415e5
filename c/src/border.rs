//! Pointers of the caller's: each is looked at once, by one of these.

use crate::status::{Fault, Status};
use dpn_core::{GrayView, ImuSample, Stamp};
use std::ffi::{CStr, c_char};

/// More points than any frame shows: a count that was never set makes no room.
const MOST_VALUES: usize = 1 << 20;

fn null(name: &str, expected: &str) -> Fault {
    Fault(Status::NullArgument, format!("`{name}` is null; expected {expected}"))
}

/// A text that ends with a zero.
///
/// # Safety
/// `text` is null or points to a string that ends with a zero and does not change during the call.
pub(crate) unsafe fn text<'a>(name: &str, text: *const c_char) -> Result<&'a str, Fault> {
    if text.is_null() {
        return Err(null(name, "a string that ends with a zero"));
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
        return Err(null(name, "bytes"));
    }
    if isize::try_from(length).is_err() {
        return Err(Fault::bad(format!("`{name}` has {length} bytes; no array is as long")));
    }
    // SAFETY: not null, no longer than an array can be, and the caller promised the rest.
    Ok(unsafe { std::slice::from_raw_parts(bytes, length) })
}

/// So many values; null where there are none. Unaligned ones are read too.
///
/// # Safety
/// `values` is null or points to `count` values.
pub(crate) unsafe fn values<T: Copy>(name: &str, values: *const T, count: usize) -> Result<Vec<T>, Fault> {
    if count == 0 {
        return Ok(Vec::new());
    }
    if values.is_null() {
        return Err(null(name, "an array"));
    }
    if count > MOST_VALUES {
        return Err(Fault::bad(format!("`{name}` has {count} values; expected {MOST_VALUES} at most")));
    }
    // SAFETY: not null, and the caller promised so many; `add` stays within them.
    Ok((0..count).map(|i| unsafe { values.add(i).read_unaligned() }).collect())
}

/// A sample: angular rate \[rad/s\] and specific force \[m/s^2\].
///
/// # Safety
/// `gyro` and `accel` are null or point to three doubles each.
pub(crate) unsafe fn sample(t_ns: i64, gyro: *const f64, accel: *const f64) -> Result<ImuSample, Fault> {
    // SAFETY: as the caller promised.
    let (gyro, accel) = unsafe { (axes("gyro", gyro)?, axes("accel", accel)?) };
    Ok(ImuSample { t: Stamp::from_ns(t_ns), gyro, accel })
}

/// The rows of a grey image, `stride` bytes apart.
///
/// # Safety
/// `pixels` is null or points to `height` rows that begin `stride` bytes apart, of `width` bytes each, and do not change during the call.
pub(crate) unsafe fn image<'a>(
    pixels: *const u8,
    [width, height, stride]: [usize; 3],
) -> Result<GrayView<'a>, Fault> {
    let length = height.checked_sub(1).and_then(|rows| stride.checked_mul(rows)?.checked_add(width));
    let length = length.ok_or_else(|| {
        Fault::bad(format!("an image of {width} x {height} px, {stride} bytes from row to row"))
    })?;
    // Before it is looked at: rows that overlap reach farther than was promised.
    if stride < width {
        return Err(Fault::bad(format!(
            "`stride` is {stride}; expected the {width} bytes of a row at least"
        )));
    }
    // SAFETY: as the caller promised.
    let bytes = unsafe { bytes("pixels", pixels, length)? };
    GrayView::new(width, height, stride, bytes).map_err(|error| Fault::bad(error.to_string()))
}

/// Three finite numbers.
///
/// # Safety
/// `axes` is null or points to three doubles.
unsafe fn axes(name: &str, axes: *const f64) -> Result<[f64; 3], Fault> {
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
