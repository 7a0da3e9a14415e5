//! Cells over shards: what shares a recording stays together, and shards last about equally long.
//!
//! Longest processing time first (Graham 1969): groups, the longest first, each to the shard that ends earliest with it. Where that leaves shards idle,
//! because there are few groups or one is long, groups are cut in pieces first; every shard with a piece makes what the group shares again. Of
//! several sizes of pieces the one that ends earliest is taken.
//!
//! Where what is shared is kept for all (`dpn sweep run --cache`), the shard with a cut group's first cell makes it and the others take it. A shard
//! begins with what others wait for and ends with what it waits for itself ([`Turn`]).

use std::collections::BTreeMap;

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
    /// Whether what they share is kept for all shards once one has made it.
    pub kept: bool,
}

/// When a shard has its cells of a group whose shared part is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Turn {
    /// It makes what others wait for.
    Makes,
    /// The whole group is its own.
    Alone,
    /// Another makes it.
    Takes,
}

impl Turn {
    /// `shard`'s turn with a group whose cells are these shards', in their order.
    pub(super) fn of(shard: usize, mut cells: impl Iterator<Item = usize>) -> Self {
        match cells.next() {
            Some(first) if first != shard => Self::Takes,
            _ if cells.all(|other| other == shard) => Self::Alone,
            _ => Self::Makes,
        }
    }
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

/// A part of a group.
struct Piece<'a> {
    /// The group's number.
    group: usize,
    /// Its cells.
    cells: &'a [(usize, f64)],
    /// For these alone \[s\].
    own_s: f64,
    /// For what the group shares, where no other piece on the same shard has it \[s\].
    shared_s: f64,
}

/// A group in pieces that take about `piece_s` at most.
fn cut(number: usize, group: &Group, piece_s: f64) -> Vec<Piece<'_>> {
    let own_s = group.own_s();
    // What is kept is made by one; else a piece's share of the time goes to what is shared, or there would be no end of cutting.
    let (work, room) = if group.kept {
        (group.shared_s + own_s, piece_s)
    } else {
        (own_s, (piece_s - group.shared_s).max(piece_s / 2.0))
    };
    let count = ((work / room).ceil() as usize).clamp(1, group.cells.len().max(1));
    let each = work / count as f64;
    let mut pieces = Vec::with_capacity(count);
    // The first piece of what is kept makes it.
    let mut before = if group.kept { group.shared_s } else { 0.0 };
    let (mut begin, mut own_s) = (0, 0.0);
    for (end, (_, cell_s)) in (1..).zip(&group.cells) {
        own_s += cell_s;
        // Cut where the next cell would take the piece further beyond its share than it is short of it.
        let next = group.cells.get(end).map_or(0.0, |(_, own_s)| *own_s);
        if end == group.cells.len() || before + own_s + 0.5 * next > each {
            let shared_s = if group.kept && begin > 0 { 0.0 } else { group.shared_s };
            pieces.push(Piece { group: number, cells: &group.cells[begin..end], own_s, shared_s });
            (begin, own_s, before) = (end, 0.0, 0.0);
        }
    }
    pieces
}

/// Groups in pieces that take about `piece_s` at most, the longest first.
fn placed(groups: &[Group], shards: usize, piece_s: f64) -> Balance {
    let cut_groups = groups.iter().enumerate().flat_map(|(number, group)| cut(number, group, piece_s));
    let mut pieces: Vec<Piece<'_>> = cut_groups.collect();
    let length = |piece: &Piece<'_>| piece.shared_s + piece.own_s;
    pieces.sort_by(|a, b| length(b).total_cmp(&length(a)));
    let cells = groups.iter().map(|group| group.cells.len()).sum();
    let (mut shard_of, mut work_s) = (vec![0; cells], vec![0.0; shards]);
    let mut has: Vec<BTreeMap<usize, f64>> = vec![BTreeMap::new(); shards];
    for piece in pieces {
        let with = |shard: usize| {
            let again = !groups[piece.group].kept && has[shard].contains_key(&piece.group);
            work_s[shard] + piece.own_s + if again { 0.0 } else { piece.shared_s }
        };
        let shard = (0..shards).min_by(|a, b| with(*a).total_cmp(&with(*b))).expect("one shard or more");
        work_s[shard] = with(shard);
        *has[shard].entry(piece.group).or_default() += piece.own_s;
        for (place, _) in piece.cells {
            shard_of[*place] = shard;
        }
    }
    let cpu_s = work_s.iter().sum();
    let seconds = if groups.iter().any(|group| group.kept) { ends(groups, &shard_of, &has) } else { work_s };
    Balance { shard_of, seconds, cpu_s }
}

