//! Images and weights.

use super::Forged;

/// A PNG's head that says 65535 x 65535 grey pixels of 8 bits, and nothing behind it.
pub const GIANT_PNG: &[u8] =
    b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\xff\xff\0\0\xff\xff\x08\0\0\0\0\x0c\xe5\x3a\x51\0\0\0\x02IDAT\x78\x9c";

/// Files in place of an image.
pub fn images() -> Vec<Forged> {
    let mut all = Vec::new();
    let mut image = |name: &str, make: fn() -> Vec<u8>| all.push(Forged::new(name, make));
    image("a giant's head", || GIANT_PNG.to_vec());
    image("a head of no size", || GIANT_PNG.iter().map(|b| if *b == 0xff { 0 } else { *b }).collect());
    image("a signature", || GIANT_PNG[..8].to_vec());
    image("nothing", Vec::new);
    image("zeros", || vec![0; 1 << 20]);
    image("a page", || b"<html>not found</html>".to_vec());
    image("a chunk of four gigabytes", || [&GIANT_PNG[..33], &[0xff; 4], b"IDAT", &[0; 100]].concat());
    image("text without an end", || {
        [&GIANT_PNG[..33], &b"\0\0\x10\0tEXt".repeat(1000), &[b'x'; 1 << 16]].concat()
    });
    all
}

/// What is made of good weights.
pub type Spoil = fn(&[u8]) -> Vec<u8>;

/// A safetensors file of this head.
fn headed(head: &[u8], rest: &[u8]) -> Vec<u8> {
    [&(head.len() as u64).to_le_bytes(), head, rest].concat()
}

/// Weights and checkpoints, some of them of good ones.
pub fn safetensors() -> Vec<(&'static str, Spoil)> {
    vec![
        ("nothing", |_| Vec::new()),
        ("a head of many gigabytes", |_| [&[0xff; 7][..], &[0], b"{}"].concat()),
        ("a head of a hundred megabytes", |_| [&100_000_000u64.to_le_bytes()[..], b"{}"].concat()),
        ("an empty head", |_| headed(b"{}", b"")),
        ("a deep head", |_| headed(&b"[".repeat(100_000), b"")),
        ("a deep head of tables", |_| headed(&b"{\"a\":".repeat(40_000), b"")),
        ("a tensor beyond the end", |_| {
            headed(br#"{"a":{"dtype":"F32","shape":[1073741824],"data_offsets":[0,4294967296]}}"#, b"")
        }),
        ("a shape that overflows", |_| {
            headed(br#"{"a":{"dtype":"F32","shape":[4294967296,4294967296],"data_offsets":[0,0]}}"#, b"")
        }),
        ("tensors that overlap", |_| {
            let tensor = r#"{"dtype":"F32","shape":[1],"data_offsets":[0,4]}"#;
            let all: Vec<String> = (0..2000).map(|i| format!("\"{i}\":{tensor}")).collect();
            headed(format!("{{{}}}", all.join(",")).as_bytes(), &[0; 4])
        }),
        ("cut in half", |good| good[..good.len() / 2].to_vec()),
        ("cut by a byte", |good| good[..good.len() - 1].to_vec()),
        ("a byte too many", |good| [good, b"x"].concat()),
        ("a bit turned", |good| {
            let mut bytes = good.to_vec();
            *bytes.last_mut().expect("weights have bytes") ^= 1;
            bytes
        }),
        ("numbers of zeros", |good| {
            let end = 8 + u64::from_le_bytes(good[..8].try_into().expect("eight bytes")) as usize;
            [&good[..end], &vec![0; good.len() - end]].concat()
        }),
        ("good ones", <[u8]>::to_vec),
    ]
}
