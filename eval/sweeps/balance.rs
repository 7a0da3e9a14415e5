//! Cells over shards: what shares a recording stays together, and shards last about equally long.
//!
//! Longest processing time first (Graham 1969): groups, the longest first, each to the shard that ends earliest with it. Where that leaves shards idle,
//! because there are few groups or one is long, groups are cut in pieces first; every shard with a piece makes what the group shares again. Of
//! several sizes of pieces the one that ends earliest is taken.

/// Shards idle for less than this share are well filled: no group is cut for more.
const WELL_FILLED: f64 = 0.03;
/// Pieces a shard's fair share may be cut in.
const FINEST: usize = 16;

/// Cells that share something.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// For what they share, whichever part of them is run \[s\].
    pub shared_s: f64,
    /// Each cell, by its place among all, and for it alone \[s\].
    pub cells: Vec<(usize, f64)>,
}

impl Group {
    fn own_s(&self) -> f64 {
        self.cells.iter().map(|(_, own_s)| own_s).sum()
    }
}

/// Which cell is whose.
#[derive(Debug, Clone, PartialEq)]
pub struct Balance {
    /// The shard of every cell, by the cell's place.
    pub shard_of: Vec<usize>,
    /// How long each shard takes \[s\].
    pub seconds: Vec<f64>,
}

impl Balance {
    /// How long the longest shard takes \[s\].
    pub fn longest_s(&self) -> f64 {
        self.seconds.iter().copied().fold(0.0, f64::max)
    }

    /// The share of all shards' time, to the end of the longest, in which nothing is done.
    pub fn idle_share(&self) -> f64 {
        let room = self.seconds.len() as f64 * self.longest_s();
        if room > 0.0 { 1.0 - self.seconds.iter().sum::<f64>() / room } else { 0.0 }
    }
}

/// Puts the cells of `groups`, whose places are 0 to their number, into `shards` shards; each cell is in exactly one.
pub fn balance(groups: &[Group], shards: usize) -> Balance {
    let total: f64 = groups.iter().map(|group| group.shared_s + group.own_s()).sum();
    let fair = total / shards as f64;
    let mut best = placed(groups, shards, f64::INFINITY);
    for finer in 1..=FINEST {
        if best.idle_share() <= WELL_FILLED {
            break;
        }
        let other = placed(groups, shards, fair / finer as f64);
        if other.longest_s() < best.longest_s() {
            best = other;
        }
    }
    best
}

/// A part of a group: the group's number, its cells with their seconds, the sum of these \[s\].
type Piece<'a> = (usize, &'a [(usize, f64)], f64);

/// Groups in pieces that take about `piece_s` at most, the longest first.
fn placed(groups: &[Group], shards: usize, piece_s: f64) -> Balance {
    let mut pieces: Vec<Piece<'_>> = Vec::new();
    for (number, group) in groups.iter().enumerate() {
        // A piece's share of the time goes to what is shared, or there would be no end of cutting.
        let count = (group.own_s() / (piece_s - group.shared_s).max(piece_s / 2.0)).ceil();
        let count = (count as usize).clamp(1, group.cells.len().max(1));
        let each = group.own_s() / count as f64;
        let (mut begin, mut sum) = (0, 0.0);
        for (end, (_, own_s)) in (1..).zip(&group.cells) {
            sum += own_s;
            // Cut where the next cell would take the piece further beyond its share than it is short of it.
            let next = group.cells.get(end).map_or(0.0, |(_, own_s)| *own_s);
            if end == group.cells.len() || sum + 0.5 * next > each {
                pieces.push((number, &group.cells[begin..end], sum));
                (begin, sum) = (end, 0.0);
            }
        }
    }
    let length = |(group, _, own_s): &Piece<'_>| groups[*group].shared_s + own_s;
    pieces.sort_by(|a, b| length(b).total_cmp(&length(a)));
    let cells = groups.iter().map(|group| group.cells.len()).sum();
    let (mut shard_of, mut seconds) = (vec![0; cells], vec![0.0; shards]);
    let mut has: Vec<Vec<usize>> = vec![Vec::new(); shards];
    for (group, cells, own_s) in pieces {
        let with = |shard: usize| {
            let again = if has[shard].contains(&group) { 0.0 } else { groups[group].shared_s };
            seconds[shard] + own_s + again
        };
        let shard = (0..shards).min_by(|a, b| with(*a).total_cmp(&with(*b))).expect("one shard or more");
        seconds[shard] = with(shard);
        has[shard].push(group);
        for (place, _) in cells {
            shard_of[*place] = shard;
        }
    }
    Balance { shard_of, seconds }
}

/// The fewest shards that end within `most_s`, none where a cell alone takes longer.
pub fn shards_within(groups: &[Group], most_s: f64) -> Option<usize> {
    let total: f64 = groups.iter().map(|group| group.shared_s + group.own_s()).sum();
    let cells: usize = groups.iter().map(|group| group.cells.len()).sum();
    let fewest = (total / most_s).ceil().max(1.0) as usize;
    // Each step a fiftieth up: the fewest to within 2 %, however many there are.
    let mut shards = fewest;
    while shards <= cells {
        if balance(groups, shards).longest_s() <= most_s {
            return Some(shards);
        }
        shards += 1 + shards / 50;
    }
    (balance(groups, cells).longest_s() <= most_s).then_some(cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 11 sequences of various lengths, 10 seeds, 31 noises of various costs.
    fn study() -> Vec<Group> {
        let mut place = 0;
        let groups = (0..110).map(|i| {
            let length = 60.0 + 12.0 * f64::from(i % 11);
            let cell = |noise: i32| {
                place += 1;
                (place - 1, length * (0.03 + 0.002 * f64::from(noise % 7)))
            };
            Group { shared_s: 0.05 * length, cells: (0..31).map(cell).collect() }
        });
        groups.collect()
    }

    #[test]
    fn workers_up_to_sixty_four_are_idle_for_less_than_a_tenth_and_every_cell_is_in_one_shard() {
        let groups = study();
        for shards in [1, 2, 3, 8, 12, 31, 64] {
            let balance = balance(&groups, shards);
            assert!(balance.idle_share() <= 0.1, "{shards}: {}", balance.idle_share());
            assert_eq!(balance.shard_of.len(), 3410);
            let mut seconds = vec![0.0; shards];
            for group in &groups {
                let mut there = vec![false; shards];
                for (place, own_s) in &group.cells {
                    let shard = balance.shard_of[*place];
                    seconds[shard] += own_s + if there[shard] { 0.0 } else { group.shared_s };
                    there[shard] = true;
                }
            }
            let same = seconds.iter().zip(&balance.seconds).all(|(a, b)| (a - b).abs() < 1e-6);
            assert!(same, "{shards} shards take another time than is said");
        }
        // Two shards have room for whole groups: nothing is made twice.
        let total: f64 = groups.iter().map(|group| group.shared_s + group.own_s()).sum();
        assert!((balance(&groups, 2).seconds.iter().sum::<f64>() - total).abs() < 1e-6);
    }

    #[test]
    fn shards_last_no_longer_than_asked_for_and_what_cannot_be_is_none() {
        let groups = study();
        let shards = shards_within(&groups, 600.0).unwrap();
        assert!(balance(&groups, shards).longest_s() <= 600.0);
        assert!(balance(&groups, shards - 2).longest_s() > 600.0);
        assert_eq!(shards_within(&groups, 0.5), None);
        assert_eq!(shards_within(&groups, 1e9), Some(1));
    }
}
