//! The only shape there is: a rectangle in space, seen from its front, with a texture on it.

use super::super::texture::{Atlas, Material, SIDE};
use nalgebra::Vector3;

/// Terms of a light's course over a rectangle: 1, u, v, u^2, u v, v^2.
pub(crate) const LIGHT_TERMS: usize = 6;

/// What a rectangle looks like.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Skin {
    /// What it is covered with.
    pub(crate) material: Material,
    /// The texture's texel at the rectangle's origin. Of 1024 or more, so that no coordinate is negative.
    pub(crate) offset: [f32; 2],
    /// Brightness of the surface; 1 for a middle grey.
    pub(crate) tone: f32,
    /// How far the texture's values differ from a middle grey; 1 as painted.
    pub(crate) contrast: f32,
    /// How many times finer than the world's its texels are.
    pub(crate) fineness: f64,
}

impl Skin {
    /// Where its texture begins in the atlas.
    pub(crate) fn base(&self) -> u32 {
        Atlas::base(self.material)
    }

    /// Keeps the offset within one repetition of the texture and above what half a texel to the left may reach.
    pub(crate) fn at(material: Material, offset: [f32; 2], tone: f32, contrast: f32) -> Self {
        let side = SIDE as f32;
        Self { material, offset: offset.map(|v| v.rem_euclid(side) + side), tone, contrast, fineness: 1.0 }
    }
}

/// A rectangle in the world \[m\].
#[derive(Debug, Clone)]
pub(crate) struct Rect {
    /// Its corner at u = v = 0.
    pub(crate) origin: Vector3<f64>,
    /// Unit vector of u.
    pub(crate) across: Vector3<f64>,
    /// Unit vector of v, at right angles to `across`.
    pub(crate) along: Vector3<f64>,
    /// Lengths in u and v \[m\].
    pub(crate) size: [f64; 2],
    pub(crate) skin: Skin,
    /// Light on it: coefficients of u and v in texels.
    pub(crate) light: [f32; LIGHT_TERMS],
}

impl Rect {
    /// A rectangle; one whose u runs upright is turned, so that textures stand.
    pub(crate) fn new(
        origin: Vector3<f64>,
        [across, along]: [Vector3<f64>; 2],
        size: [f64; 2],
        skin: Skin,
    ) -> Self {
        let light = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        if across.z.abs() > 0.9 {
            let (across, along, origin) = (-along, across, origin + size[1] * along);
            return Self { origin, across, along, size: [size[1], size[0]], skin, light };
        }
        Self { origin, across, along, size, skin, light }
    }

    /// Unit normal on the side that is seen.
    pub(crate) fn normal(&self) -> Vector3<f64> {
        self.across.cross(&self.along)
    }

    /// The point at (u, v) \[m\].
    pub(crate) fn point(&self, u: f64, v: f64) -> Vector3<f64> {
        self.origin + u * self.across + v * self.along
    }

    /// How far along `ray` from `eye` it is hit, in lengths of `ray`; `None` from behind and beside it.
    pub(crate) fn hit(&self, eye: &Vector3<f64>, ray: &Vector3<f64>) -> Option<f64> {
        let normal = self.normal();
        let height = normal.dot(&(eye - self.origin));
        let fall = -normal.dot(ray);
        if height <= 0.0 || fall <= 0.0 {
            return None;
        }
        let way = height / fall;
        let at = eye + way * ray - self.origin;
        let inside = (0.0..=self.size[0]).contains(&at.dot(&self.across))
            && (0.0..=self.size[1]).contains(&at.dot(&self.along));
        inside.then_some(way)
    }
}

/// A box: a corner, three axes at right angles (right-handed), lengths along them \[m\].
#[derive(Debug, Clone)]
pub(super) struct Slab {
    pub(super) origin: Vector3<f64>,
    pub(super) axes: [Vector3<f64>; 3],
    pub(super) size: [f64; 3],
}

impl Slab {
    /// Its faces but those named in `hidden` as (axis, at its far end); `skin` is asked for each.
    pub(super) fn faces(
        &self,
        hidden: &[(usize, bool)],
        mut skin: impl FnMut(usize, bool) -> Skin,
    ) -> Vec<Rect> {
        let mut faces = Vec::with_capacity(6);
        for axis in 0..3 {
            for far in [false, true] {
                if hidden.contains(&(axis, far)) {
                    continue;
                }
                // a x b = c for the far face, b x a = -c for the near one.
                let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
                let (a, b) = if far { (a, b) } else { (b, a) };
                let shift = if far { self.size[axis] } else { 0.0 };
                let origin = self.origin + shift * self.axes[axis];
                let size = [self.size[a], self.size[b]];
                faces.push(Rect::new(origin, [self.axes[a], self.axes[b]], size, skin(axis, far)));
            }
        }
        faces
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn skin() -> Skin {
        Skin::at(Material::Cloth, [-3.0, 2000.0], 1.0, 1.0)
    }

    #[test]
    fn offsets_are_never_negative() {
        assert_eq!(skin().offset, [2045.0, 2000.0]);
    }

    #[test]
    fn a_slab_is_closed_and_its_faces_look_outwards_and_stand_upright() {
        let turn = nalgebra::Rotation3::from_euler_angles(0.0, 0.0, 0.4);
        let axes = [turn * Vector3::x(), turn * Vector3::y(), Vector3::z()];
        let slab = Slab { origin: Vector3::new(1.0, 2.0, 3.0), axes, size: [0.5, 1.0, 2.0] };
        let middle = slab.origin + 0.25 * axes[0] + 0.5 * axes[1] + axes[2];
        let faces = slab.faces(&[], |_, _| skin());
        assert_eq!(faces.len(), 6);
        for face in &faces {
            let centre = face.point(0.5 * face.size[0], 0.5 * face.size[1]);
            let out = (centre - middle).normalize();
            assert!((out - face.normal()).norm() < 1e-12, "{face:?}");
            assert!(face.normal().z.abs() > 0.5 || (face.along.z - face.along.z.signum()).abs() < 1e-12);
            // From outside the face is hit at its distance, from inside not at all.
            let eye = centre + 2.0 * out;
            assert!((face.hit(&eye, &-out).unwrap() - 2.0).abs() < 1e-12);
            assert!(face.hit(&middle, &out).is_none());
            assert!(face.hit(&(eye + 3.0 * face.across), &-out).is_none());
        }
        let area: f64 = faces.iter().map(|face| face.size[0] * face.size[1]).sum();
        assert!((area - 2.0 * (0.5 + 1.0 + 2.0)).abs() < 1e-12);
        assert_eq!(slab.faces(&[(2, false)], |_, _| skin()).len(), 5);
    }
}
