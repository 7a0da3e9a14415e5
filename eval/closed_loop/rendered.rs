//! Images rendered along a path while they are looked at, so that the whole pipeline runs where no image can be had.

use super::error::{ClosedLoopError, OfSequence};
use super::images::ImageStream;
use super::recording::Span;
use super::sequence_fault::SequenceFault;
use dpn_core::Stamp;
use dpn_io::Prefetch;
use dpn_sim::RenderedCamera;
use dpn_sim::render::{RenderConfig, SharedPath};

/// Images rendered ahead of the front-end.
const AHEAD: usize = 4;

/// What a camera sees along `path` at those of `stamps` at which the path is known, from the first of them as far as `span` says; rendered
/// on a second thread, a few images ahead.
///
/// # Errors
/// Settings or a lens that cannot be rendered; no stamp on the path within `span`.
pub(super) fn rendered(
    sequence: &str,
    config: &RenderConfig,
    path: SharedPath,
    stamps: &[Stamp],
    seed: u64,
    span: &Span,
) -> Result<ImageStream<'static>, ClosedLoopError> {
    let mut camera = RenderedCamera::new(config, path, seed).of_sequence(sequence)?;
    let known: Vec<Stamp> = stamps.iter().copied().filter(|t| camera.takes(*t)).collect();
    let asked = span.of(&known, |t| *t).to_vec();
    if asked.is_empty() {
        return Err(SequenceFault::NoImages { asked: !known.is_empty() }.of(sequence));
    }
    Ok(Box::new(Prefetch::spawn(AHEAD, move |send| {
        let mut image = |t| camera.image(t).expect("only stamps at which the path is known were asked for");
        let _all_sent = asked.into_iter().all(|t| send((t, Ok(image(t)))));
    })))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_sim::Flight;
    use dpn_sim::flight::FlightPlan;
    use dpn_sim::tracks::{AnalyticPath, CameraSettings};
    use dpn_sim::tracks::{Bounds, CameraPath};
    use nalgebra::Isometry3;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    fn config() -> RenderConfig {
        let camera = CameraSettings {
            resolution: [94, 60],
            intrinsics: [57.3, 57.2, 45.9, 31.0],
            ..CameraSettings::default()
        };
        RenderConfig { camera: Some(camera), ..RenderConfig::default() }
    }

    /// A path that breaks, once it may.
    struct Breaks {
        path: SharedPath,
        at: Stamp,
        now: Arc<AtomicBool>,
    }

    impl CameraPath for Breaks {
        fn world_from_body(&self, t: Stamp) -> Option<Isometry3<f64>> {
            assert!(t < self.at || !self.now.load(Ordering::Relaxed), "broken at {t}");
            self.path.world_from_body(t)
        }

        fn pieces(&self) -> Vec<(Stamp, Stamp)> {
            self.path.pieces()
        }

        fn bounds(&self) -> Bounds {
            self.path.bounds()
        }
    }

    #[test]
    fn a_renderer_that_breaks_does_not_look_like_the_end_of_the_images() {
        let plan = FlightPlan::new(Flight::Hover, 1);
        let stamps: Vec<Stamp> = (0..20).map(|i| Stamp::from_ns(50_000_000 * i)).collect();
        let now = Arc::new(AtomicBool::new(false));
        let path: SharedPath = Arc::new(Breaks {
            path: Arc::new(AnalyticPath::new(plan.trajectory, stamps[0])),
            at: stamps[10],
            now: now.clone(),
        });
        let mut images = rendered("hover", &config(), path, &stamps, 3, &Span::from(0.0)).unwrap();
        // A few images are made ahead before it breaks.
        now.store(true, Ordering::Relaxed);
        let rest = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| images.by_ref().count()));
        assert!(rest.is_err(), "{rest:?} images as if that were all");
    }

    #[test]
    fn images_come_in_order_within_the_span_counted_from_the_first_on_the_path() {
        let start = Stamp::from_ns(1_000_000_000);
        let plan = FlightPlan::new(Flight::Hover, 1);
        let path: SharedPath = Arc::new(AnalyticPath::new(plan.trajectory, start));
        // The camera began a second before the path is known.
        let stamps: Vec<Stamp> = (0..100).map(|i| Stamp::from_ns(50_000_000 * i)).collect();
        let of =
            |from_s, to_s| rendered("hover", &config(), path.clone(), &stamps, 3, &Span { from_s, to_s });
        let images: Vec<_> = of(0.5, Some(1.0)).unwrap().collect();
        let seconds: Vec<f64> = images.iter().map(|(t, _)| t.seconds_since(start)).collect();
        assert_eq!(images.len(), 11);
        assert!((seconds[0] - 0.5).abs() < 1e-9 && (seconds[10] - 1.0).abs() < 1e-9, "{seconds:?}");
        // The same image whatever came before it; one that is dropped early ends too.
        let mut later = of(0.75, None).unwrap();
        assert_eq!(later.next().unwrap().1.unwrap(), *images[5].1.as_ref().unwrap());
        drop(later);
        let error = of(100.0, None).err().map(|error| error.to_string());
        assert_eq!(error.as_deref(), Some("hover: it has no images in the part that is to be run"));
        let bad = RenderConfig { contrast: -1.0, ..config() };
        let error = rendered("hover", &bad, path.clone(), &stamps, 3, &Span::from(0.0)).err().unwrap();
        assert_eq!(error.to_string(), "hover: nothing can be rendered: `contrast` is -1, but must be 0 to 2");
    }
}
