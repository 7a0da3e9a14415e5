//! `configs/truth/truth.toml` says, key by key, what the program does without it.

use dpn_io::config::load;
use dpn_testing::{repository, written_out};
use dpn_truth::TruthConfig;

#[test]
fn the_default_file_is_the_default_and_leaves_no_key_out_and_none_without_a_comment() {
    let path = repository().join("configs/truth/truth.toml");
    assert_eq!(load::<TruthConfig>(&path).unwrap(), TruthConfig::default());
    written_out(&path, &TruthConfig::default());
}
