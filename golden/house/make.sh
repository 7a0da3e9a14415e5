#!/usr/bin/env bash
# Checksums of what the program makes: trajectories on given tracks, on rendered and on real images, with noise that is constant, learned and from networks;
# weights after two epochs of both default configurations; every text file of `dpn paper --quick`; what is said of a log. A change that is to move no result
# leaves them as they are.
# usage: make.sh DPN DATA OUT     writes OUT/SHA256SUMS; compare with SHA256SUMS beside this script
set -euo pipefail
dpn=$(realpath "$1") data=$(realpath "$2") out=$3 study=$(realpath "$(dirname "$0")/../../papers/networks")
mkdir -p "$out" && cd "$out"
"$dpn" eval --closed-loop --data "$data" --camera tracks --tracks "$data/tracks" --from table --noise x1 \
  --trajectories --out tracks >tracks.txt
"$dpn" eval --closed-loop --data "$data" --camera rendered --sequences V1_01,V2_02,MH_03 --from 0 --to 25 --noise x1 --seed 1 \
  --trajectories --out rendered >rendered.txt
"$dpn" eval --closed-loop --data "$data" --camera tracks --tracks "$data/tracks" --from table --sequences V1_01,V2_02,MH_03 \
  --noise "self,dualpronet,sg(11,2),mean(self)" --trajectories --out noises >noises.txt
"$dpn" run "$data/motion/MH_01_easy_start" --camera images --noise self --out run >run.txt
mkdir -p log
"$dpn" noise "$data/euroc/V1_02_medium" --out log --json >log/noise.json
"$dpn" check "$data/euroc/V1_02_medium" --out log --json >log/check.json
"$dpn" allan "$data/static/adis16405_imu1.csv" --out log --json >log/allan.json
for sensor in accel gyro; do
  "$dpn" train --sensor $sensor --data "$data" --epochs 2 --out train-$sensor >/dev/null
done
mkdir -p papers && ln -sfn "$study" papers/networks
"$dpn" paper --quick --work work --out quick >quick.txt
# The program's own checksum, ids made from it, and times differ by build and by machine: they are blanked.
DATA=$data python3 - <<'P' >SHA256SUMS
import hashlib, os, pathlib, re
def line(path, data): print(hashlib.sha256(data).hexdigest(), path)
for path in sorted(p for folder in ("tracks", "rendered", "noises", "run") for p in pathlib.Path(folder).rglob("*.tum")):
    line(path, path.read_bytes())
for path in sorted(pathlib.Path(".").glob("train-*/*.safetensors")):
    if path.stem != "checkpoint": line(path, path.read_bytes())
for path in sorted(pathlib.Path("log").glob("*.json")): line(path, path.read_text().replace(os.environ["DATA"], "DATA").encode())
for path in sorted(pathlib.Path("quick").rglob("*")):
    # The page holds the table of times too; its other numbers are those of the tables beside it.
    if path.suffix in {".csv", ".md", ".tex", ".svg"} and path.stem != "timing":
        text = path.read_text()
        text = re.sub(r"\b[0-9a-f]{12,64}\b", "ID", text)
        line(path, text.encode())
P
