//! Lists the shipped networks of `models/` for the binary to carry.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let models = Path::new(&env::var("CARGO_MANIFEST_DIR").unwrap_or_default()).join("models");
    println!("cargo::rerun-if-changed={}", models.display());
    let mut files = Vec::new();
    collect(&models, &mut files)?;
    files.sort();
    let mut code =
        String::from("/// Name and bytes of each shipped network.\nstatic SHIPPED: &[(&str, &[u8])] = &[\n");
    for file in &files {
        let name = file.strip_prefix(&models).unwrap_or(file);
        let _ =
            writeln!(code, "    (r\"models/{}\", include_bytes!(r\"{}\")),", name.display(), file.display());
    }
    code.push_str("];\n");
    fs::write(Path::new(&env::var("OUT_DIR").unwrap_or_default()).join("shipped.rs"), code)
}

fn collect(dir: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(dir)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else if path.extension().is_some_and(|e| e == "safetensors") {
            files.push(path);
        }
    }
    Ok(())
}
