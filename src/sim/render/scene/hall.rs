//! What a machine hall has and a room has not: dark, things near the flight's course, thin things, and what the body stood on.

use super::super::texture::Material;
use super::builder::{Builder, Mix, Scale, upright};
use super::course::Rest;
use super::rect::{Skin, Slab};
use nalgebra::Vector3;
use rand::Rng;

/// Tone of a pallet's boards in the light, of the deck below them, of a heap's net; how many times finer than the hall's the texels of
/// the grain and of the deck are: the deck's holes repeat every 26 mm. These, and tones, light and contrast of [`scale`], are fitted on
/// the first 8.5 s of the real images of MH_01 (`compare_cameras`).
const PALLET_TONE: f64 = 1.6;
const DECK_TONE: f64 = 0.22;
const NET_TONE: f64 = 3.2;
const GRAIN_FINENESS: f64 = 10.0;
const DECK_FINENESS: f64 = 5.0;

/// The body's origin above what it stands on \[m\].
const BODY_M: f64 = 0.1;

const MACHINES: &Mix = &[
    (Material::Clutter, 0.3),
    (Material::Grating, 0.25),
    (Material::Blocks, 0.1),
    (Material::Cloth, 0.2),
    (Material::Planks, 0.15),
];

/// The hall's figures; `relief` as the tracks' hall has it \[m\].
pub(super) fn scale(relief: f64) -> Scale {
    Scale {
        texels_per_m: 125.0,
        tone: [-0.25, 1.0],
        ambient: 0.6,
        contrast: 1.5,
        relief,
        field: [1.6, 4.0],
        thing_area: 7.0,
    }
}

