//! Numbers that stand in README, book and `targets.csv` and are read from results that commands leave: the study's own tables in
//! `figures/euroc/tables` (`dpn paper`) and the JSON in `docs/results`, whose README names each file's command.
//!
//! A marked number is `<!--n:study/self/ratio-->0.88 (0.73 to 1.07)<!--/n-->`. `cargo xtask book` writes every marked number anew; a test
//! names those that are stale.
//!
//! | key | number |
//! |---|---|
//! | `headline` | the sentence that README and book begin with |
//! | `study/NOISE/QUANTITY` | the closed loop: `mean` ATE over all sequences \[m\], `ratio` of errors to the best constant with its 95 % interval, `better` on how many sequences, `p` after Holm, `equal` the p of being equal within 10 % |
//! | `pairs/NOISE/AGAINST/QUANTITY` | one noise against another: `ratio`, `better`, `p` without correction |
//! | `COURSE/NOISE/QUANTITY` | noise added in a course (`step`, `ramp`, `one-axis`, `tone`, `bias-jump`), the noise `best` its best constant: `name`, `median` and `mean` ATE \[m\]; `ratio`, `better`, `p` as of `study`; by means, how much `less` than the best constant, what share of the way to the true noise it `closes`, and the ratio `over` the lower of these two |
//! | `open/SENSOR/BASE/QUANTITY` | the open loop, the network's `rmse`, its `spread` over so many `seeds`; `simple` and `regressor`, the best of its kind with its name; the `bound` |
//! | `fleet/NOISE/QUANTITY` | all platforms: `score`, the error over that of each platform's best constant; `worst`; both in per cent as `less` and `more`; against the constant that is best elsewhere `ratio`, `better`, and in per cent `less-than-single` |
//! | `fleet/PLATFORM/NOISE/QUANTITY` | one platform: `ate` \[m\] and `score`, of the noise `best` with the constant's name |
//! | `vins/NOISE/QUANTITY` | VINS-Mono with that noise: `ate` \[m\]; of the noise `learned` the `ratio` to its usual constants, and `better` on how many sequences; of the noise `walks` the ATE `with` and `without` walks pasted |
//! | `flight/SENSOR/NOISE` | raw test flights: by what factor that noise is off the level of the reconciled truth, the root mean square of its logarithm over sequences; `outside`, the largest share of windows out of range; `flight@HZ` and `outside@HZ` of the network for that rate |
//! | `rest/QUANTITY` | simulated logs at rest: share of the intervals with the truth `inside`, their `median` width as a factor, how many axes are `off` by 1.3, and, of those whose plateau has 115 independent values, `wider` than 1.2 |
//! | `faults/QUANTITY` | injected faults: their `table`, a row a fault, those `without` a pose, and the `summary` |
//! | `table/NAME` | the whole table of a chapter: `study`, `step`, `courses`, `open`, `fleet` |
//! | `inertial/TABLE` | corrections of a gyroscope: `rates`, a row a way to them; `levels`, a row a way to levels of noise |
//! | `bench/NAME/UNIT` | median time of a bench in `us` or `ms` |

use crate::{at, read};
use serde_json::Value;
use std::collections::BTreeMap;

/// A row a target; `targets` makes the page of it.
pub(crate) const TARGETS: &str = "docs/targets.csv";
const TABLES: &str = "figures/euroc/tables";
const BEGIN: &str = "<!--n:";
const CLOSE: &str = "-->";
const END: &str = "<!--/n-->";

/// A row of a table by the names of its columns.
type Record = BTreeMap<String, String>;

fn table(name: &str) -> Vec<Record> {
    let text = read(&format!("{TABLES}/{name}.csv"));
    let rows = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes()).into_deserialize();
    rows.map(|row| row.unwrap_or_else(|error| panic!("{name}: {error}"))).collect()
}

/// The one row whose columns have these values.
fn row(name: &str, wanted: &[(&str, &str)]) -> Record {
    let is_wanted = |row: &Record| wanted.iter().all(|(column, value)| row[*column] == *value);
    let mut rows: Vec<Record> = table(name).into_iter().filter(is_wanted).collect();
    assert_eq!(rows.len(), 1, "{name}: rows with {wanted:?}");
    rows.remove(0)
}

