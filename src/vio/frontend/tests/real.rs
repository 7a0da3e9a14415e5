//! On the real images of a camera at rest.

use super::super::*;
use dpn_core::camera::PinholeRadtan;
use dpn_core::io::ImageFolder;
use dpn_core::io::asl::Sequence;
use dpn_core::random::Stream;
use nalgebra::Vector2;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn sequence() -> Option<Sequence> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let data = std::env::var_os("DPN_DATA").map_or_else(|| root.join("data"), PathBuf::from);
    let folder = data.join("images/V1_01_easy_static");
    if folder.is_dir() {
        return Some(Sequence::open(&folder).unwrap());
    }
    eprintln!("skipped: no data ({} is not there)", folder.display());
    None
}

#[test]
fn a_camera_at_rest_keeps_its_tracks_and_they_stay_where_they_are() {
    let Some(sequence) = sequence() else { return };
    let camera = PinholeRadtan::try_from(&sequence.camera_config().unwrap().unwrap()).unwrap();
    let folder = ImageFolder::open(&sequence).unwrap();
    assert!(folder.coverage().is_complete() && folder.len() == 40);
    let mut front_end = FrontEnd::new(camera, FrontEndConfig::default(), &Stream::new(1)).unwrap();
    let mut seen: BTreeMap<u64, Vec<Vector2<f64>>> = BTreeMap::new();
    let (mut lost, mut before) = (0, 0);
    for image in folder.prefetch(2) {
        let image = image.unwrap();
        let fed = front_end.feed(image.image.view(), image.t, None);
        lost += fed.report.lost.len();
        before += fed.report.before;
        for track in fed.frame.into_iter().flat_map(|frame| frame.tracks) {
            seen.entry(track.id).or_default().push(track.px);
        }
    }
    // Second differences take out what the vehicle and a track drift; white scatter makes them sqrt(6) as large.
    let mut squares = Vec::new();
    for places in seen.values() {
        for three in places.windows(3) {
            squares.push((three[0] - 2.0 * three[1] + three[2]).norm_squared() / (2.0 * 6.0));
        }
    }
    squares.sort_by(f64::total_cmp);
    let median = (squares[squares.len() / 2] / 0.693).sqrt();
    let all = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    let long = seen.values().filter(|places| places.len() == 20).count();
    eprintln!(
        "scatter a side: {median:.4} px by the median, {all:.4} px RMS; {long} of {} tracks live on; {lost} of {before} lost",
        seen.len()
    );
    assert!(median < 0.05, "{median} px");
    assert!(lost * 100 < before, "{lost} of {before} lost");
    assert!(long > 100, "{long} tracks in all frames");
}
