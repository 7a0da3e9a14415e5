use super::super::{Sequence, discover};
use super::{DataPack, is_there, pack, set_name};
use std::path::{Path, PathBuf};

fn excerpts() -> PathBuf {
    dpn_testing::repository().join("tests/data")
}

fn packed(dir: &Path) -> PathBuf {
    let out = dir.join("set.dpn");
    pack(&excerpts(), &out).unwrap();
    out
}

#[test]
fn a_sequence_of_a_pack_is_that_of_the_folder_to_the_bit() {
    let dir = tempfile::tempdir().unwrap();
    let out = packed(dir.path());
    let (from, of) = (discover(&excerpts()).unwrap(), discover(&out).unwrap());
    assert_eq!(from.len(), of.len());
    let sums = |s: &Sequence| s.checksums().into_iter().map(Result::unwrap).collect::<Vec<_>>();
    for (a, b) in from.iter().zip(&of) {
        assert_eq!((a.name(), a.short_name()), (b.name(), b.short_name()));
        assert_eq!(a.imu().unwrap(), b.imu().unwrap());
        assert_eq!(a.imu_config().unwrap(), b.imu_config().unwrap());
        assert_eq!(a.camera_config().unwrap(), b.camera_config().unwrap());
        assert_eq!(a.ground_truth().unwrap(), b.ground_truth().unwrap());
        assert_eq!(a.has_camera_frames(), b.has_camera_frames());
        if a.has_camera_frames() {
            let frames = a.camera_frames().unwrap();
            assert_eq!(frames, b.camera_frames().unwrap());
            assert_eq!(
                a.image_path(&frames[0]).canonicalize().ok(),
                b.image_path(&frames[0]).canonicalize().ok()
            );
        }
        assert_eq!(sums(a), sums(b));
        assert_eq!(Sequence::open(b.dir()).unwrap().name(), a.name());
    }
    let again = dir.path().join("again.dpn");
    pack(&excerpts(), &again).unwrap();
    assert_eq!(std::fs::read(&out).unwrap(), std::fs::read(&again).unwrap());
}

#[test]
fn a_folder_of_a_pack_is_found_as_one_on_disk() {
    let dir = tempfile::tempdir().unwrap();
    let out = packed(dir.path());
    let below: Vec<_> = std::fs::read_dir(excerpts())
        .unwrap()
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name())
        .filter(|name| discover(&excerpts().join(name)).is_ok())
        .collect();
    assert!(!below.is_empty());
    for name in below {
        let names = |dir: &Path| {
            discover(&dir.join(&name)).unwrap().iter().map(|s| s.name().to_owned()).collect::<Vec<_>>()
        };
        assert!(is_there(&out.join(&name)));
        assert_eq!(names(&out), names(&excerpts()));
    }
    assert!(is_there(&out) && !is_there(&out.join("nothing")));
    assert_eq!(set_name(&out).as_deref(), Some("data"));
    let error = discover(&out.join("nothing")).unwrap_err().to_string();
    assert!(error.contains("set.dpn/nothing") && error.contains("the pack holds"), "{error}");
    let several = Sequence::open(&out).unwrap_err().to_string();
    assert!(several.contains("looked for one sequence; the pack holds"), "{several}");
}

#[test]
fn a_pack_says_what_is_in_it_and_what_is_damaged_by_its_part() {
    let dir = tempfile::tempdir().unwrap();
    let out = packed(dir.path());
    let whole = DataPack::open(&out).unwrap();
    let parts = whole.parts();
    let samples =
        parts.iter().find(|part| part.sequence.contains("V1_01") && part.file == "imu0/data.csv").unwrap();
    assert_eq!((samples.rows, samples.bytes), (Some(800), 800 * 56));
    assert!(whole.faults().unwrap().is_empty());
    let mut bytes = std::fs::read(&out).unwrap();
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    std::fs::write(&out, bytes).unwrap();
    let faults = DataPack::open(&out).unwrap().faults().unwrap();
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert!(faults[0].to_string().contains("is damaged: its checksum does not fit"));
    // The other parts are still of use.
    assert!(discover(&out).unwrap().iter().filter(|s| s.imu().is_ok()).count() >= 2);
}

#[test]
fn what_is_no_folder_is_not_packed_and_what_is_no_pack_is_not_read() {
    let dir = tempfile::tempdir().unwrap();
    let out = packed(dir.path());
    assert!(pack(&out, &dir.path().join("twice.dpn")).unwrap_err().to_string().contains("no folder"));
    let text = dir.path().join("notes.txt");
    std::fs::write(&text, "some words that are no pack").unwrap();
    let error = discover(&text).unwrap_err();
    assert!(error.to_string().ends_with("a file of another kind, where a data pack is needed"), "{error}");
    assert!(error.hint().unwrap().contains("dpn data pack"));
}
