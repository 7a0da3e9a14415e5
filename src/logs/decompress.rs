//! A chunk's compressed bytes, as far as they go.

use crate::budget::Budget;
use dpn_io::printable;
use std::io::Read;

/// A chunk is not larger than this, whatever it says; rosbag's and MCAP's writers make them of about a megabyte.
pub(crate) const LARGEST: u64 = 1 << 30;

/// A window that zstd may want for any data; its levels up to 19 want 8 MB at most.
const WINDOW_ALWAYS: u64 = 8 << 20;
/// And for so many packed bytes: a frame in one segment has a window as large as its content.
const WINDOW_TIMES: u64 = 8;

/// What came out, and what was wrong where it ended early.
#[derive(Debug)]
pub(crate) struct Plain {
    pub(crate) bytes: Vec<u8>,
    pub(crate) damage: Option<String>,
}

/// Undoes the compression called `name` (`""`, `none`, `lz4`, `bz2`, `zstd`), giving at most `size` bytes and what `budget` allows.
pub(crate) fn decompress(name: &str, packed: Vec<u8>, size: u64, budget: &mut Budget) -> Plain {
    let size = size.min(LARGEST);
    match name {
        "" | "none" => Plain { bytes: packed, damage: None },
        "lz4" => {
            all(lz4_flex::frame::FrameDecoder::new(packed.as_slice()), packed.len(), size, "lz4", budget)
        }
        "bz2" => all(bzip2::read::MultiBzDecoder::new(packed.as_slice()), packed.len(), size, "bz2", budget),
        "zstd" if window(&packed) > WINDOW_ALWAYS + WINDOW_TIMES * packed.len() as u64 => {
            let (window, length) = (window(&packed) >> 20, packed.len());
            let damage = format!("bad zstd data: {length} bytes want a window of {window} MB");
            Plain { bytes: Vec::new(), damage: Some(damage) }
        }
        "zstd" => match ruzstd::decoding::StreamingDecoder::new(packed.as_slice()) {
            Ok(decoder) => all(decoder, packed.len(), size, "zstd", budget),
            Err(error) => Plain { bytes: Vec::new(), damage: Some(format!("bad zstd data: {error}")) },
        },
        other => Plain {
            bytes: Vec::new(),
            damage: Some(format!("a chunk is compressed by `{}`, which is not known", printable(other))),
        },
    }
}

/// The window that a zstd frame's head asks for \[bytes\], which its decoder fills before it gives anything; 0 where there is no head.
///
/// Source: RFC 8878, 3.1.1.1.
pub(crate) fn window(packed: &[u8]) -> u64 {
    let [_, _, _, _, descriptor, rest @ ..] = packed else { return 0 };
    if descriptor & 0x20 == 0 {
        let Some(byte) = rest.first() else { return 0 };
        let base = 1u64 << (10 + (byte >> 3));
        return base + base / 8 * u64::from(byte & 7);
    }
    let dictionary = [0, 1, 2, 4][usize::from(descriptor & 3)];
    let length = [1, 2, 4, 8][usize::from(descriptor >> 6)];
    let Some(content) = rest.get(dictionary..dictionary + length) else { return 0 };
    let content = content.iter().rev().fold(0, |sum, byte| sum << 8 | u64::from(*byte));
    if length == 2 { content + 256 } else { content }
}

fn all(decoder: impl Read, packed: usize, size: u64, name: &str, budget: &mut Budget) -> Plain {
    let room = budget.open(packed).min(size);
    let mut decoder = decoder.take(room);
    // All the room at once: a vector that grows holds itself twice while it does.
    let mut bytes = Vec::with_capacity(room as usize);
    // What was decoded before an error stays in the vector.
    let mut damage = decoder.read_to_end(&mut bytes).err().map(|error| format!("bad {name} data: {error}"));
    budget.unpacked(bytes.len());
    if damage.is_none() && room < size && bytes.len() as u64 == room {
        decoder.set_limit(1);
        if decoder.read(&mut [0]).is_ok_and(|more| more > 0) {
            damage = Some(budget.exceeded());
        }
    }
    Plain { bytes, damage }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    /// Zeros, as bz2 packs them: 70,000 times smaller.
    fn bomb(bytes: usize) -> Vec<u8> {
        let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::best());
        encoder.write_all(&vec![0; bytes]).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn a_frame_of_few_bytes_that_wants_a_large_window_is_refused() {
        assert_eq!(window(b"\x28\xb5\x2f\xfd\x00\x80"), 64 << 20);
        assert_eq!(window(b"\x28\xb5\x2f\xfd\x00\x09"), 2304);
        assert_eq!(window(b"\x28\xb5\x2f\xfd\x20\x07"), 7);
        assert_eq!(window(b"\x28\xb5\x2f\xfd\x60\x01\x01"), 513);
        assert_eq!(window(b"\x28\xb5\x2f\xfd\xa1\x01\0\0\0\x01"), 1 << 24);
        assert_eq!(window(b"\x28\xb5"), 0);
        let packed = [&b"\x28\xb5\x2f\xfd\x00\x80"[..], &[0x03, 0, 0x10, 0]].concat();
        let damage = decompress("zstd", packed, 1 << 30, &mut Budget::new(None)).damage;
        assert_eq!(damage.as_deref(), Some("bad zstd data: 10 bytes want a window of 64 MB"));
    }

    #[test]
    fn a_bomb_is_cut_off_where_its_bytes_no_longer_explain_it_unless_a_limit_is_given() {
        let bomb = bomb(20 << 20);
        let mut budget = Budget::new(None);
        let first = decompress("bz2", bomb.clone(), 1 << 30, &mut budget);
        assert_eq!((first.bytes.len(), first.damage), (20 << 20, None));
        // The sum of a log's chunks counts.
        let second = decompress("bz2", bomb.clone(), 1 << 30, &mut budget);
        assert!(second.bytes.len() < 13 << 20);
        let damage = second.damage.unwrap();
        assert!(
            damage.starts_with("unpacks to more than 32 MB, from ") && damage.contains("--max-uncompressed"),
            "{damage}"
        );
        let mut given = Budget::new(Some(64 << 20));
        for _ in 0..2 {
            assert_eq!(decompress("bz2", bomb.clone(), 1 << 30, &mut given).damage, None);
        }
    }
}
