//! Who compiles for WebAssembly here: rustup's target, or Debian's toolchain with the standard library's source.

use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

const TARGET: &str = "wasm32-unknown-unknown";
/// Where Debian's packages put theirs.
const CARGO: &str = "/usr/bin/cargo";
const RUSTC: &str = "/usr/bin/rustc";
const LINKER: &str = "/usr/bin/wasm-ld";
const SOURCE: &str = "/usr/lib/rustlib/src/rust/library/std";

const MISSING: &str = "nothing here compiles for WebAssembly\n\nhint: `rustup target add wasm32-unknown-unknown`; \
    or on Debian `apt install rustc-web cargo-web rust-web-src lld`";

/// Compiles dpn-web; returns its WebAssembly as the compiler leaves it.
pub fn compile(root: &Path) -> Result<PathBuf> {
    let target = root.join("target/web");
    let mut cargo = if has_target() {
        Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
    } else if [CARGO, RUSTC, LINKER, SOURCE].iter().all(|path| Path::new(path).exists()) {
        let mut cargo = Command::new(CARGO);
        cargo
            .env("RUSTC", RUSTC)
            .env("RUSTC_BOOTSTRAP", "1")
            .env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", LINKER);
        // What rustup sets for its own compiler.
        cargo.env_remove("RUSTUP_TOOLCHAIN").env_remove("LD_LIBRARY_PATH");
        cargo.args(["-Z", "build-std=std,panic_abort"]);
        cargo
    } else {
        bail!(MISSING);
    };
    let done = cargo
        .current_dir(root)
        .args(["build", "--package", "dpn-web", "--lib", "--profile", "web", "--target", TARGET])
        .arg("--target-dir")
        .arg(&target)
        .status()
        .context("cargo cannot be started")?;
    if !done.success() {
        bail!("dpn-web does not compile for {TARGET}");
    }
    Ok(target.join(TARGET).join("web/dpn_web.wasm"))
}

/// Whether the compiler at hand has the target's standard library.
fn has_target() -> bool {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let out = Command::new(rustc).args(["--print", "target-libdir", "--target", TARGET]).output();
    out.is_ok_and(|out| {
        out.status.success() && Path::new(String::from_utf8_lossy(&out.stdout).trim()).is_dir()
    })
}
