//! What is done to the messages of an IMU and a camera on their way: lost, twice, late, out of order, wrong stamps, clocks that are set, sensors that stop.

use crate::forged::Draw;

/// What is done to a stream, up to a time from which on nothing is disturbed any more.
#[derive(Debug, Clone, Default)]
pub struct SensorFaults {
    /// From then on \[s\] all is well.
    pub good_s: f64,
    /// Share of messages that are lost.
    pub lost: f64,
    /// That come twice.
    pub twice: f64,
    /// That come late, by up to .2 s, behind later ones.
    pub late: f64,
    /// That have another stamp.
    pub jumps: f64,
    /// Of samples with a value that no sensor gives.
    pub wild: f64,
    /// Clocks are set: whether the IMU's and the camera's, when, by how many seconds.
    pub set: Option<([bool; 2], f64, f64)>,
    /// Every sample is NaN.
    pub nan: bool,
    /// The IMU's values stand still from when to when.
    pub frozen: Option<[f64; 2]>,
    /// A sensor stops: whether the camera, from when to when.
    pub stops: Option<(bool, [f64; 2])>,
    /// Black images from when to when.
    pub dark: Option<[f64; 2]>,
    /// Nothing comes through from when to when; then all of it does.
    pub stalled: Option<[f64; 2]>,
}

/// A message as it comes.
#[derive(Debug, Clone, Copy)]
pub struct Disturbed {
    /// When \[s\].
    pub comes_s: f64,
    /// Which it was.
    pub place: usize,
    /// What was added to its stamp \[s\].
    pub by_s: f64,
    /// The image is black.
    pub dark: bool,
    /// The value that a sample has instead of its own.
    pub wild: Option<f64>,
    /// The sample whose values it has instead of its own.
    pub says: Option<usize>,
}

/// Values that no sensor gives.
const WILD: [f64; 5] = [f64::NAN, f64::INFINITY, 1e308, -1e30, 1e5];

impl SensorFaults {
    /// Faults by chance, before `good_s`.
    pub fn draw(draw: &mut Draw, good_s: f64) -> Self {
        let mut often = |most: f64| if draw.share() < 0.5 { most * draw.share() } else { 0.0 };
        let [lost, twice, late, jumps, wild] =
            [often(0.05), often(0.05), often(0.05), often(0.01), often(0.01)];
        let mut span = |most: f64| {
            let from = 2.0 + draw.share() * (good_s - 3.0);
            [from, (from + most * draw.share()).min(good_s)]
        };
        let [set, stops, dark, stalled, frozen] = [0.0, 4.0, 4.0, 4.0, 4.0].map(&mut span);
        let mut chance = |share: f64| draw.share() < share;
        let [is_set, is_stopped, is_dark, is_stalled] = [chance(0.3), chance(0.3), chance(0.3), chance(0.2)];
        let [first, second] = [chance(0.5), chance(0.5)];
        let by = 2.0 + 5000.0 * draw.share();
        let by = if draw.share() < 0.5 { by } else { -by };
        let mut chance = |share: f64| draw.share() < share;
        let (of_both, is_small, is_frozen) = (chance(0.3), chance(0.5), chance(0.2));
        let by = if is_small { by.signum() * draw.share() } else { by };
        Self {
            good_s,
            lost,
            twice,
            late,
            jumps,
            wild,
            set: is_set.then_some(([of_both || !first, of_both || first], set[0], by)),
            nan: false,
            frozen: is_frozen.then_some(frozen),
            stops: is_stopped.then_some((second, stops)),
            dark: is_dark.then_some(dark),
            stalled: is_stalled.then_some(stalled),
        }
    }

    /// Messages that were recorded after so many seconds, and whether each is an image: as they come, in the order in which they do.
    pub fn played(&self, messages: impl IntoIterator<Item = (f64, bool)>, draw: &mut Draw) -> Vec<Disturbed> {
        let within =
            |span: Option<[f64; 2]>, at: f64| span.is_some_and(|[from, to]| (from..to).contains(&at));
        let (mut all, mut said) = (Vec::new(), None);
        for (place, (at, is_image)) in messages.into_iter().enumerate() {
            let mut happens = |share: f64| at < self.good_s && draw.share() < share;
            let stops = self.stops.filter(|(images, _)| *images == is_image).map(|(_, span)| span);
            if within(stops, at) || happens(self.lost) {
                continue;
            }
            let [twice, late, jumps, wild] = [self.twice, self.late, self.jumps, self.wild].map(&mut happens);
            let set = self.set.filter(|(of, from, _)| of[usize::from(is_image)] && at >= *from);
            let by_s = set.map_or(0.0, |(.., by)| by) + if jumps { 1e4 * (draw.share() - 0.5) } else { 0.0 };
            let comes_s = at + if late { 0.2 * draw.share() } else { 0.0 };
            let wild = (wild && !is_image).then(|| WILD[draw.below(WILD.len())]);
            let wild = if self.nan { Some(f64::NAN) } else { wild };
            let says = said.filter(|_| !is_image && within(self.frozen, at));
            said = if is_image { said } else { says.or(Some(place)) };
            let one = Disturbed { comes_s, place, by_s, dark: within(self.dark, at), wild, says };
            all.extend(std::iter::repeat_n(one, if twice { 2 } else { 1 }));
        }
        all.sort_by(|a, b| a.comes_s.total_cmp(&b.comes_s));
        for one in &mut all {
            // What is held up stays in order.
            one.comes_s = self
                .stalled
                .filter(|span| within(Some(*span), one.comes_s))
                .map_or(one.comes_s, |[_, to]| to);
        }
        all
    }
}
