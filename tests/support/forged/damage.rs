//! Damage as disks, editors and cut downloads do it.

/// Numbers from a seed: Knuth's linear congruential generator, so that no crate's version moves a case.
pub struct Draw(u64);

impl Draw {
    /// The numbers of `seed` for what is called `name`.
    pub fn new(seed: u64, name: &str) -> Self {
        Self(name.bytes().fold(seed, |state, byte| state.wrapping_mul(31).wrapping_add(u64::from(byte))))
    }

    /// From 0 to 1.
    pub fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A whole number below `end`.
    pub fn below(&mut self, end: usize) -> usize {
        (self.share() * end as f64) as usize
    }
}

/// What a reader of text may stumble over.
const WORDS: [&[u8]; 18] = [
    b",",
    b"\n",
    b"\r",
    b"\0",
    b"\xff\xfe",
    b"nan",
    b"-inf",
    b"1e999",
    b"1e30",
    b"#",
    b"\"",
    b"-",
    b"99999999999999999999",
    b": ",
    b"&a *a",
    b"[[[[",
    b"e",
    b" ",
];
/// What a reader of lengths may.
const LENGTHS: [u32; 6] = [0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_fffe, 0xffff_ffff];

/// One to four damages, anywhere.
pub fn damage(bytes: &mut Vec<u8>, draw: &mut Draw) {
    for _ in 0..=draw.below(4) {
        if bytes.is_empty() {
            return;
        }
        let at = draw.below(bytes.len());
        match draw.below(8) {
            0 => bytes[at] = draw.below(256) as u8,
            1 => bytes[at] ^= 1 << draw.below(8),
            2 => bytes.truncate(at),
            3 => drop(bytes.remove(at)),
            4 | 5 => {
                let word = WORDS[draw.below(WORDS.len())];
                bytes.splice(at..at, word.iter().copied());
            }
            6 => {
                let word = LENGTHS[draw.below(LENGTHS.len())].to_le_bytes();
                let end = (at + 4).min(bytes.len());
                bytes[at..end].copy_from_slice(&word[..end - at]);
            }
            _ => {
                let end = (at + 1 + draw.below(200)).min(bytes.len());
                let copy = bytes[at..end].to_vec();
                let to = draw.below(bytes.len() + 1);
                bytes.splice(to..to, copy);
            }
        }
    }
}
