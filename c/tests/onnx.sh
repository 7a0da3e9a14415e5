#!/usr/bin/env bash
# The C++ example on ONNX Runtime: compiled against its headers, run on its library, held to dpn's own answers.
# c/tests/onnx.sh DPN FOLDER. FOLDER is filled where it is empty: headers of Debian's libonnxruntime-dev, the library out of Python's wheel of the same version
# (Debian's own wants a newer C library than older systems have). Elsewhere ORT may name a folder with include/ and lib/.
set -euo pipefail
dpn=$(realpath "${1:?the program}")
mkdir -p "${2:?a folder to fill}"
folder=$(realpath "$2")
cd "$(dirname "$0")/../.."

if [ -z "${ORT:-}" ]; then
  export ORT=$folder/ort
  if ! [ -e "$ORT/lib/libonnxruntime.so" ]; then
    rm -rf "$ORT" "$folder/apt"
    mkdir -p "$folder/apt/lists/partial" "$folder/apt/archives/partial"
    # The mirror that this machine uses, with a release that has the package.
    mirror=$(apt-get indextargets --format '$(SITE)' | grep '/debian$' | head -1)
    echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] ${mirror:?no Debian mirror among the sources of apt} trixie main" >"$folder/apt/sources.list"
    # Lists of its own: nothing of the machine's is changed.
    apt=(-qq -o "Dir::Etc::sourcelist=$folder/apt/sources.list" -o Dir::Etc::sourceparts=/dev/null -o "Dir::State::lists=$folder/apt/lists" -o "Dir::Cache=$folder/apt")
    apt-get "${apt[@]}" update
    (cd "$folder/apt" && apt-get "${apt[@]}" download libonnxruntime-dev)
    dpkg -x "$folder"/apt/libonnxruntime-dev_*.deb "$folder/apt/headers"
    mkdir -p "$ORT/lib"
    cp -r "$folder/apt/headers/usr/include/onnxruntime" "$ORT/include"
    api=$(sed -n 's/^#define ORT_API_VERSION \([0-9]*\)$/\1/p' "$ORT/include/onnxruntime_c_api.h")
    python3 -m pip -q download --no-deps --only-binary :all: --python-version 3.11 --platform "manylinux_2_28_$(uname -m)" -d "$folder/apt" "onnxruntime==1.$api.*"
    python3 -m zipfile -e "$folder"/apt/onnxruntime-*.whl "$folder/apt/wheel"
    # Found by this name when the program starts, linked by the other.
    cp "$folder"/apt/wheel/onnxruntime/capi/libonnxruntime.so.1.* "$ORT/lib/libonnxruntime.so.1"
    ln -s libonnxruntime.so.1 "$ORT/lib/libonnxruntime.so"
    rm -rf "$folder/apt"
  fi
fi

export DPN_ONNX=$folder/onnx
rm -rf "$DPN_ONNX"
"$dpn" export onnx --network sg11-s0 --out "$DPN_ONNX"
# With the features of the whole workspace, so that what its tests have built is used.
cargo test --workspace --test cpp --locked -- --ignored