impl<R: Rng> Builder<'_, R> {
    /// Things beside the course, bars in the air, and a pallet wherever the body stood.
    pub(super) fn furnish(&mut self) {
        self.machines();
        for rest in self.course.rests.clone() {
            self.stand(&rest);
        }
    }

    /// How high a thing may stand that reaches so far from `place` \[m above the floor\].
    fn room_below(&self, place: &Vector3<f64>, reach: f64, clearance: f64) -> f64 {
        let lowest = self.course.lowest(place, reach + clearance);
        lowest.map_or(0.8 * (self.high.z - self.low.z), |lowest| lowest - clearance - self.low.z)
    }

    /// Machines as near as the course lets them stand, and railings.
    fn machines(&mut self) {
        let size = self.high - self.low;
        let count = (size.x * size.y / 7.0).ceil() as usize;
        for _ in 0..count {
            let axes = upright(std::f64::consts::TAU * self.between(0.0, 1.0));
            let extent = [self.between(0.4, 1.6), self.between(0.3, 1.2)];
            let place = self.low
                + Vector3::new(size.x * self.between(0.0, 1.0), size.y * self.between(0.0, 1.0), 0.0);
            let tall = self.between(0.5, 4.0);
            let skin = self.skin(MACHINES);
            let origin = place - 0.5 * (extent[0] * axes[0] + extent[1] * axes[1]);
            if !self.inside(&origin, &axes, extent) {
                continue;
            }
            let tall = tall.min(self.room_below(&place, 0.5 * extent[0].hypot(extent[1]), 0.6));
            if tall > 0.2 {
                self.slab(&Slab { origin, axes, size: [extent[0], extent[1], tall] }, &[(2, false)], &skin);
            }
        }
    }

    /// A railing: posts, and bars between them.
    fn railing(&mut self, origin: Vector3<f64>, axes: [Vector3<f64>; 3], length: f64, tall: f64) {
        let tone = self.between(0.5, 1.6) as f32;
        let skin = Skin { tone, ..self.of(Material::Cloth) };
        let thick = 0.035;
        let mut bar = |at: Vector3<f64>, size: [f64; 3]| {
            self.slab(&Slab { origin: at, axes, size }, &[], &skin);
        };
        for height in [0.5, 0.97] {
            bar(origin + height * tall * axes[2], [length, thick, thick]);
        }
        let posts = (length / 0.9).ceil() as usize;
        for i in 0..=posts {
            bar(origin + length * i as f64 / posts as f64 * axes[0], [thick, thick, tall]);
        }
    }

    /// A skin of nearly this tone.
    fn of_tone(&mut self, material: Material, tone: f64, fineness: f64) -> Skin {
        let spread = self.between(0.85, 1.15);
        Skin { tone: (tone * spread) as f32, fineness, ..self.of(material) }
    }

    /// A pallet under the body, on a dark deck, with a net's heap, a covered thing and a railing about it.
    fn stand(&mut self, rest: &Rest) {
        let turn = self.between(-0.35, 0.35);
        let up = Vector3::z();
        let left = up.cross(&rest.ahead);
        let ahead = turn.cos() * rest.ahead + turn.sin() * left;
        let left = up.cross(&ahead);
        let axes = [ahead, left, up];
        // The body stands at one end.
        let (long, wide) = (1.25, 1.0);
        let middle = rest.place + (0.5 * long - 0.25) * ahead;
        let top = self.course.lowest(&middle, 0.9).unwrap_or(rest.place.z).min(rest.place.z) - BODY_M;
        let corner = middle - 0.5 * (long * ahead + wide * left);
        let at = |along: f64, aside: f64, z: f64| {
            let mut point = corner + along * ahead + aside * left;
            point.z = z;
            point
        };
        // The deck.
        let deck = self.of_tone(Material::Grating, DECK_TONE, DECK_FINENESS);
        let deck_z = top - 0.15;
        let (before, beside) = (0.6, 0.9);
        let size = [long + 2.0 * before, wide + 2.0 * beside, 0.06];
        self.slab(&Slab { origin: at(-before, -beside, deck_z - 0.06), axes, size }, &[], &deck);
        // Boards lengthwise, three across below them.
        let mut aside = 0.0;
        while aside < wide - 0.08 {
            let width = self.between(0.1, 0.15).min(wide - aside);
            let skin = self.of_tone(Material::Grain, PALLET_TONE, GRAIN_FINENESS);
            let size = [long, width, 0.022];
            self.slab(&Slab { origin: at(0.0, aside, top - 0.022), axes, size }, &[], &skin);
            aside += width + self.between(0.03, 0.05);
        }
        for share in [0.03, 0.46, 0.89] {
            let skin = self.of_tone(Material::Grain, 0.5 * PALLET_TONE, 8.0);
            let size = [0.1, wide, 0.022];
            self.slab(&Slab { origin: at(share * long, 0.0, top - 0.044), axes, size }, &[], &skin);
            for aside in [0.0, 0.45, 0.9] {
                let skin = self.of_tone(Material::Grain, 0.3 * PALLET_TONE, 8.0);
                let size = [0.1, 0.1, 0.106];
                self.slab(
                    &Slab { origin: at(share * long, aside * wide, deck_z), axes, size },
                    &[(2, false)],
                    &skin,
                );
            }
        }
        self.about(rest, &axes, deck_z);
    }

    /// What lies about a pallet on its deck.
    fn about(&mut self, rest: &Rest, axes: &[Vector3<f64>; 3], deck_z: f64) {
        let [ahead, left, _] = *axes;
        let side = if self.chance(0.5) { 1.0 } else { -1.0 };
        // A heap under a net, boxes turned every way.
        for _ in 0..8 {
            let place = rest.place + self.between(0.35, 1.2) * ahead + side * self.between(0.75, 1.1) * left;
            let size = [self.between(0.2, 0.5), self.between(0.2, 0.4), self.between(0.2, 0.5)];
            let own = upright(std::f64::consts::TAU * self.between(0.0, 1.0));
            let skin = self.of_tone(Material::Net, NET_TONE, 4.0);
            let mut origin = place - 0.5 * (size[0] * own[0] + size[1] * own[1]);
            origin.z = deck_z;
            let tall = size[2].min(self.room_below(&place, 0.3, 0.12) + self.low.z - deck_z);
            if tall > 0.05 {
                self.slab(&Slab { origin, axes: own, size: [size[0], size[1], tall] }, &[(2, false)], &skin);
            }
        }
        // Covered things ahead.
        for _ in 0..3 {
            let place = rest.place + self.between(1.6, 2.4) * ahead + self.between(-1.0, 1.0) * left;
            let own = upright(std::f64::consts::TAU * self.between(0.0, 1.0));
            let skin = self.of_tone(Material::Cloth, 0.35, 2.0);
            let size = [self.between(0.5, 1.0), self.between(0.4, 0.8), 0.0];
            let mut origin = place - 0.5 * (size[0] * own[0] + size[1] * own[1]);
            let below = deck_z - 0.8;
            origin.z = below;
            let tall = self.between(0.9, 1.5).min(self.room_below(&place, 0.7, 0.3) + self.low.z - below);
            if tall > 0.1 {
                self.slab(&Slab { origin, axes: own, size: [size[0], size[1], tall] }, &[], &skin);
            }
        }
        let mut at = rest.place + 1.9 * ahead - 2.0 * left;
        at.z = deck_z;
        let tall = (self.room_below(&(at + 2.0 * left), 2.2, 0.3) + self.low.z - deck_z).min(1.0);
        if tall > 0.3 {
            let [ahead, left, up] = *axes;
            self.railing(at, [left, -ahead, up], 4.0, tall);
        }
    }
}
