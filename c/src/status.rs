//! What a call came to, and its words.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What a call came to.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// All is well.
    Ok = 0,
    /// A pointer that must not be null is.
    NullArgument = 1,
    /// A value that cannot be taken.
    BadArgument = 2,
    /// A handle that was never given out, or was freed.
    UnknownHandle = 3,
    /// A file or bytes that are no network of dpn's.
    BadWeights = 4,
    /// A fault of dpn itself; the object it happened in should be freed.
    Panic = 5,
    /// Settings or a calibration that cannot be used.
    BadSettings = 6,
    /// Nothing to give yet: no fault, there are no words.
    NotYet = 7,
}

/// A call's fault: code and words.
#[derive(Debug)]
pub(crate) struct Fault(pub(crate) Status, pub(crate) String);

impl Fault {
    pub(crate) fn bad(words: impl Into<String>) -> Self {
        Self(Status::BadArgument, words.into())
    }
}

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
    static SAID: RefCell<CString> = RefCell::default();
}

fn zero_ended(words: &str) -> CString {
    CString::new(words.replace('\0', " ")).unwrap_or_default()
}

/// Keeps words until this is called again on this thread; a thread at its end keeps none.
pub(crate) fn kept(words: &str) -> *const c_char {
    let words = zero_ended(words);
    SAID.try_with(|said| {
        said.replace(words);
        said.borrow().as_ptr()
    })
    .unwrap_or(c"".as_ptr())
}

/// Runs a call; its fault becomes the thread's last error.
pub(crate) fn call(work: impl FnOnce() -> Result<(), Fault>) -> Status {
    let done = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        Err(Fault(Status::Panic, "a fault of dpn itself; please report what was called".to_owned()))
    });
    let (status, words) = match done {
        Ok(()) => (Status::Ok, String::new()),
        Err(Fault(status, words)) => (status, words),
    };
    let words = zero_ended(&words);
    // At a thread's end there is nobody to tell.
    let _ = LAST.try_with(|last| last.replace(words));
    status
}

/// Words on the last call of this thread that took a status; empty where all was well. They last until the thread's next call.
#[unsafe(no_mangle)]
pub extern "C" fn dpn_last_error() -> *const c_char {
    LAST.try_with(|last| last.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

/// The version of this library, for example "0.1.0"; lasts for ever.
#[unsafe(no_mangle)]
pub extern "C" fn dpn_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    CStr::from_bytes_with_nul(VERSION.as_bytes()).unwrap_or_default().as_ptr()
}
