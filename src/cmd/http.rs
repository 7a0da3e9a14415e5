//! HTTP for a browser on this machine: `GET` alone, and bounds on everything that somebody else decides.
//!
//! A connection is one request and a thread. Its header has [`HEADER`] bytes and [`PATIENCE`] to come; what has a body is refused before the body is looked
//! at. An answer has as long as a slow reader takes for its bytes. Where [`WAITING`] connections have asked for nothing yet, the oldest of them
//! goes for a new one, so that who comes to ask is heard however many others are silent.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The longest header \[bytes\].
const HEADER: usize = 8 << 10;
/// Fields of a header.
pub(super) const FIELDS: usize = 64;
/// How long a header may take to come, and a piece of an answer to be taken.
const PATIENCE: Duration = Duration::from_secs(5);
/// Connections that have not asked yet.
const WAITING: usize = 32;
/// Answers that are on their way.
const ANSWERING: usize = 16;
/// The slowest reader that is waited for \[bytes/s\].
const SLOWEST: u64 = 1 << 18;

/// A request.
#[derive(Debug)]
pub(super) struct Asked<'a> {
    pub(super) path: &'a str,
    pub(super) host: Option<&'a str>,
    pub(super) range: Option<&'a str>,
}

/// What is answered.
pub(super) struct Answer<'a> {
    status: &'static str,
    /// Lines of the header.
    fields: String,
    body: Box<dyn Read + 'a>,
    length: u64,
}

impl<'a> Answer<'a> {
    /// Nothing but a status.
    pub(super) fn empty(status: &'static str) -> Self {
        Self::new(status, &[], io::empty(), 0)
    }

    /// So many bytes of `body`.
    pub(super) fn new(
        status: &'static str,
        fields: &[(&str, &str)],
        body: impl Read + 'a,
        length: u64,
    ) -> Self {
        let fields = fields.iter().map(|(name, value)| format!("{name}: {value}\r\n")).collect();
        Self { status, fields, body: Box::new(body), length }
    }

    fn write(mut self, to: &mut TcpStream) -> io::Result<()> {
        let until = Instant::now() + PATIENCE + Duration::from_secs(self.length / SLOWEST);
        to.set_write_timeout(Some(PATIENCE))?;
        let Self { status, fields, length, .. } = &self;
        let head =
            format!("HTTP/1.1 {status}\r\n{fields}Content-Length: {length}\r\nConnection: close\r\n\r\n");
        to.write_all(head.as_bytes())?;
        let mut body = (&mut self.body).take(self.length);
        let mut piece = vec![0; 1 << 16];
        loop {
            let read = body.read(&mut piece)?;
            if read == 0 {
                return to.shutdown(Shutdown::Write);
            }
            if Instant::now() > until {
                return Err(io::ErrorKind::TimedOut.into());
            }
            to.write_all(&piece[..read])?;
        }
    }
}

/// Answers whoever asks, without end.
pub(super) fn serve<'a>(listener: &TcpListener, answer: impl Fn(&Asked<'_>) -> Answer<'a> + Sync) -> ! {
    let (waiting, answering) = (Waiting::default(), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        loop {
            let Ok((stream, _)) = listener.accept() else {
                // Out of files, most likely: those who wait give theirs back.
                waiting.drop_oldest();
                std::thread::sleep(Duration::from_millis(20));
                continue;
            };
            let Some(place) = waiting.enter(&stream) else { continue };
            let (waiting, answering, answer) = (&waiting, &answering, &answer);
            let one = move || {
                // Who goes away in the middle is no fault.
                let _ = one(stream, place, waiting, answering, answer);
                waiting.leave(place);
            };
            if std::thread::Builder::new().stack_size(256 << 10).spawn_scoped(scope, one).is_err() {
                waiting.leave(place);
            }
        }
    })
}

fn one<'a>(
    mut stream: TcpStream,
    place: usize,
    waiting: &Waiting,
    answering: &AtomicUsize,
    answer: &impl Fn(&Asked<'_>) -> Answer<'a>,
) -> io::Result<()> {
    let header = header(&mut stream)?;
    let mut fields = [httparse::EMPTY_HEADER; FIELDS];
    let asked = match asked(&header, &mut fields) {
        Ok(asked) => asked,
        Err(status) => return Answer::empty(status).write(&mut stream),
    };
    waiting.leave(place);
    let many = answering.fetch_add(1, Ordering::Relaxed) >= ANSWERING;
    let answer = if many { Answer::empty("503 Service Unavailable") } else { answer(&asked) };
    let written = answer.write(&mut stream);
    answering.fetch_sub(1, Ordering::Relaxed);
    written
}