fn json(name: &str) -> Value {
    let path = format!("docs/results/{name}.json");
    serde_json::from_str(&read(&path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The one of a list whose `field` is `name`.
fn named<'a>(list: &'a Value, field: &str, name: &str) -> &'a Value {
    let mut found = list.as_array().unwrap().iter().filter(|entry| entry[field] == name);
    found.next().unwrap_or_else(|| panic!("no {field} is {name}"))
}

fn number(text: &str) -> f64 {
    text.parse().unwrap_or_else(|_| panic!("`{text}` is no number"))
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// A length: three decimals, four where that leaves two digits.
fn metres(value: f64) -> String {
    if value < 0.011 { format!("{value:.4}") } else { format!("{value:.3}") }
}

/// A length to three digits, as the study's page has it.
fn three_digits(value: f64) -> String {
    if value < 0.1 { format!("{value:.4}") } else { format!("{value:.3}") }
}

/// A positive number to two digits, without noughts at its end.
fn two_digits(value: f64) -> String {
    let digits = (1.0 - value.log10().floor()).max(0.0) as usize;
    let text = format!("{value:.digits$}");
    if digits == 0 { text } else { text.trim_end_matches('0').trim_end_matches('.').to_owned() }
}

/// A probability above 0 to two digits.
fn probability(p: f64) -> String {
    if p >= 1.0 { "1".to_owned() } else { two_digits(p) }
}

/// A figure and the ends of its interval, of `0.883 (0.732 to 1.074)`.
fn with_ends(text: &str) -> [f64; 3] {
    let words = text.trim_end_matches(')').split([' ', '(']);
    let parts: Vec<f64> = words.filter_map(|word| word.parse().ok()).collect();
    parts.try_into().unwrap_or_else(|_| panic!("`{text}` is no figure with its interval"))
}

fn with_interval([value, low, high]: [f64; 3]) -> String {
    format!("{value:.2} ({low:.2} to {high:.2})")
}

/// Mean ATE over all sequences, of those of both sides \[m\].
fn mean(noise: &str) -> f64 {
    let (row, sides) = (row("study", &[("noise", noise)]), table("split"));
    let count = |side: &str| {
        let of_side = sides.iter().filter(|row| row["side"] == side && !row["sequence"].starts_with("all"));
        of_side.count() as f64
    };
    let (train, test) = (count("train"), count("test"));
    (train * number(&row["mean train [m]"]) + test * number(&row["mean test [m]"])) / (train + test)
}

/// How far the network's mean error is below that of the usual constants: ours and the paper's, as shares.
fn gains() -> [f64; 2] {
    let means = table("closed_loop").into_iter().find(|row| row["side"] == "both").unwrap();
    ["ours", "paper"].map(|whose| {
        let of = |noise: &str| number(&means[&format!("{noise}, {whose}")]);
        1.0 - of("DualProNet") / of("usual constant x1")
    })
}

fn headline() -> String {
    let best = row("study", &[("verdict", "reference")])["noise"].clone();
    let times = match best.as_str() {
        "x2" => "twice",
        "x4" => "four times",
        "x8" => "eight times",
        other => panic!("say {other} in words"),
    };
    let [ratio, low, high] =
        with_ends(&row("study", &[("noise", "dualpronet")])["ratio to best constant (95 %)"]);
    let does = match (low > 1.0, high < 1.0) {
        (true, _) => "does better",
        (_, true) => "does worse",
        _ => "is not shown to differ",
    };
    let ([ours, paper], [x1, dualpronet, constant]) =
        (gains().map(percent), ["x1", "dualpronet", &best].map(|noise| three_digits(mean(noise))));
    format!(
        "{ours} smaller than with the usual constants ({dualpronet} m instead of {x1} m; the paper: {paper}), and a constant {times} the usual {does} \
         ({constant} m; ratio of errors {ratio:.2}, 95 % interval {low:.2} to {high:.2})"
    )
}

/// Of a row with a comparison.
fn compared(row: &Record, ratio: &str, p: &str, quantity: &str) -> String {
    match quantity {
        "ratio" => with_interval(with_ends(&row[ratio])),
        "better" => row["better in"].clone(),
        "p" => probability(number(&row[p])),
        "equal" => probability(number(&row["p equal"])),
        "mean" => three_digits(mean(&row["noise"])),
        "median" => three_digits(number(&row["ATE median [m]"])),
        _ => panic!("{quantity}: no such quantity"),
    }
}

/// The constant that a course's noises are compared with.
fn best_of(course: &str) -> String {
    row("injected", &[("course", course), ("ratio to best constant (95 %)", "")])["noise"].clone()
}

/// Of noise added in a course; `best` is its best constant.
fn of_course(course: &str, noise: &str, quantity: &str) -> String {
    let of = |noise: &str| row("injected", &[("noise", noise), ("course", course)]);
    let mean = |noise: &str| number(&of(noise)["ATE mean [m]"]);
    let best = best_of(course);
    let noise = if noise == "best" { &best } else { noise };
    match quantity {
        "name" => noise.to_owned(),
        "mean" => three_digits(mean(noise)),
        "less" => percent(1.0 - mean(noise) / mean(&best)),
        // Of the way from the best constant to the truth.
        "closes" => percent((mean(&best) - mean(noise)) / (mean(&best) - mean("oracle"))),
        // Over the lower of the two.
        "over" => format!("{:.2}", mean(noise) / mean(&best).min(mean("oracle"))),
        _ => compared(&of(noise), "ratio to best constant (95 %)", "p (Holm)", quantity),
    }
}

/// Estimators that were fitted to features, which are no simple ones.
const REGRESSORS: [&str; 2] = ["elastic-net", "kernel-svr"];

/// Of the open loop; the raw windows are TUM-VI's, whose own noise counts.
fn open_loop(sensor: &str, base: &str, quantity: &str) -> String {
    let mut rows = if base == "raw" { raw_rows() } else { table("open_loop") };
    rows.retain(|row| row["sensor"] == sensor && row["base"] == base);
    let digits = if sensor == "accel" { 4 } else { 5 };
    let networks: Vec<&Record> = rows.iter().filter(|row| row["estimator"] == "pronet").collect();
    let [network] = networks[..] else { panic!("{sensor} {base}: {} rows of the network", networks.len()) };
    let of = |column: &str| format!("{:.digits$}", number(&network[column]));
    let other = |is_regressor: bool| {
        let kind = |row: &&Record| REGRESSORS.contains(&row["estimator"].as_str()) == is_regressor;
        let rmse = |row: &Record| number(&row["test RMSE"]);
        let of_kind = rows.iter().filter(|row| row["training seeds"] == "0").filter(kind);
        let best = of_kind.min_by(|a, b| rmse(a).total_cmp(&rmse(b))).expect("one of its kind");
        format!("{:.digits$} `{}`", rmse(best), best["estimator"])
    };
    match quantity {
        "rmse" => of("test RMSE"),
        "bound" => of("bound"),
        "spread" => format!("{:.1$}", number(&network["spread over seeds"]), digits + 1),
        "seeds" => network["training seeds"].clone(),
        "simple" => other(false),
        "regressor" => other(true),
        _ => panic!("{quantity}: no such quantity"),
    }
}

/// The test rows of raw windows, by the names of the table's columns.
fn raw_rows() -> Vec<Record> {
    let columns = [
        ("sensor", "sensor"),
        ("base", "base"),
        ("estimator", "estimator"),
        ("test RMSE", "rmse"),
        ("bound", "crb"),
        ("training seeds", "seeds"),
    ];
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let file = json("open_loop");
    let rows = file["rows"].as_array().unwrap().iter();
    rows.filter(|row| row["split"] == "test" && row["label"] == "sigma_tot" && row["base"] == "raw")
        .map(|row| columns.map(|(column, field)| (column.to_owned(), text(&row[field]))).into())
        .collect()
}

fn of_fleet(noise: &str, quantity: &str) -> String {
    let fleet = json("fleet");
    let line = if noise == "single" { &fleet["single"] } else { named(&fleet["noises"], "noise", noise) };
    let get = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{noise}: no {quantity}"));
    let (score, worst) = (&line["score"], &line["worst"][1]);
    let comparison = &line["comparison"];
    let ratio = || {
        [&comparison["ratio"], &comparison["ratio_interval"][0], &comparison["ratio_interval"][1]].map(get)
    };
    match quantity {
        "score" => format!("{:.2}", get(score)),
        "worst" => format!("{:.2}", get(worst)),
        "less" => percent(1.0 - get(score)),
        "more" => percent(get(worst) - 1.0),
        "less-than-single" => percent(1.0 - ratio()[0]),
        "ratio" => with_interval(ratio()),
        "better" => format!("{} of {}", comparison["better"], comparison["sequences"]),
        _ => panic!("{quantity}: no such quantity"),
    }
}

fn of_platform(platform: &str, noise: &str, quantity: &str) -> String {
    let fleet = json("fleet");
    let platform = named(&fleet["platforms"], "name", platform);
    let best = platform["best"].as_str().unwrap();
    let line = named(&platform["noises"], "noise", if noise == "best" { best } else { noise });
    let ate = metres(line["ate"].as_f64().unwrap());
    match quantity {
        "ate" if noise == "best" => format!("{ate} ({best})"),
        "ate" => ate,
        "score" => format!("{:.2}", line["score"].as_f64().unwrap()),
        _ => panic!("{quantity}: no such quantity"),
    }
}

fn of_vins(noise: &str, quantity: &str) -> String {
    let results = json("vins_mono");
    let get = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{noise}: no {quantity}"));
    if noise == "walks" {
        return metres(get(&results["walks_pasted_too"][format!("ate_{quantity}")]));
    }
    let line = named(&results["noises"], "noise", noise);
    match quantity {
        "ate" => metres(get(&line["ate"])),
        "ratio" => {
            with_interval([&line["ratio"], &line["ratio_interval"][0], &line["ratio_interval"][1]].map(get))
        }
        "better" => format!("{} of {}", line["better"], line["sequences"]),
        _ => panic!("{quantity}: no such quantity"),
    }
}

fn of_flight(sensor: &str, noise: &str) -> String {
    let results = json("flight");
    let rows: Vec<&Value> =
        results["rows"].as_array().unwrap().iter().filter(|row| row["sensor"] == sensor).collect();
    let get = |row: &Value, what: &str| row[what].as_f64().unwrap_or_else(|| panic!("{sensor}: no {what}"));
    if noise.starts_with("outside") {
        return percent(rows.iter().map(|row| get(row, noise)).fold(0.0, f64::max));
    }
    let square = |row: &&Value| (get(row, noise) / get(row, "truth")).ln().powi(2);
    format!("{:.2}", (rows.iter().map(square).sum::<f64>() / rows.len() as f64).sqrt().exp())
}

/// The rows of injected faults, by fault in their order.
fn faults() -> Vec<(String, Vec<Value>)> {
    let mut by_fault: Vec<(String, Vec<Value>)> = Vec::new();
    for row in json("faults").as_array().unwrap() {
        let fault = row["fault"].as_str().unwrap();
        match by_fault.iter_mut().find(|(known, _)| known == fault) {
            Some((_, rows)) => rows.push(row.clone()),
            None => by_fault.push((fault.to_owned(), vec![row.clone()])),
        }
    }
    by_fault
}

fn of_faults(quantity: &str) -> String {
    let mut faults = faults();
    let (none, sound) = faults.remove(0);
    assert_eq!(none, "none");
    let count = |is: &str| faults.iter().flat_map(|(_, rows)| rows).filter(|row| row["is"] == is).count();
    if quantity == "summary" {
        let (said, harmless, silent) = (count("said"), count("harmless"), count("silent"));
        let all = said + harmless + silent;
        return format!(
            "Of {all} runs {said} say so, {harmless} cost little, {silent} cost more and say nothing."
        );
    }
    let (mut lines, mut without) = (Vec::new(), Vec::new());
    for (fault, rows) in &faults {
        let said = rows.iter().filter(|row| row["is"] == "said").count();
        let mut names: BTreeMap<&str, usize> = BTreeMap::new();
        for name in rows.iter().flat_map(|row| row["names"].as_array().unwrap()) {
            *names.entry(name.as_str().unwrap()).or_default() += 1;
        }
        let mut names: Vec<_> = names.into_iter().collect();
        names.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let names: Vec<_> = names.into_iter().take(2).map(|(name, _)| name).collect();
        let of_sound = |row: &Value| {
            named(&Value::from(sound.clone()), "recording", row["recording"].as_str().unwrap())["error_m"]
                .as_f64()
                .unwrap()
        };
        let errors: Option<Vec<f64>> =
            rows.iter().map(|row| Some(row["error_m"].as_f64()? / of_sound(row))).collect();
        let scales: Option<Vec<f64>> =
            rows.iter().map(|row| Some((row["scale"].as_f64()? - 1.0).abs())).collect();
        let most = |of: Option<Vec<f64>>, text: fn(f64) -> String| {
            of.map_or("no pose".to_owned(), |of| text(of.into_iter().fold(0.0, f64::max)))
        };
        let cells = [
            fault.clone(),
            format!("{said}/{}", rows.len()),
            names.join(", "),
            most(errors, |factor| format!("{}x", two_digits(factor))),
            most(scales, |share| format!("{:.0}", 100.0 * share)),
        ];
        match cells[3].as_str() {
            "no pose" => without.push(cells[0].clone()),
            _ => lines.push(cells),
        }
    }
    if quantity == "without" {
        return without.join(", ");
    }
    block(["fault", "said on", "as", "error at most", "scale off by at most \\[%\\]"], lines)
}

/// A table as Markdown, between empty lines.
fn block<const COLUMNS: usize>(
    head: [&str; COLUMNS],
    rows: impl IntoIterator<Item = [String; COLUMNS]>,
) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let head = line(&head.map(str::to_owned)) + &"|---".repeat(COLUMNS) + "|\n";
    let rows: String = rows.into_iter().map(|cells| line(&cells)).collect();
    format!("\n\n{head}{rows}\n")
}

/// A noise and how a table names it.
type Named = (&'static str, &'static str);

const WIDE: &str = "plus(dualpronet(wide-s0),x4)";

/// Noises of the study or a course, each against its best constant, the first.
fn compared_table(of: &str, error: &str, reference: &str, noises: &[Named]) -> String {
    let head = [
        "noise given",
        &format!("{error} ATE \\[m\\]"),
        &format!("ratio to {reference}"),
        "lower on",
        "p after Holm",
    ];
    let row = |&(noise, name): &Named| {
        let get = |quantity: &str| value(&format!("{of}/{noise}/{quantity}"));
        let rest = if noise == reference {
            ["1", "-", "-"].map(str::to_owned)
        } else {
            ["ratio", "better", "p"].map(get)
        };
        let [ratio, better, p] = rest;
        [name.to_owned(), get(error), ratio, better, p]
    };
    block(head, noises.iter().map(row))
}

fn courses_table() -> String {
    let courses = [
        ("ramp", "ramp up to five times"),
        ("one-axis", "step on one axis"),
        ("tone", "90 Hz tone, nothing white"),
        ("bias-jump", "jump of the bias"),
    ];
    let row = |(course, name): (&str, &str)| {
        let ratio = |noise: &str| of_course(course, noise, "ratio");
        let [best, median] = ["name", "median"].map(|quantity| of_course(course, "best", quantity));
        [name.to_owned(), format!("{best}, {median}"), ratio("oracle"), ratio(WIDE), ratio("self")]
    };
    block(
        ["course", "best constant, median ATE \\[m\\]", "`oracle`", "the wide network", "`self`"],
        courses.map(row),
    )
}

/// The networks of every base beside what is simpler, and the least error that is possible.
fn open_table() -> String {
    let bases = ["sg(51,3)", "sg(11,2)", "sg(7,2)", "sg(5,2)", "raw"];
    let rows = bases.into_iter().flat_map(|base| ["accel", "gyro"].map(|sensor| (sensor, base)));
    let row = |(sensor, base): (&str, &str)| {
        let get = |quantity: &str| open_loop(sensor, base, quantity);
        let name = if base == "raw" { "raw TUM-VI rooms 3, 4".to_owned() } else { base.to_uppercase() };
        let spread = if base == "raw" { "1 seed".to_owned() } else { get("spread") };
        let network = format!("**{}** ({spread})", get("rmse"));
        [format!("{sensor}, {name}"), network, get("simple"), get("regressor"), get("bound")]
    };
    block(
        ["sensor, base", "network: RMSE (spread)", "best simple estimator", "best regressor", "bound"],
        rows.map(row),
    )
}

fn fleet_table() -> String {
    let platforms = [
        ("EuRoC Machine Hall, rendered images", "EuRoC Machine Hall, five, rendered images"),
        ("EuRoC Vicon room 1, rendered images", "EuRoC Vicon room 1, three, rendered images"),
        ("EuRoC Vicon room 2, rendered images", "EuRoC Vicon room 2, three, rendered images"),
        ("MH_01 carried by hand, real images", "MH_01's first 17 s, real images, one run"),
        ("simulated flights without vibration", "simulated flights without vibration, eleven"),
        ("simulated flights", "simulated flights with vibration, eleven"),
        ("TUM-VI rooms, tracks along the reconciled truth", "TUM-VI, four rooms, tracks, reconciled truth"),
        ("EuRoC, tracks along the published truth", "EuRoC, eleven, tracks, published truth"),
        ("EuRoC, tracks along the reconciled truth", "EuRoC, ten, tracks, reconciled truth"),
    ];
    let row = |(platform, name): (&str, &str)| {
        let ate = |noise: &str| of_platform(platform, noise, "ate");
        [name.to_owned(), ate("x1"), ate("best"), ate("self"), of_platform(platform, "self", "score")]
    };
    block(["mean ATE \\[m\\]", "x1", "best constant", "`self`", "ratio to the best"], platforms.map(row))
}

fn of_table(name: &str) -> String {
    let own = ("self", "[`self`](self.md), estimated while it runs");
    match name {
        "study" => compared_table(
            "study",
            "mean",
            "x4",
            &[
                ("x1", "x1, the usual constants"),
                ("x2", "x2"),
                ("x4", "x4, the best constant on the training sequences"),
                ("dualpronet", "`dualpronet`"),
                ("mean(dualpronet)", "`mean(dualpronet)`, its mean over the sequence"),
                ("shuffled(dualpronet)", "`shuffled(dualpronet)`, its values at the wrong times"),
                own,
            ],
        ),
        "step" => compared_table(
            "step",
            "median",
            "x16",
            &[
                ("x16", "x16, the best constant on the training sequences"),
                ("oracle", "`oracle`, the true noise"),
                (WIDE, "`plus(dualpronet(wide-s0),x4)`, the wide network"),
                ("mean(plus(dualpronet(wide-s0),x4))", "its mean over the sequence"),
                ("shuffled(plus(dualpronet(wide-s0),x4))", "its values at the wrong times"),
                ("dualpronet", "`dualpronet`, the network of the paper's kind"),
                own,
            ],
        ),
        "courses" => courses_table(),
        "open" => open_table(),
        "fleet" => fleet_table(),
        _ => panic!("{name}: no such table"),
    }
}

/// Mean of numbers of which there are some.
fn mean_of(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Ways to rates, a row each; a network's has a number a seed.
fn rates() -> String {
    let [euroc, tumvi, fetch] = ["euroc", "tumvi", "fetch"].map(|data| json(&format!("inertial_{data}")));
    let rows: [(&str, &[&str]); 8] = [
        ("raw", &["raw"]),
        ("affine", &["affine"]),
        ("affine, with gravity", &["affine, gravity"]),
        ("network", &["network 0", "network 1", "network 2"]),
        ("network, averaged over 20 s", &["network 0 averaged", "network 1 averaged", "network 2 averaged"]),
        (
            "the same, with gravity",
            &["network 0 averaged, gravity", "network 1 averaged, gravity", "network 2 averaged, gravity"],
        ),
        ("affine, true bias so far", &["affine, running bias"]),
        ("raw, its own mean bias", &["raw, its own mean bias"]),
    ];
    let row = |(row, ends): (&str, &[&str])| {
        let cell = |data: &Value, key: &str, of: fn(&[f64]) -> f64| {
            let one = |name: &&str| {
                let sequences = data["sequences"].as_array().unwrap().iter();
                let score = |sequence: &Value| {
                    let mut sources = sequence["sources"].as_array().unwrap().iter();
                    let score = &sources.find(|source| source["name"] == **name)?["score"];
                    // Over a second, as the papers' relative error.
                    let turns = score["turns"].as_array().unwrap();
                    score[key].as_f64().or_else(|| turns.iter().find(|t| t["span_s"] == 1.0)?[key].as_f64())
                };
                Some(format!("{:.2}", of(&sequences.map(score).collect::<Option<Vec<_>>>()?)))
            };
            // Where training did not choose gravity there is no such row.
            ends.iter().map(one).collect::<Option<Vec<_>>>().map_or("-".to_owned(), |all| all.join(", "))
        };
        let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        [
            row.to_owned(),
            cell(&euroc, "aoe_deg", mean_of),
            cell(&euroc, "aoe_deg", most),
            cell(&euroc, "quick_deg", mean_of),
            cell(&tumvi, "aoe_deg", mean_of),
            cell(&fetch, "aoe_deg", mean_of),
        ]
    };
    let head = ["rates", "EuRoC, AOE", "EuRoC, worst", "EuRoC, a second", "raw TUM-VI, AOE", "Fetch, AOE"];
    block(head, rows.map(row))
}

/// Ways to levels of noise on EuRoC, a row each; without MH_04, whose published truth jumps.
fn levels() -> String {
    let file = json("inertial_euroc");
    let sequences = file["sequences"].as_array().unwrap().iter();
    let kept = sequences.filter(|sequence| sequence["sequence"] != "MH_04_difficult");
    let all: Vec<&Value> = kept.flat_map(|sequence| sequence["spans"].as_array().unwrap()).collect();
    let row = |(name, words): (&str, &str)| {
        let of = |key: &str, span_s: f64| -> Vec<f64> {
            let is_meant = |score: &&&Value| score["name"] == name && score["span_s"] == span_s;
            all.iter().filter(is_meant).map(|score| score[key].as_f64().unwrap()).collect()
        };
        let [short, long] = [0.1, 1.0].map(|span_s| format!("{:.1}", mean_of(&of("nll", span_s))));
        let range = |key: &str| {
            let values = [of(key, 0.5), of(key, 1.0)].concat();
            let (least, most) =
                values.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(*v), b.max(*v)));
            format!("{least:.2} to {most:.2}")
        };
        let alone = named(&file["sequences"], "sequence", "V1_01_easy")["spans"].as_array().unwrap();
        let alone = alone.iter().find(|score| score["name"] == name && score["span_s"] == 1.0).unwrap();
        let alone = format!("{:.1}", alone["nll"].as_f64().unwrap());
        [words.to_owned(), short, long, range("nees"), range("inside"), alone]
    };
    let names = [
        ("x1", "x1"),
        ("x4", "x4"),
        ("dualpronet, scaled", "`dualpronet`, scaled"),
        ("one constant", "one constant"),
        ("a constant a platform", "a constant a platform"),
        ("a constant of the other platforms", "a constant of the other platforms"),
        ("residuals of the last 5 s", "residuals of the last 5 s"),
        ("oracle, a constant a sequence", "oracle, a constant a sequence"),
    ];
    let head = ["levels", "0.1 s", "1 s", "NEES / 9 at 0.5 and 1 s", "within 95 %", "V1_01 alone, 1 s"];
    block(head, names.map(row))
}

