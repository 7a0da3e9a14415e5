//! Ranks with ties.

/// Twice the rank of every value, smallest 2; values that are equal share the mean of their ranks. Twice, so that it is whole.
pub(super) fn doubled_midranks(values: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0; values.len()];
    let mut first = 0;
    for group in order.chunk_by(|&a, &b| values[a] == values[b]) {
        // Ranks first + 1 to first + len: their mean, doubled.
        for &i in group {
            ranks[i] = 2 * first + group.len() + 1;
        }
        first += group.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn equal_values_share_their_mean_rank() {
        assert_eq!(doubled_midranks(&[3.0, 1.0, 3.0, 2.0, 3.0]), [8, 2, 8, 4, 8]);
        assert_eq!(doubled_midranks(&[0.0, -0.0, 1.0]), [3, 3, 6]);
        assert!(doubled_midranks(&[]).is_empty());
    }

    proptest! {
        #[test]
        fn ranks_add_up_and_order_as_the_values_do(values in prop::collection::vec(0_i32..20, 0..40)) {
            let x: Vec<f64> = values.iter().map(|&v| f64::from(v)).collect();
            let ranks = doubled_midranks(&x);
            prop_assert_eq!(ranks.iter().sum::<usize>(), x.len() * (x.len() + 1));
            for (a, ra) in x.iter().zip(&ranks) {
                for (b, rb) in x.iter().zip(&ranks) {
                    prop_assert_eq!(a.total_cmp(b), ra.cmp(rb));
                }
            }
        }
    }
}
