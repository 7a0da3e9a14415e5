//! Images nobody wants. Nothing panics, every image is accounted for, and no track is made up.

use super::super::*;
use super::wall::{Wall, pose, stamp, turn};
use dpn_core::random::Stream;
use dpn_core::{GrayImage, Stamp};
use nalgebra::UnitQuaternion;
use rand::Rng;

struct Flight {
    wall: Wall,
    front_end: FrontEnd,
    /// Frame of the last image fed.
    last: usize,
}

impl Flight {
    fn new(seed: u64) -> Self {
        let mut config = FrontEndConfig::default();
        config.corners.distance_px = 20.0;
        let wall = Wall::new(seed);
        let front_end = FrontEnd::new(wall.camera, config, &Stream::new(1)).unwrap();
        Self { wall, front_end, last: 0 }
    }

    fn image(&self, i: usize) -> GrayImage {
        self.wall.image(&pose(i), i as u64)
    }

    /// Feeds this image as frame `i`'s, with the gyroscope's turn since the last.
    fn feed(&mut self, i: usize, image: &GrayImage) -> Fed {
        let turned = turn(&pose(self.last), &pose(i));
        self.last = i;
        self.front_end.feed(image.view(), stamp(i), Some(&turned))
    }

    fn feed_true(&mut self, i: usize) -> Fed {
        let image = self.image(i);
        self.feed(i, &image)
    }

    fn warm_up(&mut self, n: usize) -> usize {
        (0..n).map(|i| self.feed_true(i)).last().map_or(0, |fed| fed.report.kept)
    }
}

fn even(width: usize, height: usize, grey: u8) -> GrayImage {
    GrayImage::from_fn(width, height, |_, _| grey).unwrap()
}

#[test]
fn one_black_white_or_even_image_is_bridged() {
    for grey in [0, 255, 128] {
        let mut flight = Flight::new(1);
        let before = flight.warm_up(7);
        let fed = flight.feed(7, &even(376, 240, grey));
        assert_eq!((fed.report.status, fed.frame), (Status::Blind, None));
        assert_eq!(fed.report.kept, fed.report.before);
        let fed = flight.feed_true(8);
        assert!(fed.report.kept * 10 > before * 8, "{grey}: {} of {before}", fed.report.kept);
    }
}

#[test]
fn five_seconds_of_darkness_end_all_tracks_and_the_light_brings_new_ones() {
    let mut flight = Flight::new(2);
    let before = flight.warm_up(7);
    let highest = flight.front_end.feed(flight.image(7).view(), stamp(7), None).report.before;
    assert!(highest >= before);
    flight.last = 7;
    let mut lost = 0;
    for i in 8..108 {
        // Noise in the dark: no two images are alike.
        let dark = GrayImage::from_fn(376, 240, |x, y| ((x * 31 + y * 17 + i * 7) % 3) as u8).unwrap();
        let fed = flight.feed(i, &dark);
        assert_eq!((fed.report.status, fed.frame), (Status::Blind, None));
        lost += fed.report.lost_by(LostBy::Blind);
        // .3 s are bridged: seven images may pass.
        assert_eq!(fed.report.kept == 0, i > 13, "image {i}");
    }
    assert!(lost > 40);
    let fed = flight.feed_true(108);
    let frame = fed.frame.unwrap();
    assert!(frame.tracks.len() > 40 && fed.report.kept == 0);
    assert!(frame.tracks.iter().all(|track| track.id >= lost as u64), "no number comes back");
}

#[test]
fn a_lens_cap_at_the_start_gives_nothing_until_it_is_off() {
    let mut flight = Flight::new(3);
    for i in 0..40 {
        let fed = flight.feed(i, &even(376, 240, (i % 2) as u8));
        assert_eq!((fed.report.status, fed.report.lost.len(), fed.frame), (Status::Blind, 0, None));
    }
    assert!(flight.feed_true(40).frame.is_some_and(|frame| frame.tracks.len() > 40));
}