/// What a key stands for.
fn value(key: &str) -> String {
    let parts: Vec<&str> = key.split('/').collect();
    match parts[..] {
        ["headline"] => headline(),
        ["study", noise, quantity] => compared(
            &row("study", &[("noise", noise)]),
            "ratio to best constant (95 %)",
            "p (Holm)",
            quantity,
        ),
        ["pairs", noise, against, quantity] => {
            compared(&row("pairs", &[("noise", noise), ("against", against)]), "ratio (95 %)", "p", quantity)
        }
        [course @ ("step" | "ramp" | "one-axis" | "tone" | "bias-jump"), noise, quantity] => {
            of_course(course, noise, quantity)
        }
        ["open", sensor, base, quantity] => open_loop(sensor, base, quantity),
        ["fleet", noise, quantity] => of_fleet(noise, quantity),
        ["fleet", platform, noise, quantity] => of_platform(platform, noise, quantity),
        ["vins", noise, quantity] => of_vins(noise, quantity),
        ["flight", sensor, noise] => of_flight(sensor, noise),
        ["rest", quantity] => {
            let rest = json("rest");
            match quantity {
                "inside" => percent(rest["truth_inside"].as_f64().unwrap()),
                "median" => format!("{:.2}", rest["interval_median"].as_f64().unwrap()),
                "wider" => format!("{} of {}", rest["plateau_seen_wider_than_1.2"], rest["plateau_seen"]),
                "off" => rest["off_by_1.3"].to_string(),
                _ => panic!("{key}: no such quantity"),
            }
        }
        ["faults", quantity] => of_faults(quantity),
        ["inertial", "rates"] => rates(),
        ["inertial", "levels"] => levels(),
        ["table", name] => of_table(name),
        ["bench", name, unit] => {
            let ms = json("benches")[name]["median_ms"].as_f64().unwrap_or_else(|| panic!("no bench {name}"));
            let value = if unit == "us" { 1e3 * ms } else { ms };
            format!("{} {unit}", two_digits(value))
        }
        _ => panic!("{key}: no such number"),
    }
}