/// When each shard ends that `has` so much of each group's own work, with what it waits for.
fn ends(groups: &[Group], shard_of: &[usize], has: &[BTreeMap<usize, f64>]) -> Vec<f64> {
    let turn = |group: &Group, shard: usize| {
        if group.kept {
            Turn::of(shard, group.cells.iter().map(|(place, _)| shard_of[*place]))
        } else {
            Turn::Alone
        }
    };
    let mut ready = vec![0.0; groups.len()];
    let mut clocks = vec![0.0_f64; has.len()];
    // Who makes waits for nobody: every ready time stands before the first is asked for.
    for now in [Turn::Makes, Turn::Alone, Turn::Takes] {
        for (shard, (clock, has)) in clocks.iter_mut().zip(has).enumerate() {
            for (&number, own_s) in has {
                let group = &groups[number];
                if turn(group, shard) != now {
                    continue;
                }
                if now == Turn::Takes {
                    *clock = clock.max(ready[number]);
                } else {
                    *clock += group.shared_s;
                    ready[number] = *clock;
                }
                *clock += own_s;
            }
        }
    }
    clocks
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
    fn study(shared: f64, kept: bool) -> Vec<Group> {
        let mut place = 0;
        let groups = (0..110).map(|i| {
            let length = 60.0 + 12.0 * f64::from(i % 11);
            let cell = |noise: i32| {
                place += 1;
                (place - 1, length * (0.03 + 0.002 * f64::from(noise % 7)))
            };
            Group { shared_s: shared * length, cells: (0..31).map(cell).collect(), kept }
        });
        groups.collect()
    }

    #[test]
    fn workers_up_to_sixty_four_are_idle_for_less_than_a_tenth_and_every_cell_is_in_one_shard() {
        let groups = study(0.05, false);
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
        let groups = study(0.05, false);
        let shards = shards_within(&groups, 600.0).unwrap();
        assert!(balance(&groups, shards).longest_s() <= 600.0);
        assert!(balance(&groups, shards - 2).longest_s() > 600.0);
        assert_eq!(shards_within(&groups, 0.5), None);
        assert_eq!(shards_within(&groups, 1e9), Some(1));
    }

    #[test]
    fn what_is_kept_is_made_once_and_before_whoever_takes_it() {
        let groups = study(0.3, true);
        let total: f64 = groups.iter().map(|group| group.shared_s + group.own_s()).sum();
        for shards in [1, 2, 8, 64] {
            let balance = balance(&groups, shards);
            assert!(balance.idle_share() <= 0.1, "{shards}: {}", balance.idle_share());
            assert!((balance.cpu_s - total).abs() < 1e-6 * total, "{shards}: something is made twice");
        }
        let made_by_each = balance(&study(0.3, false), 64);
        assert!(balance(&groups, 64).longest_s() < made_by_each.longest_s());
        // Two shards and one group: the second waits for the first, and no more.
        let one = [Group { shared_s: 10.0, cells: (0..20).map(|place| (place, 1.0)).collect(), kept: true }];
        let two = balance(&one, 2);
        assert_eq!(two.cpu_s, 30.0);
        assert!((20.0..30.0).contains(&two.longest_s()), "{two:?}");
    }

    #[test]
    fn a_shard_makes_what_others_wait_for_first_and_takes_last() {
        assert_eq!(Turn::of(3, [3, 3].into_iter()), Turn::Alone);
        assert_eq!(Turn::of(3, [3, 4].into_iter()), Turn::Makes);
        assert_eq!(Turn::of(4, [3, 4].into_iter()), Turn::Takes);
        assert!(Turn::Makes < Turn::Alone && Turn::Alone < Turn::Takes);
    }
}
