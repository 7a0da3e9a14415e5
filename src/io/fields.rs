//! Bytes to lines and lines to fields.

/// Fields that are told apart in a line; what is behind them is one more. No table is that wide.
pub(super) const MOST_FIELDS: usize = 4096;

/// What stands between two fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Delimiter {
    Byte(u8),
    Blanks,
}

impl Delimiter {
    /// The one that `line` uses. Commas beside semicolons or tabs are decimal ones, one a field, unless each tab only follows a comma.
    pub(super) fn of(line: &[u8]) -> Self {
        let count = |byte: u8| memchr::memchr_iter(byte, line).count();
        let commas = count(b',');
        let decimal = |byte: u8| count(byte) > 0 && commas <= count(byte) + 1;
        let behind_commas =
            || memchr::memchr_iter(b'\t', line).all(|at| line[..at].trim_ascii_end().ends_with(b","));
        if decimal(b';') {
            Self::Byte(b';')
        } else if decimal(b'\t') && !behind_commas() {
            Self::Byte(b'\t')
        } else if commas > 0 {
            Self::Byte(b',')
        } else {
            Self::Blanks
        }
    }

    /// Puts the fields of `line` into `fields`.
    pub(super) fn split<'a>(self, line: &'a [u8], fields: &mut Vec<&'a [u8]>) {
        fields.clear();
        match self {
            Self::Byte(byte) => {
                let mut start = 0;
                for end in memchr::memchr_iter(byte, line).take(MOST_FIELDS) {
                    fields.push(bare(&line[start..end]));
                    start = end + 1;
                }
                let last = bare(&line[start..]);
                if !last.is_empty() || start == 0 {
                    fields.push(last);
                }
            }
            Self::Blanks => {
                fields.extend(
                    line.split(u8::is_ascii_whitespace)
                        .filter(|f| !f.is_empty())
                        .map(bare)
                        .take(MOST_FIELDS + 1),
                );
            }
        }
    }

    /// The same where delimiters may stand between double quotes, as spreadsheets write decimal commas; nothing changes without quotes.
    pub(super) fn split_quoted<'a>(self, line: &'a [u8], fields: &mut Vec<&'a [u8]>) {
        let Self::Byte(byte) = self else { return };
        if memchr::memchr(b'"', line).is_none() {
            return;
        }
        fields.clear();
        let (mut start, mut quoted) = (0, false);
        for at in memchr::memchr2_iter(b'"', byte, line) {
            if line[at] == b'"' {
                quoted = !quoted;
            } else if !quoted && fields.len() < MOST_FIELDS {
                fields.push(bare(&line[start..at]));
                start = at + 1;
            }
        }
        let last = bare(&line[start..]);
        if !last.is_empty() || start == 0 {
            fields.push(last);
        }
    }
}

/// A field without blanks and double quotes around it.
fn bare(field: &[u8]) -> &[u8] {
    // The usual field has neither, and a look at both ends is all it costs.
    match field {
        [a, .., b] if a.is_ascii_alphanumeric() && b.is_ascii_alphanumeric() => field,
        _ => {
            let field = field.trim_ascii();
            match field {
                [b'"', inner @ .., b'"'] => inner.trim_ascii(),
                _ => field,
            }
        }
    }
}

/// Takes one line off `rest`, without its end and without blanks around it; `None` when nothing is left.
pub(super) fn take_line<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    if rest.is_empty() {
        return None;
    }
    let (line, tail) = match memchr::memchr(b'\n', rest) {
        Some(end) => (&rest[..end], &rest[end + 1..]),
        None => (*rest, &rest[rest.len()..]),
    };
    *rest = tail;
    Some(line.trim_ascii())
}

/// What stands behind the sign of a comment.
pub(super) fn comment(line: &[u8]) -> Option<&[u8]> {
    match line {
        [b'#' | b'%' | b'!', rest @ ..] | [b'/', b'/', rest @ ..] => Some(rest),
        // Without the blank, a row whose first field is empty.
        [b';', b' ', rest @ ..] => Some(rest),
        _ => None,
    }
}

/// A number, NaN and infinities included; `None` where it is none.
pub(super) fn number(field: &[u8]) -> Option<f64> {
    fast_float2::parse(field).ok().or_else(|| fast_float2::parse(with_point(field)?).ok())
}

/// The same text with a point where its one comma is.
pub(super) fn with_point(field: &[u8]) -> Option<Vec<u8>> {
    // No number is longer, whatever a table may hold.
    let at = memchr::memchr(b',', field).filter(|_| field.len() <= 64)?;
    let mut text = field.to_vec();
    text[at] = b'.';
    Some(text)
}

/// Whether a field reads as a number, NaN and infinities included.
pub(super) fn is_number(field: &[u8]) -> bool {
    number(field).is_some()
}

/// Whether a field is a name of time, as the first of a commented header is.
pub(super) fn names_time(field: &[u8]) -> bool {
    let lower = field.to_ascii_lowercase();
    [&b"t"[..], b"t_ns", b"t_s"].contains(&lower.as_slice())
        || [&b"time"[..], b"stamp", b"#time"].iter().any(|p| lower.starts_with(p))
}

/// A field for a message: printable and short.
pub(super) fn shown(field: &[u8]) -> String {
    const MOST: usize = 40;
    let text = String::from_utf8_lossy(field);
    let mut out: String = text.chars().take(MOST).flat_map(char::escape_debug).collect();
    if text.chars().nth(MOST).is_some() {
        out.push_str("...");
    }
    out
}