/// The text with every marked number as the results have it.
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

/// The text without marks.
pub(crate) fn plain(text: &str) -> String {
    let parts = text.split("<!--").enumerate();
    parts
        .map(|(i, part)| if i == 0 { part } else { part.split_once(CLOSE).map_or("", |(_, rest)| rest) })
        .collect()
}

#[test]
fn marked_numbers_are_those_of_the_results() {
    let mut stale = Vec::new();
    for page in crate::prose::pages().into_iter().chain([TARGETS.to_owned()]) {
        let text = read(&page);
        let made = filled(&text);
        if made != text && std::env::var_os("DPN_BLESS").is_some() {
            std::fs::write(at(&page), made).unwrap();
            continue;
        }
        let pairs = text.lines().zip(made.lines()).filter(|(is, should)| is != should);
        stale.extend(pairs.map(|(is, should)| format!("{page}: {is}\n  should be {should}")));
    }
    assert!(stale.is_empty(), "`cargo xtask book` writes them anew\n{}", stale.join("\n"));
}

#[test]
fn readme_book_targets_and_the_study_begin_with_one_answer() {
    for path in ["README.md", "docs/src/index.md", "docs/src/does-it-help.md", TARGETS] {
        assert!(read(path).contains("<!--n:headline-->"), "{path} has no headline");
    }
    let [ours, paper] = gains().map(percent);
    let [x1, dualpronet] = ["x1", "dualpronet"].map(|noise| three_digits(mean(noise)));
    let [ratio, low, high] =
        with_ends(&row("study", &[("noise", "dualpronet")])["ratio to best constant (95 %)"]);
    let path = "figures/euroc/index.html";
    let study = read(path).split_whitespace().collect::<Vec<_>>().join(" ").replace("&#39;", "'");
    for said in [
        format!(
            "mean error over 11 sequences is {dualpronet} m, {ours} below that of the usual constants (x1, {x1} m)"
        ),
        format!("In the paper's table it is {paper} below."),
        format!("sequence by sequence its error is {ratio:.2} times as large ({low:.2} to {high:.2})"),
    ] {
        assert!(study.contains(&said), "{path} does not say: {said}");
    }
}

#[test]
fn a_probability_has_two_digits() {
    assert_eq!(
        [1.0, 0.389, 0.0566, 0.0322, 0.007].map(probability),
        ["1", "0.39", "0.057", "0.032", "0.007"]
    );
}

#[test]
fn a_text_without_marks_keeps_its_words() {
    assert_eq!(plain("a <!--n:x/y-->0.1<!--/n--> b"), "a 0.1 b");
}
