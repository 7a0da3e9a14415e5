#!/usr/bin/env bash
# Installs what the tests of engines need: Slurm, munge and GNU parallel from Debian, HyperQueue and Snakemake from Python's registry into the folder named.
set -euo pipefail
venv=${1:?a folder for Python packages}
if ! command -v slurmctld-wlm munged parallel >/dev/null; then
  apt-get -qq update
  DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends slurm-wlm munge parallel procps
fi
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/pip" -q install 'hyperqueue>=0.20,<1' 'snakemake>=8,<10'
