//! Cells over shards: what shares a recording stays together, and shards last about equally long.
//!
//! Longest processing time first (Graham 1969): groups, the longest first, each whole to the shard that ends earliest with it. Where that leaves shards
//! idle, because there are few groups or one is long, the earliest end is searched by bisection: shards are filled up to it, and a group is cut only where it fits
//! into no shard whole (after McNaughton 1959), for every shard with a piece makes what the group shares again.

use std::collections::BTreeSet;

/// Shards idle for less than this share are well filled: no group is cut for more.
const WELL_FILLED: f64 = 0.03;
/// How exactly the earliest end is searched, as a share of it.
const EXACTLY: f64 = 0.003;

/// Cells that share something.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// For what they share, whichever part of them is run \[s\].
    pub shared_s: f64,
    /// Those with the same noise track beside each other.
    pub cells: Vec<Member>,
}

/// A cell of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Member {
    /// Its place among all cells.
    pub place: usize,
    /// For it alone \[s\].
    pub own_s: f64,
    /// Which of the group's noise tracks it needs: a network speaks once a shard, so a group is better cut where this changes.
    pub noise: usize,
}

impl Group {
    fn whole_s(&self) -> f64 {
        self.shared_s + own_s(&self.cells)
    }
}

/// Which cell is whose.
#[derive(Debug, Clone, PartialEq)]
pub struct Balance {
    /// The shard of every cell, by the cell's place.
    pub shard_of: Vec<usize>,
    /// When each shard ends, all having begun together \[s\].
    pub seconds: Vec<f64>,
    /// What all shards work, without waiting for each other \[s\].
    pub cpu_s: f64,
}

impl Balance {
    /// How long the longest shard takes \[s\].
    pub fn longest_s(&self) -> f64 {
        self.seconds.iter().copied().fold(0.0, f64::max)
    }

    /// The share of all shards' time, to the end of the longest, in which nothing is done.
    pub fn idle_share(&self) -> f64 {
        let room = self.seconds.len() as f64 * self.longest_s();
        if room > 0.0 { (1.0 - self.cpu_s / room).max(0.0) } else { 0.0 }
    }
}

/// Puts the cells of `groups`, whose places are 0 to their number, into `shards` shards; each cell is in exactly one.
pub fn balance(groups: &[Group], shards: usize) -> Balance {
    // The longest first.
    let mut order: Vec<usize> = (0..groups.len()).collect();
    order.sort_by(|a, b| groups[*b].whole_s().total_cmp(&groups[*a].whole_s()));
    let mut best = whole(groups, &order, shards);
    if best.idle_share() <= WELL_FILLED {
        return best;
    }
    let total: f64 = groups.iter().map(Group::whole_s).sum();
    let (mut low, mut high) = (total / shards as f64, best.longest_s());
    while high - low > EXACTLY * high {
        let end_s = 0.5 * (low + high);
        match filled(groups, &order, shards, end_s) {
            Some(found) => {
                high = end_s;
                if found.longest_s() < best.longest_s() {
                    best = found;
                }
            }
            None => low = end_s,
        }
    }
    best
}

/// Shards as they are filled.
struct Shards {
    shard_of: Vec<usize>,
    work_s: Vec<f64>,
}

impl Shards {
    fn new(groups: &[Group], shards: usize) -> Self {
        let cells = groups.iter().map(|group| group.cells.len()).sum();
        Self { shard_of: vec![0; cells], work_s: vec![0.0; shards] }
    }

    /// Puts cells of a group into a shard that has none of it.
    fn put(&mut self, shard: usize, cells: &[Member], shared_s: f64) {
        self.work_s[shard] += shared_s + own_s(cells);
        for cell in cells {
            self.shard_of[cell.place] = shard;
        }
    }

    fn balance(self) -> Balance {
        let cpu_s = self.work_s.iter().sum();
        Balance { shard_of: self.shard_of, seconds: self.work_s, cpu_s }
    }
}

/// Every group whole, in `order`, each to the shard that ends earliest.
fn whole(groups: &[Group], order: &[usize], shards: usize) -> Balance {
    let mut filled = Shards::new(groups, shards);
    for &number in order {
        let group = &groups[number];
        let work_s = &filled.work_s;
        let shard = (0..shards).min_by(|a, b| work_s[*a].total_cmp(&work_s[*b])).expect("one shard or more");
        filled.put(shard, &group.cells, group.shared_s);
    }
    filled.balance()
}

