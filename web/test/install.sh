#!/usr/bin/env bash
# Installs what the tests of the page need, from Debian: Chromium, and a compiler for WebAssembly where rustup's has no such target.
set -euo pipefail
packages=()
command -v "${CHROMIUM:-chromium}" >/dev/null || packages+=(chromium)
libraries=$(rustc --print target-libdir --target wasm32-unknown-unknown)
[ -d "$libraries" ] || packages+=(rustc-web cargo-web rust-web-src lld)
[ ${#packages[@]} -eq 0 ] && exit
apt-get -qq update
DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends "${packages[@]}"
