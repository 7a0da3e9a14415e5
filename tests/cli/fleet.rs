//! `dpn fleet`.

use crate::run::{dpn, end};
use std::path::Path;

const PLAN: &str = "constants = [\"x1\", \"x4\"]\nnoises = [\"self\"]\n\
    [[platform]]\nname = \"a spiral\"\nfolder = \"spiral\"\n[platform.run]\nsequences = \"room-spiral\"\nfrom = 70.0\nto = 80.0\n\
    [[platform]]\nname = \"a room\"\nfolder = \"room\"\n[platform.run]\nsequences = \"room-medium\"\nfrom = 70.0\nto = 80.0\n";

fn fleet(dir: &Path, plan: &str, more: &[&str]) -> crate::run::Done {
    let file = dir.join("fleet.toml");
    std::fs::create_dir_all(dir).unwrap();
    std::fs::write(&file, plan).unwrap();
    end(dpn().arg("fleet").arg(file).arg("--out").arg(dir.join("out")).args(more))
}

#[test]
fn platforms_are_run_one_after_another_and_scored_together() {
    let tmp = tempfile::tempdir().unwrap();
    let said = fleet(tmp.path(), PLAN, &["--json"]).well().json();
    let platforms = said["platforms"].as_array().unwrap();
    assert_eq!(
        platforms.iter().map(|p| p["name"].as_str().unwrap()).collect::<Vec<_>>(),
        ["a spiral", "a room"]
    );
    // The rows are those of a closed loop, and the score is of them.
    for (platform, folder) in platforms.iter().zip(["spiral", "room"]) {
        let rows = std::fs::read_to_string(tmp.path().join("out").join(folder).join("rows.jsonl")).unwrap();
        let ate = |noise: &str| {
            let row = rows.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
            row.filter(|row| row["noise"] == noise)
                .map(|row| row["ate_se3"].as_f64().unwrap())
                .next()
                .unwrap()
        };
        let best = ate("x1").min(ate("x4"));
        let score = platform["noises"][2]["score"].as_f64().unwrap();
        assert!((score - ate("self") / best).abs() < 1e-12, "{score}");
    }
    // A second call runs nothing and has the same files.
    let table = |name: &str| std::fs::read(tmp.path().join("out").join(name)).unwrap();
    let before = ["fleet.csv", "fleet.json", "fleet.txt"].map(table);
    let again = fleet(tmp.path(), PLAN, &[]).well();
    assert!(again.stderr.contains("3 kept from") && again.stdout.contains("single constant"), "{again:?}");
    assert_eq!(["fleet.csv", "fleet.json", "fleet.txt"].map(table), before);
}

#[test]
fn what_cannot_be_run_is_said_before_anything_is() {
    let tmp = tempfile::tempdir().unwrap();
    let refused = |plan: &str, more: &[&str], words: &str| {
        let done = fleet(tmp.path(), plan, more);
        assert_eq!((done.code, done.stdout.as_str()), (Some(2), ""), "{done:?}");
        assert!(done.stderr.contains(words), "no `{words}` in {}", done.stderr);
        assert!(!tmp.path().join("out").exists());
    };
    refused(PLAN, &["--platforms", "rom"], "the plan has no platform `rom`");
    refused(&PLAN.replace("room-medium", "rom"), &[], "rom");
    refused(&PLAN.replace("\"x1\", \"x4\"", "\"self\""), &[], "`constants` is self");
    refused(&PLAN.replace("folder = \"room\"", "folder = \"spiral\""), &[], "`platform[1].folder` is spiral");
    let recorded = PLAN.replace("sequences = \"room-medium\"", "data = \"euroc\"");
    refused(&recorded, &["--data", "nowhere"], "nowhere/euroc does not exist");
}

#[test]
fn a_fleet_in_shards_has_nothing_left_to_run() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    std::fs::write(dir.join("fleet.toml"), format!("kind = \"fleet\"\n{PLAN}")).unwrap();
    let call = |line: &str| end(dpn().current_dir(dir).args(line.split(' '))).well();
    call("sweep plan fleet.toml --shards 3 --out s");
    call("sweep run s --shard all");
    call("sweep collect s --out out");
    let said = call("fleet fleet.toml --out out");
    assert_eq!(said.stderr.matches("3 kept from").count(), 2, "{}", said.stderr);
    let alone = fleet(&dir.join("alone"), PLAN, &[]).well();
    assert_eq!(said.stdout.lines().next(), alone.stdout.lines().next());
    let table = |dir: &Path| std::fs::read(dir.join("out/fleet.csv")).unwrap();
    assert_eq!(table(dir), table(&dir.join("alone")));
}
