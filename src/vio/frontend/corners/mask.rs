//! Where a new corner may be.

use dpn_core::GrayView;

/// A byte a pixel: 0 where no corner may be.
#[derive(Debug, Clone, Default)]
pub struct Mask {
    width: usize,
    height: usize,
    free: Vec<u8>,
    /// Half widths of a disc's rows, from its middle on, for `radius`.
    spans: Vec<usize>,
    radius: f64,
}

impl Mask {
    /// Every pixel of an image of this size is free.
    pub fn free(width: usize, height: usize) -> Self {
        let mut mask = Self::default();
        mask.reset(width, height, None);
        mask
    }

    /// Begins anew, from `allowed` (0 where no corner may ever be) where it is given and of this size.
    pub fn reset(&mut self, width: usize, height: usize, allowed: Option<GrayView<'_>>) {
        (self.width, self.height) = (width, height);
        self.free.clear();
        match allowed.filter(|view| (view.width(), view.height()) == (width, height)) {
            Some(view) => {
                view.rows()
                    .for_each(|row| self.free.extend(row.iter().map(|v| if *v == 0 { 0 } else { 255 })));
            }
            None => self.free.resize(width * height, 255),
        }
    }

    /// Takes all pixels nearer than `radius` to `centre`; one that is no number takes none.
    pub(crate) fn take_disc(&mut self, centre: [f32; 2], radius: f64) {
        if self.radius != radius {
            self.radius = radius;
            let square = radius * radius;
            self.spans = (0..)
                .map(|dy| square - f64::from(dy) * f64::from(dy))
                .take_while(|rest| *rest > 0.0)
                // The largest dx with dx^2 below the rest.
                .map(|rest| rest.sqrt().ceil() as usize - 1)
                .collect();
        }
        let [x, y] = centre.map(|c| c.round() as isize);
        if !(centre[0].is_finite() && centre[1].is_finite()) {
            return;
        }
        for (dy, &half) in self.spans.iter().enumerate() {
            let half = half as isize;
            let from = (x - half).clamp(0, self.width as isize) as usize;
            let to = (x + half + 1).clamp(0, self.width as isize) as usize;
            let rows = [y - dy as isize, y + dy as isize];
            for row in rows.into_iter().filter(|row| (0..self.height as isize).contains(row)) {
                self.free[row as usize * self.width..][..self.width][from..to].fill(0);
            }
        }
    }

    /// Whether a corner may be at column `x` and row `y`.
    pub(crate) fn is_free(&self, x: usize, y: usize) -> bool {
        x < self.width && y < self.height && self.free[y * self.width + x] != 0
    }

    /// Row `y`: 255 where a corner may be, else 0.
    pub(super) fn row(&self, y: usize) -> &[u8] {
        &self.free[y * self.width..][..self.width]
    }

    pub(super) fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::GrayImage;

    #[test]
    fn a_disc_takes_what_is_nearer_than_its_radius() {
        for radius in [1.0, 2.5, 5.0, 13.0] {
            for centre in [[20.0f32, 15.0], [1.0, 28.0], [-3.0, 10.0], [1e9, 0.0]] {
                let mut mask = Mask::free(40, 30);
                mask.take_disc(centre, radius);
                for y in 0..30 {
                    for x in 0..40 {
                        let far = (x as f64 - f64::from(centre[0])).powi(2)
                            + (y as f64 - f64::from(centre[1])).powi(2);
                        assert_eq!(mask.is_free(x, y), far >= radius * radius, "{radius} {centre:?} {x} {y}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_never_allowed_stays_taken() {
        let allowed = GrayImage::from_fn(10, 5, |x, _| u8::from(x > 3)).unwrap();
        let mut mask = Mask::default();
        mask.reset(10, 5, Some(allowed.view()));
        assert!(!mask.is_free(3, 2) && mask.is_free(4, 2) && !mask.is_free(10, 2));
        mask.take_disc([f32::NAN, 2.0], 5.0);
        assert!(mask.is_free(4, 2));
    }
}
