#!/usr/bin/env bash
# Submits every shard of a planned sweep as one job array: cluster/slurm/submit.sh SWEEP [what else sbatch is to be told].
# Time limits come from the plan. DPN names the program where it is not on the PATH.
set -euo pipefail
sweep=$(realpath "${1:?a sweep, as made by \`dpn sweep plan\`}")
shift
dpn=${DPN:-dpn}
read -r shards longest_s < <("$dpn" sweep status "$sweep" --limits)
# Three times the longest shard's predicted time and ten minutes: nodes differ, and a shard that is ended goes on where it was.
minutes=$(((longest_s * 3 + 599) / 60 + 10))
SWEEP=$sweep DPN=$dpn sbatch --parsable --array="0-$((shards - 1))" --time="$minutes" "$@" "$(dirname "$0")/sweep.sbatch"
