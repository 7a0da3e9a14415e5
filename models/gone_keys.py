"""Takes keys that are gone since 0.2.0 out of the headers of weights and checkpoints that an older `dpn` wrote: each had the one value it was ever given.

usage: python models/gone_keys.py FILE.safetensors...      (in place; the numbers and their checksum stay as they are)
"""
import json
import pathlib
import struct
import sys

GONE = ['"draws":"epoch",', '"edges":"zero",', '"rescale_output":false,', '"scope":"window",', '"standardise":"none",', '"symmetrise":false,']

for path in map(pathlib.Path, sys.argv[1:]):
    data = path.read_bytes()
    (length,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8 : 8 + length])
    text = header["__metadata__"]["dpn"]
    for key in GONE:
        text = text.replace(key, "")
    header["__metadata__"]["dpn"] = text
    out = json.dumps(header, separators=(",", ":"), ensure_ascii=False).encode()
    out += b" " * (-len(out) % 8)
    path.write_bytes(struct.pack("<Q", len(out)) + out + data[8 + length :])