#[test]
fn a_repeated_image_says_nothing_of_its_time() {
    let mut flight = Flight::new(4);
    let before = flight.warm_up(7);
    let image = flight.image(7);
    flight.feed(7, &image);
    let fed = flight.feed(8, &image);
    assert_eq!((fed.report.status, fed.frame), (Status::Repeated, None));
    let fed = flight.feed_true(9);
    assert!(fed.report.kept * 10 > before * 8 && fed.frame.is_some(), "{:?}", fed.report);

    // Frozen for two seconds: the tracks end, and a moving camera is not said to be at rest.
    let image = flight.image(9);
    for i in 10..50 {
        let fed = flight.feed(i, &image);
        assert_eq!((fed.report.status, fed.frame), (Status::Repeated, None));
        assert_eq!(fed.report.kept == 0, i > 15, "image {i}");
    }
    assert!(flight.feed_true(50).frame.is_some());
}

#[test]
fn a_jump_in_exposure_costs_few_tracks() {
    for (gain, offset) in [(0.5, 0.0), (1.25, -15.0), (0.6, 70.0)] {
        let mut flight = Flight::new(6);
        let before = flight.warm_up(7);
        (flight.wall.gain, flight.wall.offset) = (gain, offset);
        let fed = flight.feed_true(7);
        assert!(fed.report.kept * 10 > before * 8, "gain {gain}: {} of {before}", fed.report.kept);
    }
}

#[test]
fn a_third_of_the_images_lost_is_survived() {
    let mut flight = Flight::new(7);
    let mut handed = 0;
    for i in (0..60).filter(|i| i % 3 != 1) {
        let fed = flight.feed_true(i);
        handed += usize::from(fed.frame.is_some());
        if i > 6 {
            assert!(fed.report.kept * 10 > fed.report.before * 7, "frame {i}: {:?}", fed.report);
        }
    }
    assert!((25..=31).contains(&handed), "{handed} handed over in 3 s at 10 Hz");
}

#[test]
fn images_of_another_size_and_out_of_order_are_named_and_passed_over() {
    let mut flight = Flight::new(8);
    let before = flight.warm_up(7);
    let fed = flight.feed(7, &even(752, 480, 90));
    assert_eq!(fed.report.status, Status::WrongSize { width: 752, height: 480 });
    assert_eq!((fed.frame, fed.report.image), (None, None));
    for late in [stamp(7), stamp(3), Stamp::from_ns(i64::MIN)] {
        let fed = flight.front_end.feed(flight.image(3).view(), late, None);
        assert_eq!(fed.report.status, Status::OutOfOrder { last_ns: stamp(7).ns() });
        assert_eq!((fed.frame, fed.report.kept), (None, fed.report.before));
    }
    let fed = flight.feed_true(8);
    assert!(fed.report.kept * 10 > before * 8, "{:?}", fed.report);
}

#[test]
fn after_a_long_pause_nothing_is_tracked_across() {
    let mut flight = Flight::new(9);
    flight.warm_up(7);
    let fed = flight.feed_true(60);
    assert_eq!((fed.report.kept, fed.report.lost_by(LostBy::Blind)), (0, fed.report.before));
    assert!(fed.frame.is_some_and(|frame| frame.tracks.len() > 40));
}

#[test]
fn a_gyroscope_that_lies_or_is_no_number_does_no_harm() {
    for wrong in [0.05, f64::NAN, 3.0] {
        let mut flight = Flight::new(10);
        let before = flight.warm_up(7);
        let axis = nalgebra::Vector3::new(0.0, wrong, 0.0);
        let turned = if wrong.is_nan() {
            UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(f64::NAN, 0.0, 0.0, 0.0))
        } else {
            UnitQuaternion::from_scaled_axis(axis)
        };
        let mut kept = 0;
        for i in 7..10 {
            let image = flight.image(i);
            kept = flight.front_end.feed(image.view(), stamp(i), Some(&turned)).report.kept;
        }
        assert!(kept * 10 > before * 6, "{wrong}: {kept} of {before}");
    }
}

#[test]
fn pure_noise_leaves_no_old_track() {
    let mut flight = Flight::new(11);
    flight.warm_up(7);
    let mut kept = 0;
    for i in 7..13 {
        let mut rng = Stream::new(i as u64).rng();
        let noise = GrayImage::from_fn(376, 240, |_, _| rng.random());
        kept = flight.feed(i, &noise.unwrap()).report.kept;
    }
    assert!(kept <= 5, "{kept} tracks go on in noise");
}
