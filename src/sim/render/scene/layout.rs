//! A room around a flight: walls in relief, boxes, mats, beams, windows; nothing stands where the body flies.

use super::super::texture::Material;
use super::builder::{Builder, CLEARANCE_M, Mix, Scale, upright};
use super::course::Course;
use super::hall;
use super::light::Lights;
use super::rect::{Rect, Skin, Slab};
use crate::tracks::World;
use nalgebra::Vector3;
use rand::Rng;
use rand_distr::{Distribution, Exp};

/// Walls reach this far into each other, so that no ray slips out between them \[m\].
const OVERLAP_M: f64 = 0.02;

const WALLS: &Mix = &[(Material::Cloth, 0.5), (Material::Blocks, 0.35), (Material::Planks, 0.15)];
const PANELS: &Mix = &[
    (Material::Cloth, 0.54),
    (Material::Clutter, 0.13),
    (Material::Blocks, 0.1),
    (Material::Planks, 0.13),
    (Material::Print, 0.1),
];
const POSTERS: &Mix = &[(Material::Print, 0.5), (Material::Clutter, 0.1), (Material::Chips, 0.4)];
const BOXES: &Mix = &[
    (Material::Clutter, 0.25),
    (Material::Planks, 0.3),
    (Material::Print, 0.2),
    (Material::Cloth, 0.15),
    (Material::Blocks, 0.1),
];
const MATS: &Mix = &[(Material::Print, 0.5), (Material::Clutter, 0.2), (Material::Cloth, 0.3)];
const CEILINGS: &Mix = &[(Material::Planks, 0.6), (Material::Blocks, 0.4)];

/// Everything that is seen.
pub(super) struct Layout {
    pub(super) rects: Vec<Rect>,
    pub(super) texels_per_m: f64,
}

impl Layout {
    /// The room of kind `world` around a flight within `bounds`; `contrast` scales that of all textures, `bare` is the share of the
    /// walls' fields that show nothing but paint.
    pub(super) fn new(course: &Course, world: World, [contrast, bare]: [f64; 2], rng: &mut impl Rng) -> Self {
        let bounds = &course.bounds;
        let figures = world.figures(bounds);
        let low = bounds.low - Vector3::new(figures.side, figures.side, figures.down);
        let high = bounds.high + Vector3::new(figures.side, figures.side, figures.up);
        let hall = world.settled(bounds) == World::Hall;
        let scale = if hall {
            hall::scale(figures.relief)
        } else {
            Scale {
                texels_per_m: 250.0,
                tone: [0.0, 0.32],
                ambient: 1.2,
                contrast: 1.0,
                relief: figures.relief,
                field: [0.9, 2.2],
                thing_area: 2.6,
            }
        };
        let contrast = (scale.contrast * contrast) as f32;
        let (rects, lamps) = (Vec::new(), Vec::new());
        let mut room = Builder { low, high, course, scale, contrast, bare, rects, lamps, rng };
        room.shell();
        room.walls();
        room.floor();
        room.ceiling();
        if hall {
            room.furnish();
        }
        let lights = Lights::new(&low, &high, room.scale.ambient, room.rng);
        lights.shine(&mut room.rects, room.scale.texels_per_m);
        room.rects.append(&mut room.lamps);
        Self { rects: room.rects, texels_per_m: room.scale.texels_per_m }
    }
}

/// A wall, bare: its lower corner, the direction along it, the normal into the room, its length \[m\].
#[derive(Clone, Copy)]
struct Side {
    corner: Vector3<f64>,
    across: Vector3<f64>,
    inward: Vector3<f64>,
    length: f64,
}