/// What a header asks for, or the status that it is refused with.
pub(super) fn asked<'a>(
    header: &'a [u8],
    fields: &'a mut [httparse::Header<'a>],
) -> Result<Asked<'a>, &'static str> {
    let mut request = httparse::Request::new(fields);
    let whole = request.parse(header).is_ok_and(|status| status.is_complete());
    let (Some(method), Some(path), true) = (request.method, request.path, whole) else {
        return Err("400 Bad Request");
    };
    let fields = request.headers;
    let field = |name: &str| {
        let found = fields.iter().find(|field| field.name.eq_ignore_ascii_case(name))?;
        std::str::from_utf8(found.value).ok()
    };
    if method != "GET" {
        return Err("405 Method Not Allowed");
    }
    if field("Transfer-Encoding").is_some() || field("Content-Length").is_some_and(|length| length != "0") {
        return Err("413 Content Too Large");
    }
    Ok(Asked { path, host: field("Host"), range: field("Range") })
}

/// First and last byte of `bytes=FIRST-LAST`, within a file of so many.
pub(super) fn range(text: &str, bytes: u64) -> Option<(u64, u64)> {
    let (from, to) = text.strip_prefix("bytes=")?.split_once('-')?;
    let (from, to) = (from.parse().ok()?, to.parse::<u64>().ok()?.min(bytes.checked_sub(1)?));
    (from <= to).then_some((from, to))
}

/// The bytes up to a header's end, and what came with them.
fn header(stream: &mut TcpStream) -> io::Result<Vec<u8>> {
    let until = Instant::now() + PATIENCE;
    let mut bytes = Vec::new();
    let mut piece = [0; 1024];
    while !bytes.windows(4).any(|end| end == b"\r\n\r\n") {
        if bytes.len() > HEADER {
            let _ = Answer::empty("431 Request Header Fields Too Large").write(stream);
            return Err(io::ErrorKind::InvalidData.into());
        }
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        stream.set_read_timeout(Some(left))?;
        match stream.read(&mut piece)? {
            0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            read => bytes.extend_from_slice(&piece[..read]),
        }
    }
    Ok(bytes)
}

/// Connections that have not asked yet, the oldest first.
#[derive(Default)]
struct Waiting {
    next: AtomicUsize,
    streams: Mutex<VecDeque<(usize, TcpStream)>>,
}

impl Waiting {
    /// A new one's place; none where it has gone already.
    fn enter(&self, stream: &TcpStream) -> Option<usize> {
        while self.all().len() >= WAITING {
            self.drop_oldest();
        }
        let own = loop {
            match stream.try_clone() {
                Ok(own) => break own,
                // Out of files: the oldest gives its own back.
                Err(_) => self.drop_oldest().then_some(())?,
            }
        };
        let place = self.next.fetch_add(1, Ordering::Relaxed);
        self.all().push_back((place, own));
        Some(place)
    }

    fn leave(&self, place: usize) {
        self.all().retain(|(other, _)| *other != place);
    }

    /// Whether there was one.
    fn drop_oldest(&self) -> bool {
        let oldest = self.all().pop_front();
        // Its thread reads no more, and ends.
        oldest.map(|(_, stream)| stream.shutdown(Shutdown::Both)).is_some()
    }

    fn all(&self) -> std::sync::MutexGuard<'_, VecDeque<(usize, TcpStream)>> {
        self.streams.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// An address at which a long text is served to whoever asks for `/long`, and 404 to others.
    fn served() -> std::net::SocketAddr {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        std::thread::spawn(move || {
            serve(&listener, |asked| match asked.path {
                "/long" => Answer::new("200 OK", &[], io::repeat(b'x'), 1 << 24),
                "/" => Answer::new("200 OK", &[("Made", "here")], &b"page"[..], 4),
                _ => Answer::empty("404 Not Found"),
            })
        });
        address
    }

