#!/usr/bin/env bash
# Every warning and finding of the program on recordings that are as they should be: eleven of EuRoC, four of TUM-VI, real images, eleven
# simulated flights. From the repository's root, with the data packs in data/; writes golden/warnings/warnings.txt, a line a warning. Each line
# must be true: docs/src/your-log.md says of every kind why it is.
set -euo pipefail
cd "$(dirname "$0")/../.."
dpn=${DPN:-target/release/dpn}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
told=golden/warnings/warnings.txt
: >"$told"
say() { sed "s|^|$1: |" >>"$told"; }
# What the doctor finds above `good`, and the warnings of the others.
look() { # NAME LOG
  "$dpn" check "$2" --out "$out/check" --json | jq -r '.findings[] | select(.weight != "good" and .weight != "note") | "\(.weight) \(.about): \(.text)"' | say "check $1"
  "$dpn" noise "$2" --out "$out/noise" --json 2>/dev/null | jq -r '.warnings[]' | say "noise $1"
}
run() { # NAME SOURCE FLAGS
  local name=$1 source=$2
  shift 2
  "$dpn" run "$source" --noise x4 --out "$out/run" "$@" 2>&1 >/dev/null | say "run $name${*:+ $*}"
}
for dir in data/euroc/* data/motion/* data/images/*; do
  look "$(basename "$dir")" "$dir"
  run "$(basename "$dir")" "$dir"
done
for dir in data/euroc/*; do
  run "$(basename "$dir")" "$dir" --camera rendered
done
for dir in data/tumvi/*; do
  look "$(basename "$dir")" "$dir"
  run "$(basename "$dir")" "$dir" --camera tracks
done
for log in data/static/*.csv; do
  "$dpn" check "$log" --out "$out/check" --json 2>/dev/null | jq -r '.findings[] | select(.weight != "good" and .weight != "note") | "\(.weight) \(.about): \(.text)"' | say "check $(basename "$log")"
done
"$dpn" simulate flight --list | while read -r flight _; do
  "$dpn" simulate flight "$flight" --out "$out/flights" >/dev/null
  look "$flight" "$out/flights/$flight"
  run "$flight" "$out/flights/$flight"
done
wc -l "$told"
