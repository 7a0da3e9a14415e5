//! `cargo xtask book`: the numbers of README, book and `docs/targets.csv` written anew from `docs/results` and the study's tables.
//!
//! `cargo xtask web [--out DIR]`: the page in the browser, one HTML file that holds everything.
//!
//! dpn-web is compiled to WebAssembly, wasm-bindgen writes what JavaScript needs to call it, and both are put into `web/page/index.html` beside
//! its style and scripts: the WebAssembly packed by gzip, which browsers unpack. So the file works from any server and from a folder.

mod page;
mod toolchain;

use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};

fn main() -> Result<()> {
    let mut args = std::env::args().skip(1);
    let root =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().context("the project's folder")?;
    let mut out = root.join("target/web/page");
    match args.next().as_deref() {
        Some("web") => {}
        Some("book") => return book(&root),
        other => bail!("{}: known are `web [--out DIR]` and `book`", other.unwrap_or("no task")),
    }
    while let Some(arg) = args.next() {
        match (arg.as_str(), args.next()) {
            ("--out", Some(dir)) => out = PathBuf::from(dir),
            _ => bail!("`{arg}`: known is `--out DIR`"),
        }
    }
    let wasm = toolchain::compile(&root)?;
    let page = page::assemble(&root.join("web"), &wasm)?;
    std::fs::create_dir_all(&out).with_context(|| out.display().to_string())?;
    let file = out.join("index.html");
    std::fs::write(&file, &page).with_context(|| file.display().to_string())?;
    println!(
        "{}: {} kB, {} kB as a server packs it",
        file.display(),
        page.len() / 1000,
        page::packed(page.as_bytes())?.len() / 1000
    );
    Ok(())
}

/// The tests that hold the numbers write them where they are asked to: twice, for the page of targets is made of marked ones.
fn book(root: &Path) -> Result<()> {
    for bless in [true, true, false] {
        let mut cargo = std::process::Command::new("cargo");
        cargo.args(["test", "--quiet", "-p", "dpn-book"]).current_dir(root);
        if bless {
            cargo.env("DPN_BLESS", "1");
        }
        if !cargo.status().context("cargo")?.success() {
            bail!("the book's tests say what is missing");
        }
    }
    Ok(())
}
