#!/usr/bin/env bash
# A Python 3.11 with Cyclone DDS, Pillow and websockets in the folder named: the wheel of cyclonedds 11 is for CPython 3.11.
set -euo pipefail
venv=${1:?a folder for Python packages}
if "$venv/bin/python" -c 'import cyclonedds, PIL, websockets' 2>/dev/null; then exit 0; fi
found=
for python in python3.11 "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.11.*/bin/python3.11; do
  if "$python" -c 'import venv, ensurepip' 2>/dev/null; then found=$python && break; fi
done
if [ -z "$found" ]; then
  apt-get -qq update
  DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends python3.11-venv
  found=python3.11
fi
"$found" -m venv "$venv"
"$venv/bin/pip" -q install 'cyclonedds>=11,<12' 'pillow>=10,<14' 'websockets>=13,<18'
