//! A sweep's folder that others can write to: its files are the input's parts between bytes of 0xff, which no text has.
#![no_main]

use dpn_eval::sweeps::{SweepFolder, collect, status};
use dpn_io::ResultPath;
use libfuzzer_sys::fuzz_target;

const FILES: [&str; 6] = [
    "sweep.json",
    "shards/0/shard.json",
    "shards/0/rows.jsonl",
    "shards/0/failed.jsonl",
    "shards/0/running.json",
    "shards/1/shard.json",
];

fuzz_target!(|bytes: &[u8]| {
    let Ok(tmp) = tempfile::tempdir() else { return };
    let dir = tmp.path().join("sweep");
    for (name, part) in FILES.into_iter().zip(bytes.split(|b| *b == 0xff)) {
        let path = dir.join(name);
        let folder = path.parent().expect("every file is in a folder");
        if std::fs::create_dir_all(folder).and_then(|()| std::fs::write(&path, part)).is_err() {
            return;
        }
    }
    let Ok(folder) = SweepFolder::open(&ResultPath::from(&dir)) else { return };
    let _ = status(&folder);
    let _ = collect(&folder, &ResultPath::from(tmp.path().join("out")), true);
    let beside = std::fs::read_dir(tmp.path()).expect("it is there");
    assert!(beside.flatten().all(|entry| entry.file_name() == "sweep" || entry.file_name() == "out"));
});
