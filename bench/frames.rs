//! Images for the benches of the front-end: the real ones of a camera at rest, rolled so that they seem to move.

use dpn_core::GrayImage;
use dpn_io::ImageFolder;
use dpn_io::asl::Sequence;
use std::path::{Path, PathBuf};

/// Images there are.
pub const COUNT: usize = 40;

/// How far image `i` is rolled, to the right and down \[px\]: up to 9 and 6 px an image.
pub fn roll_of(i: usize) -> [i64; 2] {
    let turn = |period: f64| (std::f64::consts::TAU * i as f64 / period).sin();
    [(60.0 * turn(40.0)).round() as i64, (25.0 * turn(25.0)).round() as i64]
}

/// The first `n` images, rolled; without the data, a pattern as large, and a word on stderr.
pub fn rolling(n: usize) -> Vec<GrayImage> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let data = std::env::var_os("DPN_DATA").map_or_else(|| root.join("data"), PathBuf::from);
    let real = Sequence::open(&data.join("images/V1_01_easy_static"))
        .and_then(|sequence| ImageFolder::open(&sequence))
        .and_then(|folder| (0..n.min(folder.len())).map(|i| Ok(folder.read(i)?.image)).collect());
    let images: Vec<GrayImage> = real.unwrap_or_else(|error| {
        eprintln!("skipped: no data ({error}); a pattern is used instead");
        (0..n).filter_map(|i| GrayImage::from_fn(752, 480, |x, y| pattern(x, y, i)).ok()).collect()
    });
    images.iter().enumerate().filter_map(|(i, image)| rolled(image, roll_of(i))).collect()
}

fn pattern(x: usize, y: usize, i: usize) -> u8 {
    let hash = |x: usize, y: usize| (x * 7919 + y * 104_729).wrapping_mul(2_654_435_761) >> 13;
    (80 + hash(x / 13, y / 11) % 90 + hash(x + i, y * 3) % 3) as u8
}

fn rolled(image: &GrayImage, [dx, dy]: [i64; 2]) -> Option<GrayImage> {
    let (width, height) = (image.width(), image.height());
    let from = |at: usize, shift: i64, side: usize| (at as i64 - shift).rem_euclid(side as i64) as usize;
    let pixel = |x, y| image.pixels()[from(y, dy, height) * width + from(x, dx, width)];
    GrayImage::from_fn(width, height, pixel).ok()
}
