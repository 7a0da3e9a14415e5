//! Folders as they compare.

use std::collections::BTreeMap;
use std::path::Path;

/// Every file under `dir` by its relative path.
pub fn files(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    fn collect(root: &Path, dir: &Path, out: &mut BTreeMap<String, Vec<u8>>) {
        for entry in std::fs::read_dir(dir).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                collect(root, &path, out);
            } else {
                let name = path.strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/");
                out.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    let mut out = BTreeMap::new();
    collect(dir, dir, &mut out);
    out
}

/// Leaves of every `data.csv` under `dir`, an ASL folder, the rows from `from` to before `to` s after its first.
pub fn cut_asl(dir: &Path, from: f64, to: f64) {
    for (name, bytes) in files(dir) {
        if !name.ends_with("data.csv") {
            continue;
        }
        let text = String::from_utf8(bytes).unwrap();
        let mut first = None;
        let kept = text.split_inclusive('\n').filter(|line| {
            let Ok(ns) = line.split(',').next().unwrap().parse::<i64>() else { return true };
            let at = (ns - *first.get_or_insert(ns)) as f64 * 1e-9;
            (from..to).contains(&at)
        });
        std::fs::write(dir.join(name), kept.collect::<String>()).unwrap();
    }
}