/// Shards that work for `end_s` at most; none where the groups do not fit so.
fn filled(groups: &[Group], order: &[usize], shards: usize, end_s: f64) -> Option<Balance> {
    let mut filled = Shards::new(groups, shards);
    // Shards by the room that they have left; room is not negative, so bits are in the order of the numbers.
    let key = |room_s: f64, shard: usize| (room_s.max(0.0).to_bits(), shard);
    let mut rooms: BTreeSet<(u64, usize)> = (0..shards).map(|shard| key(end_s, shard)).collect();
    for &number in order {
        let group = &groups[number];
        let mut rest = &group.cells[..];
        let shared_s = group.shared_s;
        // What is left of the group goes whole into the least room that takes it; else as much of it as fits into the largest room.
        while !rest.is_empty() {
            let fits = rooms.range(key(shared_s + own_s(rest), 0)..).next().copied();
            let room @ (bits, shard) = fits.or_else(|| rooms.last().copied())?;
            let left_s = f64::from_bits(bits);
            let count = if fits.is_some() { rest.len() } else { fitting(rest, left_s - shared_s) };
            if count == 0 {
                return None;
            }
            let (cells, others) = rest.split_at(count);
            rooms.remove(&room);
            filled.put(shard, cells, shared_s);
            if left_s > shared_s + own_s(cells) {
                rooms.insert(key(left_s - shared_s - own_s(cells), shard));
            }
            rest = others;
        }
    }
    Some(filled.balance())
}

fn own_s(cells: &[Member]) -> f64 {
    cells.iter().map(|cell| cell.own_s).sum()
}

/// How many of the first cells take `room_s` at most; not between cells with the same noise track, if it can be had.
fn fitting(cells: &[Member], room_s: f64) -> usize {
    let mut sum_s = 0.0;
    let fits = |cell: &&Member| {
        sum_s += cell.own_s;
        sum_s <= room_s
    };
    let most = cells.iter().take_while(fits).count();
    let between = |count: &usize| cells.get(*count).is_none_or(|next| next.noise != cells[*count - 1].noise);
    (1..=most).rev().find(between).unwrap_or(most)
}

/// The fewest shards that end within `most_s`, none where a cell alone takes longer.
pub fn shards_within(groups: &[Group], most_s: f64) -> Option<usize> {
    let total: f64 = groups.iter().map(Group::whole_s).sum();
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
    fn study(shared: f64) -> Vec<Group> {
        let mut place = 0;
        let groups = (0..110).map(|i| {
            let length = 60.0 + 12.0 * f64::from(i % 11);
            let cell = |noise: i32| {
                place += 1;
                let own_s = length * (0.03 + 0.002 * f64::from(noise % 7));
                Member { place: place - 1, own_s, noise: noise as usize }
            };
            Group { shared_s: shared * length, cells: (0..31).map(cell).collect() }
        });
        groups.collect()
    }

    #[test]
    fn workers_up_to_sixty_four_are_idle_for_less_than_a_tenth_and_every_cell_is_in_one_shard() {
        let groups = study(0.05);
        for shards in [1, 2, 3, 8, 12, 31, 64] {
            let balance = balance(&groups, shards);
            assert!(balance.idle_share() <= 0.1, "{shards}: {}", balance.idle_share());
            assert_eq!(balance.shard_of.len(), 3410);
            let mut seconds = vec![0.0; shards];
            for group in &groups {
                let mut there = vec![false; shards];
                for cell in &group.cells {
                    let shard = balance.shard_of[cell.place];
                    seconds[shard] += cell.own_s + if there[shard] { 0.0 } else { group.shared_s };
                    there[shard] = true;
                }
            }
            let same = seconds.iter().zip(&balance.seconds).all(|(a, b)| (a - b).abs() < 1e-6);
            assert!(same, "{shards} shards take another time than is said");
        }
        // Few groups are cut, so little is made twice.
        let eleven = &groups[..11];
        let total: f64 = eleven.iter().map(Group::whole_s).sum();
        let twelve = balance(eleven, 12);
        assert!(twelve.cpu_s < 1.04 * total && twelve.idle_share() < 0.03, "{} {total}", twelve.cpu_s);
        // Two shards have room for whole groups: nothing is made twice.
        let total: f64 = groups.iter().map(Group::whole_s).sum();
        assert!((balance(&groups, 2).seconds.iter().sum::<f64>() - total).abs() < 1e-6);
    }

    #[test]
    fn shards_last_no_longer_than_asked_for_and_what_cannot_be_is_none() {
        let groups = study(0.05);
        let shards = shards_within(&groups, 600.0).unwrap();
        assert!(balance(&groups, shards).longest_s() <= 600.0);
        assert!(balance(&groups, shards - 2).longest_s() > 600.0);
        assert_eq!(shards_within(&groups, 0.5), None);
        assert_eq!(shards_within(&groups, 1e9), Some(1));
    }

    #[test]
    fn cells_with_the_same_noise_track_stay_together_where_they_fit() {
        // Twelve cells, four noise tracks of three cells each; a shard has room for five, two, or all.
        let cells: Vec<Member> =
            (0..12).map(|place| Member { place, own_s: 1.0, noise: place / 3 }).collect();
        assert_eq!([5.0, 2.0, 3.0, 20.0].map(|room| fitting(&cells, room)), [3, 2, 3, 12]);
        assert_eq!(fitting(&cells, 0.5), 0);
    }
}
