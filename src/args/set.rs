//! A flag over a configuration's key.

/// Puts a flag that was typed over a configuration's key.
pub(super) fn set<T: Copy>(flag: Option<T>, key: &mut T) {
    *key = flag.unwrap_or(*key);
}
