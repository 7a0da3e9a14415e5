//! How many bytes a log may unpack to: what it has, many times over, and not what a head in it says.

/// A log may unpack to so many bytes in any case,
const ALWAYS: u64 = 32 << 20;
/// and to so many times the packed bytes read so far. IMU and camera messages shrink by 2 to 20 times.
const TIMES: u64 = 32;

/// Counts what was read packed and what came out of it.
#[derive(Debug, Default)]
pub(crate) struct Budget {
    most: Option<u64>,
    packed: u64,
    unpacked: u64,
}

impl Budget {
    /// With the caller's own limit instead, where there is one.
    pub(crate) fn new(most: Option<u64>) -> Self {
        Self { most, ..Self::default() }
    }

    /// Takes note of `packed` more bytes; returns how many may come out of them.
    pub(crate) fn open(&mut self, packed: usize) -> u64 {
        self.packed += packed as u64;
        self.limit().saturating_sub(self.unpacked)
    }

    /// Takes note of what came out.
    pub(crate) fn unpacked(&mut self, bytes: usize) {
        self.unpacked += bytes as u64;
    }

    /// What is wrong with a log that wants more.
    pub(crate) fn exceeded(&self) -> String {
        format!(
            "unpacks to more than {} MB, from {} bytes; --max-uncompressed 4GB lets it",
            self.limit() >> 20,
            self.packed
        )
    }

    fn limit(&self) -> u64 {
        self.most.unwrap_or(ALWAYS.saturating_add(TIMES.saturating_mul(self.packed)))
    }
}
