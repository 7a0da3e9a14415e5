#!/usr/bin/env bash
# Works a planned sweep off with GNU parallel: cluster/parallel/sweep.sh SWEEP [what else parallel is to be told].
# On this machine's cores as it stands; over ssh with `--sshlogin host1,host2 --workdir .` where the sweep's folder is seen under the same path.
# A shard that failed is tried once more; what is finished is not run again.
set -euo pipefail
sweep=$(realpath "${1:?a sweep, as made by \`dpn sweep plan\`}")
shift
dpn=${DPN:-dpn}
read -r shards _ < <("$dpn" sweep status "$sweep" --limits)
seq 0 $((shards - 1)) | parallel --retries 2 --line-buffer --tag "$@" "$dpn" sweep run "$sweep" --shard {} --threads 1