    fn ask(address: std::net::SocketAddr, request: &[u8]) -> String {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(4))).unwrap();
        stream.write_all(request).unwrap();
        let mut said = Vec::new();
        // One that is refused in the middle of its body may be cut off.
        let _ = stream.read_to_end(&mut said);
        String::from_utf8(said).unwrap()
    }

    const PAGE: &[u8] = b"GET / HTTP/1.1\r\nHost: here\r\n\r\n";

    #[track_caller]
    fn is_heard(address: std::net::SocketAddr) {
        let said = ask(address, PAGE);
        assert!(said.starts_with("HTTP/1.1 200 OK\r\nMade: here\r\nContent-Length: 4\r\n"), "{said}");
        assert!(said.ends_with("\r\n\r\npage"), "{said}");
    }

    #[test]
    fn who_asks_is_heard_whatever_others_do() {
        let address = served();
        is_heard(address);
        // 300 that say nothing; those whom the server let go were closed.
        let silent: Vec<TcpStream> = (0..300).map(|_| TcpStream::connect(address).unwrap()).collect();
        is_heard(address);
        // Half a header, a body that never comes, one too long for any number, none at all.
        let mut half = TcpStream::connect(address).unwrap();
        half.write_all(b"GET / HTTP/1.1\r\nHo").unwrap();
        for (length, status) in
            [("18446744073709551615", "413"), ("100000000", "413"), ("-1", "413"), ("x", "413")]
        {
            let request = format!("GET / HTTP/1.1\r\nContent-Length: {length}\r\n\r\nabc");
            assert!(ask(address, request.as_bytes()).starts_with(&format!("HTTP/1.1 {status} ")), "{length}");
        }
        let chunked = b"GET / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nfffffffffffffffff\r\n";
        assert!(ask(address, chunked).starts_with("HTTP/1.1 413 "));
        assert!(ask(address, b"POST / HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 405 "));
        for nonsense in [&b"\0\xff\r\n\r\n"[..], b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", &[b'\n'; 9000]] {
            let said = ask(address, nonsense);
            assert!(said.starts_with("HTTP/1.1 4") || said.is_empty(), "{said}");
        }
        // Many that ask for much and take nothing.
        let mut deaf = Vec::new();
        for _ in 0..ANSWERING - 1 {
            let mut stream = TcpStream::connect(address).unwrap();
            stream.write_all(b"GET /long HTTP/1.1\r\n\r\n").unwrap();
            deaf.push(stream);
        }
        is_heard(address);
        drop((silent, half, deaf));
    }

    #[test]
    fn who_waits_longest_goes_first() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let waiting = Waiting::default();
        assert!(!waiting.drop_oldest());
        let streams: Vec<TcpStream> =
            (0..WAITING + 2).map(|_| TcpStream::connect(listener.local_addr().unwrap()).unwrap()).collect();
        let places: Vec<_> = streams.iter().map(|stream| waiting.enter(stream).unwrap()).collect();
        let left: Vec<_> = waiting.all().iter().map(|(place, _)| *place).collect();
        assert_eq!(left, places[2..]);
    }

    #[test]
    fn a_range_is_held_to_the_file_and_nonsense_is_none() {
        assert_eq!(range("bytes=0-99", 1000), Some((0, 99)));
        assert_eq!(range("bytes=990-2000", 1000), Some((990, 999)));
        for text in ["bytes=1000-1001", "bytes=5-4", "bytes=-5", "bytes=5-", "0-5", "bytes=0-1,3-4", ""] {
            assert_eq!(range(text, 1000), None, "{text}");
        }
        assert_eq!(range("bytes=0-0", 0), None);
    }

    #[test]
    fn a_long_header_is_refused_and_a_long_answer_is_whole() {
        let address = served();
        let long = [b"GET / HTTP/1.1\r\nA: ".as_slice(), &vec![b'a'; 1 << 20], b"\r\n\r\n"].concat();
        let said = ask(address, &long);
        assert!(said.is_empty() || said.starts_with("HTTP/1.1 431 "), "{said}");
        let said = ask(address, b"GET /long HTTP/1.1\r\n\r\n");
        assert!(said.len() > 1 << 24 && said.ends_with("xxx"));
        is_heard(address);
    }
}
