//! The fields of a ROS message one after the other, in ROS 1's encoding and in CDR.
//!
//! ROS 1 packs them without gaps, little-endian. CDR begins with four bytes that name its representation; numbers lie at multiples of their size, counted
//! from behind these (of version 2, of four bytes at most), in either order of bytes. Source: OMG DDS-XTypes 1.3, 7.4.

use std::fmt;

/// How a message was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// ROS 1's.
    Ros1,
    /// ROS 2's, behind the four bytes of its representation.
    Cdr,
}

impl Encoding {
    /// As MCAP's channels and rosbag2's topics name it.
    ///
    /// # Errors
    /// A name that is not known, back.
    pub(crate) fn named(name: &str) -> Result<Self, String> {
        match name {
            "ros1" => Ok(Self::Ros1),
            "cdr" => Ok(Self::Cdr),
            other => Err(other.to_owned()),
        }
    }
}

/// Why a message is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Undecodable {
    /// Its bytes end before its fields.
    Short,
    /// It begins with another representation than plain CDR.
    Representation(u16),
}

/// What messages of the wanted type are instead.
impl fmt::Display for Undecodable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Short => f.write_str("end before their fields do"),
            Self::Representation(id @ (8 | 9)) => {
                write!(f, "are in delimited CDR (XCDR2, {id:#06x}), which is not known")
            }
            Self::Representation(id @ (2 | 3 | 10 | 11)) => {
                write!(f, "are in CDR with parameter lists ({id:#06x}), which is not known")
            }
            Self::Representation(id) => write!(f, "begin with {id:#06x}, which is no CDR"),
        }
    }
}

/// What a message's header says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header<'a> {
    /// Nanoseconds; 0 where nobody stamped it.
    pub t_ns: i64,
    /// Name of the frame, in CDR with the zero that ends it.
    pub frame: &'a [u8],
}

impl Header<'_> {
    /// The frame as text; what is no UTF-8 is replaced.
    pub fn frame_id(&self) -> String {
        text_of(self.frame)
    }
}

/// Text without the zero that ends CDR's; what is no UTF-8 is replaced.
fn text_of(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes.strip_suffix(b"\0").unwrap_or(bytes)).into_owned()
}

impl std::error::Error for Undecodable {}

/// A cursor over a message; every read is `None` where the bytes end.
#[derive(Debug, Clone, Copy)]
pub struct Fields<'a> {
    body: &'a [u8],
    at: usize,
    /// Numbers lie at multiples of their size, or of this where it is smaller.
    align: usize,
    little: bool,
    encoding: Encoding,
}

impl<'a> Fields<'a> {
    /// At a message's first field.
    ///
    /// # Errors
    /// CDR in no plain representation.
    pub fn new(data: &'a [u8], encoding: Encoding) -> Result<Self, Undecodable> {
        let packed = Self { body: data, at: 0, align: 1, little: true, encoding };
        if encoding == Encoding::Ros1 {
            return Ok(packed);
        }
        let Some(([high, low, _, _], body)) = data.split_first_chunk::<4>() else {
            return Err(Undecodable::Short);
        };
        let (align, little) = match u16::from_be_bytes([*high, *low]) {
            kind @ (0 | 1) => (8, kind == 1),
            kind @ (6 | 7) => (4, kind == 7),
            other => return Err(Undecodable::Representation(other)),
        };
        Ok(Self { body, align, little, ..packed })
    }

    /// A `std_msgs/Header`: in ROS 1 a sequence number, then seconds, nanoseconds and a frame.
    pub fn header(&mut self) -> Option<Header<'a>> {
        if self.encoding == Encoding::Ros1 {
            let _sequence = self.u32()?;
        }
        let (seconds, nanos) = (self.u32()?, self.u32()?);
        let seconds = match self.encoding {
            Encoding::Ros1 => i64::from(seconds),
            Encoding::Cdr => i64::from(seconds.cast_signed()),
        };
        let frame = self.counted()?;
        Some(Header { t_ns: seconds * 1_000_000_000 + i64::from(nanos), frame })
    }

    /// The next byte.
    pub fn u8(&mut self) -> Option<u8> {
        self.number::<1>().map(|[byte]| byte)
    }

    /// The next 32 bits.
    pub fn u32(&mut self) -> Option<u32> {
        self.number().map(u32::from_le_bytes)
    }

    /// The next double.
    pub fn f64(&mut self) -> Option<f64> {
        self.number().map(f64::from_le_bytes)
    }

    /// What a length of 32 bits in front of it counts.
    pub fn counted(&mut self) -> Option<&'a [u8]> {
        let length = self.u32()? as usize;
        let bytes = self.body.get(self.at..self.at.checked_add(length)?)?;
        self.at += length;
        Some(bytes)
    }

    /// The same as text, without the zero that ends CDR's; what is no UTF-8 is replaced.
    pub fn text(&mut self) -> Option<String> {
        self.counted().map(text_of)
    }

    /// Where the next double lies in the message, and whether its lowest byte is first; the double is passed over.
    #[cfg(feature = "write")]
    pub(crate) fn place_of_f64(&mut self) -> Option<(std::ops::Range<usize>, bool)> {
        self.f64()?;
        let head = match self.encoding {
            Encoding::Ros1 => 0,
            Encoding::Cdr => 4,
        };
        Some((head + self.at - 8..head + self.at, self.little))
    }

    /// A number's bytes, the lowest first.
    fn number<const N: usize>(&mut self) -> Option<[u8; N]> {
        let from = self.at.checked_next_multiple_of(self.align.min(N))?;
        let mut bytes: [u8; N] = self.body.get(from..from.checked_add(N)?)?.try_into().ok()?;
        self.at = from + N;
        if !self.little {
            bytes.reverse();
        }
        Some(bytes)
    }
}
