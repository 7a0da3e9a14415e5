//! What rooms and halls are furnished with: draws, skins, boxes, and what fits where.

use super::super::texture::Material;
use super::course::Course;
use super::rect::{Rect, Skin, Slab};
use nalgebra::Vector3;
use rand::Rng;

/// Nothing comes nearer to the box of the flight than this \[m\].
pub(super) const CLEARANCE_M: f64 = 0.45;

/// How often each material is met.
pub(super) type Mix = [(Material, f64)];

/// Figures that depend on the kind of world.
pub(super) struct Scale {
    /// Texels a metre.
    pub(super) texels_per_m: f64,
    /// Mean and half width of the logarithm of surfaces' tones.
    pub(super) tone: [f64; 2],
    /// Light from everywhere, beside a lamp's 1.
    pub(super) ambient: f64,
    /// Contrast of textures.
    pub(super) contrast: f64,
    /// Mean relief of a panel \[m\].
    pub(super) relief: f64,
    /// Sides of the fields that walls are divided in \[m\].
    pub(super) field: [f64; 2],
    /// Floor that one box or one mat has for itself \[m^2\].
    pub(super) thing_area: f64,
}

/// A world while it is furnished.
pub(super) struct Builder<'a, R> {
    pub(super) low: Vector3<f64>,
    pub(super) high: Vector3<f64>,
    pub(super) course: &'a Course,
    pub(super) scale: Scale,
    pub(super) contrast: f32,
    /// Share of the walls' fields that show nothing but paint.
    pub(super) bare: f64,
    pub(super) rects: Vec<Rect>,
    pub(super) lamps: Vec<Rect>,
    pub(super) rng: &'a mut R,
}

impl<R: Rng> Builder<'_, R> {
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.rng.random::<f64>()
    }

    pub(super) fn chance(&mut self, share: f64) -> bool {
        self.rng.random::<f64>() < share
    }

    /// Whether the next surface is bare; without bare ones no chance is drawn, so that worlds stay as they were.
    pub(super) fn is_bare(&mut self) -> bool {
        self.bare > 0.0 && self.chance(self.bare)
    }

    /// Nothing but paint, where the next surface is bare.
    pub(super) fn painted(&mut self) -> Option<Skin> {
        self.is_bare().then(|| self.of(Material::Plain))
    }

    pub(super) fn skin(&mut self, mix: &Mix) -> Skin {
        let all: f64 = mix.iter().map(|(_, share)| share).sum();
        let mut draw = all * self.rng.random::<f64>();
        let mut material = mix[0].0;
        for (candidate, share) in mix {
            if draw < *share {
                material = *candidate;
                break;
            }
            draw -= share;
        }
        self.of(material)
    }

    pub(super) fn of(&mut self, material: Material) -> Skin {
        let offset = [self.rng.random::<f32>() * 1024.0, self.rng.random::<f32>() * 1024.0];
        let [mean, spread] = self.scale.tone;
        let tone = (mean + spread * (self.rng.random::<f64>() - 0.5) * 2.0).exp() as f32;
        Skin::at(material, offset, tone, self.contrast)
    }

    /// Another piece of the same surface.
    fn shifted(&mut self, skin: &Skin) -> Skin {
        let offset = [self.rng.random::<f32>() * 1024.0, self.rng.random::<f32>() * 1024.0];
        Skin { fineness: skin.fineness, ..Skin::at(skin.material, offset, skin.tone, skin.contrast) }
    }

    /// A box whose faces share a skin.
    pub(super) fn slab(&mut self, slab: &Slab, hidden: &[(usize, bool)], skin: &Skin) {
        let skins: Vec<Skin> = (0..6).map(|_| self.shifted(skin)).collect();
        self.rects.extend(slab.faces(hidden, |axis, far| skins[2 * axis + usize::from(far)]));
    }

    /// Whether a rectangle on the floor lies within the walls.
    pub(super) fn inside(&self, origin: &Vector3<f64>, axes: &[Vector3<f64>; 3], [a, b]: [f64; 2]) -> bool {
        [(0.0, 0.0), (a, 0.0), (0.0, b), (a, b)].iter().all(|(u, v)| {
            let corner = origin + *u * axes[0] + *v * axes[1];
            (0..2).all(|i| (self.low[i]..=self.high[i]).contains(&corner[i]))
        })
    }

    /// How high a thing on the floor may be, given its middle and how far it reaches from there \[m\].
    pub(super) fn headroom(&self, place: &Vector3<f64>, reach: f64) -> f64 {
        let flight = &self.course.bounds;
        let beside = (0..2).any(|i| {
            place[i] + reach < flight.low[i] - CLEARANCE_M || place[i] - reach > flight.high[i] + CLEARANCE_M
        });
        if beside { 0.8 * (self.high.z - self.low.z) } else { flight.low.z - CLEARANCE_M - self.low.z }
    }
}

/// Axes of a thing that stands on the floor.
pub(super) fn upright(turn: f64) -> [Vector3<f64>; 3] {
    let (sin, cos) = turn.sin_cos();
    [Vector3::new(cos, sin, 0.0), Vector3::new(-sin, cos, 0.0), Vector3::z()]
}
