//! The header that is checked in is the one that cbindgen makes; `DPN_BLESS=1` writes it.

use std::path::Path;

#[test]
fn the_header_is_that_of_the_sources() {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(dir.join("cbindgen.toml")).expect("cbindgen.toml is there");
    let mut builder = cbindgen::Builder::new().with_config(config);
    for file in ["status", "table", "weights", "stream", "level", "odometry", "gyro_bias"] {
        builder = builder.with_src(dir.join("src").join(file).with_extension("rs"));
    }
    let mut made = Vec::new();
    builder.generate().expect("the sources can be read").write(&mut made);
    let made = String::from_utf8(made).expect("a header is text");
    let path = dir.join("include/dpn.h");
    if std::env::var_os("DPN_BLESS").is_some() {
        std::fs::write(&path, &made).expect("the header can be written");
    }
    let there = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(there == made, "c/include/dpn.h is stale: DPN_BLESS=1 cargo test -p dpn-c --test header");
}
