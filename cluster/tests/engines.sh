#!/usr/bin/env bash
# A sweep of simulated flights in twelve shards by Slurm, HyperQueue, GNU parallel and Snakemake: each collected run is the single machine's, byte for byte but for the times that rows tell.
# cluster/tests/engines.sh DPN VENV. An engine that is not installed is named and left out; where CI is true it is required.
set -euo pipefail
export DPN
DPN=$(realpath "${1:?the program}")
venv=$(realpath "${2:?a folder with Python packages, see install.sh}")
here=$(cd "$(dirname "$0")" && pwd)
cluster=$(dirname "$here")
work=$(mktemp -d)
# shellcheck source-path=SCRIPTDIR
. "$here/slurm_loopback.sh"
slurm_dir=
finish() {
  [ -z "$slurm_dir" ] || slurm_stop
  rm -rf "$work"
}
trap finish EXIT

missing() {
  echo "engine not tested, $1 is not installed (cluster/tests/install.sh)" >&2
  [ "${CI:-}" != true ] || exit 1
}

# The same plan by one process, and as it is planned for twelve shards.
cp "$here/flights.toml" "$work/plan.toml"
"$DPN" sweep plan "$work/plan.toml" --shards 1 --out "$work/alone" >/dev/null
"$DPN" sweep run "$work/alone" --shard 0
"$DPN" sweep collect "$work/alone" --out "$work/single" >/dev/null
planned() {
  "$DPN" sweep plan "$work/plan.toml" --shards 12 --out "$work/$1" >/dev/null
}
# A run without what times it: three keys of a row, the tables that print them.
untimed() {
  rm -rf "$1-untimed"
  cp -r "$1" "$1-untimed"
  rm -f "$1-untimed"/closed_loop.*
  python3 - "$1-untimed/rows.jsonl" <<'PYTHON'
import json, sys
rows = [json.loads(line) for line in open(sys.argv[1])]
for row in rows:
    for key in ["cpu_per_data_s", "p95_update_ms", "stage_s"]:
        del row[key]
assert len(rows) == 24, len(rows)
open(sys.argv[1], "w").writelines(json.dumps(row) + "\n" for row in rows)
PYTHON
}
equal() {
  untimed "$work/$1-run"
  diff -r "$work/single-untimed" "$work/$1-run-untimed"
  echo "$1: the single machine's bytes"
}
same() {
  "$DPN" sweep collect "$work/$1" --out "$work/$1-run" >/dev/null
  equal "$1"
}
untimed "$work/single"

if command -v slurmctld-wlm munged >/dev/null; then
  planned slurm
  slurm_start "$work/cluster"
  "$cluster/slurm/submit.sh" "$work/slurm" --chdir "$work"
  # In the middle, and early in a shard: its node dies while it works.
  on_node() { squeue -h -t running -w dpn1 -o %K; }
  until [ -n "$(on_node)" ]; do sleep 0.05; done
  first=$(on_node)
  until dying=$(on_node) && [ -n "$dying" ] && [ "$dying" != "$first" ]; do sleep 0.05; done
  sleep 0.2
  slurm_kill_node dpn1
  echo "slurm: node dpn1 is dead while it works on shard $dying"
  for ((i = 0; i < 600; i++)); do
    [ -n "$(squeue -h)" ] || break
    # A requeued job waits two minutes by default; here it need not.
    squeue -h -t pending -o '%F_%K %r' | awk '$2 == "BeginTime" { print $1 }' | xargs -r -I{} scontrol update JobId={} StartTime=now
    sleep 0.2
  done
  grep -q "requeue job .* due to failure of node dpn1" "$slurm_dir/log/slurmctld.log"
  # A shard's file is damaged: it is named, with the command that makes it again.
  damaged=$(ls "$work"/slurm/shards/5/rows.jsonl)
  sed -i '1s/"ate/"eta/' "$damaged"
  if "$DPN" sweep collect "$work/slurm" --out "$work/slurm-run" 2>"$work/refused"; then
    echo "a damaged shard was collected" >&2
    exit 1
  fi
  grep -q -- "--shard 5" "$work/refused"
  "$DPN" sweep run "$work/slurm" --shard 5
  same slurm
  slurm_stop
  slurm_dir=
else
  missing "slurm-wlm or munge"
fi

if "$venv/bin/python" -c 'import hyperqueue' 2>/dev/null; then
  planned hyperqueue
  "$venv/bin/python" "$cluster/hyperqueue/sweep.py" "$work/hyperqueue" --workers 2
  same hyperqueue
else
  missing hyperqueue
fi

if command -v parallel >/dev/null; then
  planned parallel
  "$cluster/parallel/sweep.sh" "$work/parallel" --jobs 2
  same parallel
else
  missing parallel
fi

if [ -x "$venv/bin/snakemake" ]; then
  planned snakemake
  "$venv/bin/snakemake" --quiet all --directory "$work/smk" --snakefile "$cluster/snakemake/Snakefile" --config sweep="$work/snakemake" out="$work/snakemake-run" --cores 2
  equal snakemake
else
  missing snakemake
fi
