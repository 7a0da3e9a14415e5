//! What a browser, or somebody else, sends to `dpn page`.
#![no_main]

#[allow(dead_code)]
#[path = "../../src/cmd/http.rs"]
mod http;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut fields = [httparse::EMPTY_HEADER; http::FIELDS];
    let Ok(asked) = http::asked(bytes, &mut fields) else { return };
    let length = bytes.len() as u64;
    if let Some((from, to)) = asked.range.and_then(|range| http::range(range, length)) {
        assert!(from <= to && to < length);
    }
});
