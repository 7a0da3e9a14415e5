//! Lists the shipped networks of `models/` for the binary to carry, and with the feature `page` lays the page in the browser beside them.

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
    let out = PathBuf::from(env::var("OUT_DIR").unwrap_or_default());
    fs::write(out.join("shipped.rs"), code)?;
    if env::var_os("CARGO_FEATURE_PAGE").is_some() { page(&out) } else { Ok(()) }
}

/// The page that `cargo xtask web` made, in its usual place or where `DPN_WEB` says.
fn page(out: &Path) -> io::Result<()> {
    println!("cargo::rerun-if-env-changed=DPN_WEB");
    let usual = || Path::new(&env::var("CARGO_MANIFEST_DIR").unwrap_or_default()).join("target/web/page");
    let page = env::var_os("DPN_WEB").map_or_else(usual, PathBuf::from).join("index.html");
    println!("cargo::rerun-if-changed={}", page.display());
    if let Err(error) = fs::copy(&page, out.join("page.html")) {
        println!("cargo::error=the feature `page`: {}: {error}; `cargo xtask web` makes it", page.display());
    }
    Ok(())
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
