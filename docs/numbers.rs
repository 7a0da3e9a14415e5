//! Numbers that stand in README and book and are read from the study's own tables, `figures/euroc/tables`.
//!
//! A marked number is `<!-- n:study/self/ratio -->0.88 (0.73 to 1.07)<!-- /n -->`: its key is table, noise and quantity. `DPN_BLESS=1 cargo test -p
//! dpn-book` writes every marked number anew; without it the test names those that are stale.
//!
//! | key | number |
//! |---|---|
//! | `study/NOISE/mean` | mean ATE over all sequences \[m\] |
//! | `study/NOISE/ratio` | error over the best constant's, with its 95 % interval |
//! | `study/NOISE/better` | on how many sequences it is smaller |
//! | `study/NOISE/p` | p after Holm |

use crate::{at, read};
use std::collections::BTreeMap;

const TABLES: &str = "figures/euroc/tables";
const BEGIN: &str = "<!-- n:";
const CLOSE: &str = " -->";
const END: &str = "<!-- /n -->";

/// A row of a table by the names of its columns.
type Record = BTreeMap<String, String>;

fn table(name: &str) -> Vec<Record> {
    let text = read(&format!("{TABLES}/{name}.csv"));
    let rows = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes()).into_deserialize();
    rows.map(|row| row.unwrap_or_else(|error| panic!("{name}: {error}"))).collect()
}

/// The one row whose columns have these values.
fn row(name: &str, wanted: &[(&str, &str)]) -> Record {
    let mut rows: Vec<Record> = table(name)
        .into_iter()
        .filter(|row| wanted.iter().all(|(column, value)| row[*column] == *value))
        .collect();
    assert_eq!(rows.len(), 1, "{name}: rows with {wanted:?}");
    rows.remove(0)
}

fn number(text: &str) -> f64 {
    text.parse().unwrap_or_else(|_| panic!("`{text}` is no number"))
}

/// A probability above 0 to two digits.
fn probability(p: f64) -> String {
    if p >= 1.0 {
        return "1".to_owned();
    }
    let digits = (1.0 - p.log10().floor()) as usize;
    format!("{p:.digits$}")
}

/// `0.88 (0.73 to 1.07)` of the same with all digits.
fn with_interval(text: &str) -> String {
    let parts: Vec<f64> =
        text.trim_end_matches(')').split([' ', '(']).filter_map(|word| word.parse().ok()).collect();
    assert_eq!(parts.len(), 3, "`{text}` is no figure with its interval");
    format!("{:.2} ({:.2} to {:.2})", parts[0], parts[1], parts[2])
}

/// What a key stands for.
fn value(key: &str) -> String {
    let parts: Vec<&str> = key.split('/').collect();
    match parts[..] {
        ["study", noise, quantity] => {
            let row = row("study", &[("noise", noise)]);
            match quantity {
                "mean" => {
                    let sides = table("split");
                    let count = |side: &str| {
                        sides
                            .iter()
                            .filter(|row| row["side"] == side && !row["sequence"].starts_with("all"))
                            .count() as f64
                    };
                    let (train, test) = (count("train"), count("test"));
                    let sum = train * number(&row["mean train [m]"]) + test * number(&row["mean test [m]"]);
                    format!("{:.3}", sum / (train + test))
                }
                "ratio" => with_interval(&row["ratio to best constant (95 %)"]),
                "better" => row["better in"].clone(),
                "p" => probability(number(&row["p (Holm)"])),
                _ => panic!("{key}: no such quantity"),
            }
        }
        _ => panic!("{key}: no such number"),
    }
}

/// The text with every marked number as the tables have it.
fn filled(text: &str) -> String {
    let mut parts = text.split(BEGIN);
    let mut made = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (key, rest) =
            part.split_once(CLOSE).unwrap_or_else(|| panic!("`{part}`: a mark without its end"));
        let (_, rest) = rest.split_once(END).unwrap_or_else(|| panic!("{key}: a number without {END}"));
        made += &format!("{BEGIN}{key}{CLOSE}{}{END}{rest}", value(key));
    }
    made
}

#[test]
fn marked_numbers_are_those_of_the_study() {
    let mut stale = Vec::new();
    for page in crate::prose::pages() {
        let text = read(&page);
        let made = filled(&text);
        if made != text && std::env::var_os("DPN_BLESS").is_some() {
            std::fs::write(at(&page), made).unwrap();
            continue;
        }
        let pairs = text.lines().zip(made.lines()).filter(|(is, should)| is != should);
        stale.extend(pairs.map(|(is, should)| format!("{page}: {is}\n  should be {should}")));
    }
    assert!(stale.is_empty(), "DPN_BLESS=1 cargo test -p dpn-book writes them anew\n{}", stale.join("\n"));
}

#[test]
fn a_probability_has_two_digits() {
    assert_eq!([1.0, 0.389, 0.0566, 0.0322].map(probability), ["1", "0.39", "0.057", "0.032"]);
}