impl<R: Rng> Builder<'_, R> {
    /// The four walls.
    fn sides(&self) -> [Side; 4] {
        let (low, high, size) = (self.low, self.high, self.high - self.low);
        let (x, y) = (Vector3::x(), Vector3::y());
        [
            Side { corner: Vector3::new(high.x, low.y, low.z), across: -x, inward: y, length: size.x },
            Side { corner: low, across: y, inward: x, length: size.y },
            Side { corner: Vector3::new(low.x, high.y, low.z), across: x, inward: -y, length: size.x },
            Side { corner: Vector3::new(high.x, high.y, low.z), across: -y, inward: -x, length: size.y },
        ]
    }

    /// Walls, floor and ceiling, bare.
    fn shell(&mut self) {
        let (size, z) = (self.high - self.low, Vector3::z());
        for Side { corner, across, length, .. } in self.sides() {
            let skin = self.painted().unwrap_or_else(|| self.skin(WALLS));
            let origin = corner - OVERLAP_M * (across + z);
            let extent = [length + 2.0 * OVERLAP_M, size.z + 2.0 * OVERLAP_M];
            self.rects.push(Rect::new(origin, [across, z], extent, skin));
        }
        let spread = OVERLAP_M * (Vector3::x() + Vector3::y());
        let extent = [size.x + 2.0 * OVERLAP_M, size.y + 2.0 * OVERLAP_M];
        let floor = self.of(Material::Carpet);
        self.rects.push(Rect::new(self.low - spread, [Vector3::x(), Vector3::y()], extent, floor));
        let ceiling = self.painted().unwrap_or_else(|| self.skin(CEILINGS));
        let corner = Vector3::new(self.low.x, self.low.y, self.high.z) - spread;
        let extent = [extent[1], extent[0]];
        self.rects.push(Rect::new(corner, [Vector3::y(), Vector3::x()], extent, ceiling));
    }

    /// Panels in relief on most fields of the walls, posters on some, windows in the upper half.
    fn walls(&mut self) {
        let height = self.high.z - self.low.z;
        let deepest = 4.0 * self.scale.relief;
        for Side { corner, across, inward, length } in self.sides() {
            let mut fields = Vec::new();
            self.divide([0.0, 0.0, length, height], &mut fields);
            for [x, z, width, tall] in fields {
                if self.is_bare() {
                    continue;
                }
                let gap = self.between(0.01, 0.07) * width.min(tall);
                let relief = Exp::new(1.0 / self.scale.relief).expect("a positive scale").sample(self.rng);
                let depth = relief.clamp(0.02, deepest);
                let origin = corner + (x + gap) * across + (z + gap) * Vector3::z();
                let (width, tall) = (width - 2.0 * gap, tall - 2.0 * gap);
                // across x z points into the room's inside for walls that are seen from there.
                let axes = [across, Vector3::z(), inward];
                let draw = self.rng.random::<f64>();
                let upper = z + 0.5 * tall > 0.45 * height;
                if draw < 0.12 {
                    continue;
                }
                let slab = Slab { origin, axes, size: [width, tall, depth] };
                if draw < 0.21 && upper {
                    self.window(&slab);
                    continue;
                }
                let skin = self.skin(PANELS);
                self.slab(&slab, &[(2, false)], &skin);
                if self.chance(0.75) {
                    self.poster(&slab);
                }
            }
        }
    }

    /// A sheet on the front of a panel.
    fn poster(&mut self, panel: &Slab) {
        let [width, tall, depth] = panel.size;
        let (w, h) = (width * self.between(0.2, 0.6), tall * self.between(0.2, 0.6));
        let (x, y) = (self.between(0.05, 0.95) * (width - w), self.between(0.05, 0.95) * (tall - h));
        let [across, along, inward] = panel.axes;
        let origin = panel.origin + x * across + y * along + (depth + 0.006) * inward;
        let skin = self.skin(POSTERS);
        self.rects.push(Rect::new(origin, [across, along], [w, h], skin));
    }

    /// A frame with light in it.
    fn window(&mut self, slab: &Slab) {
        let skin = self.of(Material::Planks);
        self.slab(slab, &[(2, false)], &skin);
        let [width, tall, depth] = slab.size;
        let [across, along, inward] = slab.axes;
        let bright = self.between(2.5, 5.0) as f32;
        let pane = Skin::at(Material::Plain, [0.0; 2], bright, self.contrast);
        // Two panes with a bar between.
        let bar = 0.04 * width;
        for x in [0.5 * bar, 0.5 * width + 0.5 * bar] {
            let origin = slab.origin + x * across + bar * along + (depth + 0.004) * inward;
            let size = [0.5 * width - bar, tall - 2.0 * bar];
            self.lamps.push(Rect::new(origin, [across, along], size, pane));
        }
    }

    /// Cuts a field in two until its sides are small enough.
    fn divide(&mut self, [x, y, width, height]: [f64; 4], fields: &mut Vec<[f64; 4]>) {
        let [least, most] = self.scale.field;
        let longest = width.max(height);
        let stop = longest <= most && (longest < 2.0 * least || self.chance(0.35));
        if stop || longest < 2.0 * least {
            fields.push([x, y, width, height]);
            return;
        }
        let cut = self.between(least, longest - least);
        if width >= height {
            self.divide([x, y, cut, height], fields);
            self.divide([x + cut, y, width - cut, height], fields);
        } else {
            self.divide([x, y, width, cut], fields);
            self.divide([x, y + cut, width, height - cut], fields);
        }
    }

    /// Mats and strips on the floor; boxes, low ones anywhere, high ones beside the flight.
    fn floor(&mut self) {
        let size = self.high - self.low;
        let things = (size.x * size.y / self.scale.thing_area).ceil() as usize;
        for i in 0..things + things / 2 {
            let turn = std::f64::consts::TAU * self.rng.random::<f64>();
            let axes = upright(turn);
            let strip = self.chance(0.4);
            let (extent, skin) = if strip {
                ([self.between(1.5, 4.0), self.between(0.1, 0.25)], self.of(Material::Chips))
            } else {
                ([self.between(0.7, 2.2), self.between(0.6, 1.6)], self.skin(MATS))
            };
            // Each lies on those before it.
            let lift = 0.004 + 0.0015 * i as f64;
            let place = self.low
                + Vector3::new(size.x * self.rng.random::<f64>(), size.y * self.rng.random::<f64>(), lift);
            let origin = place - 0.5 * (extent[0] * axes[0] + extent[1] * axes[1]);
            if self.inside(&origin, &axes, extent) {
                self.rects.push(Rect::new(origin, [axes[0], axes[1]], extent, skin));
            }
        }
        let largest = self.scale.field[1];
        for _ in 0..2 * things {
            let axes = upright(std::f64::consts::TAU * self.rng.random::<f64>());
            let extent = [self.between(0.15, 0.45) * largest, self.between(0.1, 0.35) * largest];
            let tall = largest * self.between(0.08, 0.9);
            let place = self.low
                + Vector3::new(size.x * self.rng.random::<f64>(), size.y * self.rng.random::<f64>(), 0.0);
            let origin = place - 0.5 * (extent[0] * axes[0] + extent[1] * axes[1]);
            let skin = self.skin(BOXES);
            if !self.inside(&origin, &axes, extent) {
                continue;
            }
            let room = self.headroom(&place, 0.5 * extent[0].hypot(extent[1]));
            let tall = tall.min(room);
            if tall > 0.05 {
                let slab = Slab { origin, axes, size: [extent[0], extent[1], tall] };
                self.slab(&slab, &[(2, false)], &skin);
            }
        }
    }

    /// Beams under the ceiling, in one direction, and lamps between them.
    fn ceiling(&mut self) {
        let (size, axis) = (self.high - self.low, usize::from(self.chance(0.5)));
        let most = (self.high.z - self.course.bounds.high.z - CLEARANCE_M).min(0.2 * self.scale.field[1]);
        let count = (size[1 - axis] / self.scale.field[1]).ceil().max(1.0) as usize;
        let (down, along) = (-Vector3::z(), Vector3::ith(axis, 1.0));
        let skin = self.skin(PANELS);
        for i in 0..count {
            let width = self.between(0.05, 0.12) * self.scale.field[1];
            let deep = most * self.between(0.3, 1.0);
            let place = (i as f64 + self.between(0.2, 0.8)) * size[1 - axis] / count as f64;
            let mut origin = Vector3::new(self.low.x, self.low.y, self.high.z);
            origin[1 - axis] += place.min(size[1 - axis] - width);
            let across = down.cross(&along);
            // across = down x along may point backwards; the box then begins at its other end.
            let origin = origin + if across[1 - axis] < 0.0 { -width * across } else { Vector3::zeros() };
            let slab = Slab { origin, axes: [along, across, down], size: [size[axis], width, deep] };
            self.slab(&slab, &[(2, false)], &skin);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracks::Bounds;
    use dpn_core::random::Stream;

    fn bounds(size: [f64; 3]) -> Bounds {
        let low = Vector3::new(-2.0, 1.0, 0.1);
        Bounds { low, high: low + Vector3::from(size) }
    }

    #[test]
    fn from_everywhere_in_the_flight_every_ray_hits_something_and_nothing_is_near() {
        for (seed, size) in [(1, [4.0, 3.0, 1.5]), (2, [14.0, 9.0, 5.0]), (3, [0.1, 0.0, 0.2])] {
            let bounds = bounds(size);
            let mut rng = Stream::new(seed).rng();
            let layout = Layout::new(&Course::within(&bounds), World::Auto, [1.0, 0.0], &mut rng);
            let size = bounds.high - bounds.low;
            for _ in 0..400 {
                let eye = bounds.low + size.component_mul(&Vector3::from_fn(|_, _| rng.random::<f64>()));
                let ray = Vector3::from_fn(|_, _| rng.random::<f64>() - 0.5).normalize();
                let way =
                    layout.rects.iter().filter_map(|rect| rect.hit(&eye, &ray)).fold(f64::MAX, f64::min);
                assert!((0.44..60.0).contains(&way), "{eye} {ray}: {way}");
            }
        }
    }

    #[test]
    fn a_room_has_relief_boxes_mats_and_windows() {
        let layout = Layout::new(
            &Course::within(&bounds([5.0, 4.0, 2.0])),
            World::Auto,
            [1.0, 0.0],
            &mut Stream::new(5).rng(),
        );
        assert!((150..1200).contains(&layout.rects.len()), "{}", layout.rects.len());
        let of_halls = [Material::Grain, Material::Net, Material::Grating];
        for material in Material::ALL.into_iter().filter(|material| !of_halls.contains(material)) {
            assert!(layout.rects.iter().any(|rect| rect.skin.material == material), "no {material:?}");
        }
        let bare = Layout::new(
            &Course::within(&bounds([5.0, 4.0, 2.0])),
            World::Auto,
            [1.0, 1.0],
            &mut Stream::new(5).rng(),
        );
        let posters = |layout: &Layout| {
            layout
                .rects
                .iter()
                .filter(|rect| rect.skin.material == Material::Chips && rect.along.z > 0.5)
                .count()
        };
        assert!(posters(&layout) > 0 && posters(&bare) == 0 && bare.rects.len() < layout.rects.len());
        for rect in &layout.rects {
            assert!(rect.size.iter().all(|side| *side > 0.0), "{rect:?}");
            assert!(rect.across.dot(&rect.along).abs() < 1e-12 && (rect.normal().norm() - 1.0).abs() < 1e-12);
        }
    }
}
