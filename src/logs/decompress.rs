//! A chunk's compressed bytes, as far as they go.

use std::io::Read;

/// A chunk is not larger than this, whatever it says; rosbag's and MCAP's writers make them of about a megabyte.
pub(crate) const LARGEST: u64 = 1 << 30;

/// What came out, and what was wrong where it ended early.
#[derive(Debug)]
pub(crate) struct Plain {
    pub(crate) bytes: Vec<u8>,
    pub(crate) damage: Option<String>,
}

/// Undoes the compression called `name` (`""`, `none`, `lz4`, `bz2`, `zstd`), giving at most `size` bytes.
pub(crate) fn decompress(name: &str, packed: Vec<u8>, size: u64) -> Plain {
    let size = size.min(LARGEST);
    match name {
        "" | "none" => Plain { bytes: packed, damage: None },
        "lz4" => all(lz4_flex::frame::FrameDecoder::new(packed.as_slice()), size, "lz4"),
        "bz2" => all(bzip2::read::MultiBzDecoder::new(packed.as_slice()), size, "bz2"),
        "zstd" => match ruzstd::decoding::StreamingDecoder::new(packed.as_slice()) {
            Ok(decoder) => all(decoder, size, "zstd"),
            Err(error) => Plain { bytes: Vec::new(), damage: Some(format!("bad zstd data: {error}")) },
        },
        other => Plain {
            bytes: Vec::new(),
            damage: Some(format!("a chunk is compressed by `{other}`, which is not known")),
        },
    }
}

fn all(decoder: impl Read, size: u64, name: &str) -> Plain {
    let mut decoder = decoder.take(size);
    let mut bytes = Vec::with_capacity(size.min(1 << 22) as usize);
    // What was decoded before an error stays in the vector.
    let damage = decoder.read_to_end(&mut bytes).err().map(|error| format!("bad {name} data: {error}"));
    Plain { bytes, damage }
}
