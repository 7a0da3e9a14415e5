//! Which sequences teach and which judge.

pub use dpn_core::Side;

/// EuRoC's training sequences in the paper's table 1, by their short names.
const PAPER_TRAIN: [&str; 6] = ["MH_01", "MH_03", "MH_05", "V1_02", "V2_01", "V2_03"];
/// EuRoC's test sequences in the paper's table 1.
const PAPER_TEST: [&str; 5] = ["MH_02", "MH_04", "V1_01", "V1_03", "V2_02"];

/// The paper's side of an EuRoC sequence, by its short name (`MH_01`) or with its difficulty (`MH_01_easy`); `None` for
/// any other name, a part of a sequence such as `V1_01_easy_static` included.
///
/// # Source
/// VIO-DualProNet, table 1.
pub fn paper_side(sequence: &str) -> Option<Side> {
    let short = ["_easy", "_medium", "_difficult"]
        .iter()
        .find_map(|difficulty| sequence.strip_suffix(difficulty))
        .unwrap_or(sequence);
    if PAPER_TRAIN.contains(&short) {
        Some(Side::Train)
    } else if PAPER_TEST.contains(&short) {
        Some(Side::Test)
    } else {
        None
    }
}

/// Assigns every name a side: the paper's where all are EuRoC's; else every second name (in sorted order) is a test
/// sequence, the first being a training one.
pub fn assign<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<(String, Side)> {
    let mut names: Vec<&str> = names.into_iter().collect();
    names.sort_unstable();
    names.dedup();
    let paper: Option<Vec<_>> =
        names.iter().map(|n| paper_side(n).map(|side| ((*n).to_owned(), side))).collect();
    paper.unwrap_or_else(|| {
        names
            .iter()
            .enumerate()
            .map(|(i, n)| ((*n).to_owned(), if i % 2 == 0 { Side::Train } else { Side::Test }))
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn euroc_names_with_and_without_their_difficulty_find_the_papers_side() {
        assert_eq!(paper_side("V2_03_difficult"), Some(Side::Train));
        assert_eq!(paper_side("V2_02"), Some(Side::Test));
        assert_eq!(paper_side("V2_020"), None);
        assert_eq!(paper_side("V1_01_easy_static"), None);
        assert_eq!(paper_side("room1"), None);
    }

    #[test]
    fn foreign_names_alternate_in_sorted_order() {
        let sides = assign(["b", "a", "c"]);
        assert_eq!(
            sides,
            vec![("a".into(), Side::Train), ("b".into(), Side::Test), ("c".into(), Side::Train)]
        );
    }
}
