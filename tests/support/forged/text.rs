//! Settings and tables as text.

use super::Forged;

/// Configurations of other programs.
pub fn yaml() -> Vec<Forged> {
    let mut all = Vec::new();
    let mut text =
        |name: &str, make: fn() -> String| all.push(Forged::new(name, move || make().into_bytes()));
    text("deep lists", || "[".repeat(100_000));
    text("deep blocks", || (0..2000).map(|i| format!("{}a:\n", " ".repeat(i))).collect());
    text("deep braces", || "{a: ".repeat(100_000));
    text("a billion laughs", || {
        let laughs = (b'b'..b'm').map(|name| {
            let (name, before) = (char::from(name), char::from(name - 1));
            format!("{name}: &{name} [{}]\n", vec![format!("*{before}"); 9].join(","))
        });
        format!("a: &a [1,1,1,1,1,1,1,1,1]\n{}", laughs.collect::<String>())
    });
    text("a long list", || format!("acc_n: [{}1]\n", "1,".repeat(1 << 20)));
    text("many keys", || (0..200_000).map(|i| format!("k{i}: 1\n")).collect());
    text("many documents", || "---\na: 1\n".repeat(100_000));
    text("a long word", || "a".repeat(3 << 20));
    text("directives", || "%\n".repeat(1 << 20));
    text("too much", || "a: 1\n".repeat(4 << 20));
    all
}

/// Tables of tracks, of noise and of poses.
pub fn tables() -> Vec<Forged> {
    let mut all = Vec::new();
    let mut text =
        |name: &str, make: fn() -> String| all.push(Forged::new(name, move || make().into_bytes()));
    text("20,000 tracks a frame", || {
        let tracks: String = (0..20_000).map(|id| format!(" {id} 1 2")).collect();
        (0..20).map(|t| format!("{t} 20000{tracks}\n")).collect()
    });
    text("half a million frames of nothing", || (0..500_000).map(|t| format!("{t} 0\n")).collect());
    text("a frame of a million numbers", || format!("1 9{}", " 1".repeat(1 << 20)));
    text("a short first row", || format!("1\n{}", "22,333\n".repeat(500_000)));
    text("a line of delimiters", || ",".repeat(4 << 20));
    text("half a million stamps", || (0..500_000).map(|t| format!("{t}\n")).collect());
    all
}

/// Texts that are no configuration of ours.
pub fn toml() -> Vec<Forged> {
    let mut all = Vec::new();
    let mut text = |name: &str, make: fn() -> Vec<u8>| all.push(Forged::new(name, make));
    text("deep lists", || [b"a=".to_vec(), b"[".repeat(100_000)].concat());
    text("deep tables", || [b"a=".to_vec(), b"{a=".repeat(100_000)].concat());
    text("a long dotted key", || [b"a.".repeat(100_000), b"a=1".to_vec()].concat());
    text("a table of many levels", || [b"[a".to_vec(), b".a".repeat(100_000), b"]\n".to_vec()].concat());
    text("a list of lists", || "[[a]]\n".repeat(50_000).into_bytes());
    text("many keys", || (0..30_000).map(|i| format!("k{i}=1\n")).collect::<String>().into_bytes());
    text("a long number", || [b"a=".to_vec(), vec![b'9'; 200_000]].concat());
    text("a string without an end", || [b"a=\"\"\"".to_vec(), vec![b'x'; 200_000]].concat());
    text("zeros", || vec![0; 1000]);
    text("no UTF-8", || b"\xff\xfe\xff".to_vec());
    text("too much", || b"# \n".repeat(3 << 20));
    text("a date", || b"seed = 1979-05-27T07:32:00Z".to_vec());
    all
}
