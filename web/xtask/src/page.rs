//! The page's parts, put into one file.

use anyhow::{Context, Result};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write as _;
use std::path::Path;
use wasm_bindgen_cli_support::Bindgen;

/// Puts style, scripts, WebAssembly and example into `page/index.html`.
pub fn assemble(web: &Path, wasm: &Path) -> Result<String> {
    let mut bindings = Bindgen::new()
        .input_path(wasm)
        .no_modules(true)?
        .typescript(false)
        .remove_name_section(true)
        .remove_producers_section(true)
        .generate_output()?;
    let wasm = bindings.wasm_mut().emit_wasm();
    let read = |name: &str| {
        let path = web.join("page").join(name);
        std::fs::read_to_string(&path).with_context(|| path.display().to_string())
    };
    let mut page = read("index.html")?;
    let worker = format!("{}\n{}", bindings.js(), read("worker.js")?);
    let scripts =
        ["plot.js", "page.js", "study.js"].map(read).into_iter().collect::<Result<Vec<_>>>()?.join("\n");
    // A recorded log for those who have none at hand.
    let example = web.join("../tests/data/euroc/V1_01_easy/mav0/imu0/data.csv");
    let example = std::fs::read(&example).with_context(|| example.display().to_string())?;
    for (place, text) in [
        ("/*STYLE*/", read("style.css")?),
        ("/*WORKER*/", worker),
        ("/*PAGE*/", scripts),
        ("WASM_GZIP_BASE64", STANDARD.encode(packed(&wasm)?)),
        ("EXAMPLE_GZIP_BASE64", STANDARD.encode(packed(&example)?)),
    ] {
        page = page.replacen(place, &text, 1);
    }
    Ok(page)
}

/// By gzip, as well as it can.
pub fn packed(bytes: &[u8]) -> Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes)?;
    Ok(encoder.finish()?)
}
