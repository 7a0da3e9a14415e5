//! `dpn page`: the page in the browser with a log already loaded, served to this machine alone.
//!
//! Two things are served, the page and the log, below a path that nobody can guess, and only to who asks for 127.0.0.1 by name. A log that the page
//! cannot read by itself (a folder, a database, a pipe, one with flags) is read here and served as its samples, with all their digits.

use super::http::{Answer, Asked, range, serve};
use super::log;
use crate::args::PageArgs;
use crate::ui::{outln, refuse};
use anyhow::{Context, Result};
use dpn_core::Samples as _;
use dpn_io::asl::write_imu_rows;
use dpn_io::scratch_file;
use dpn_logs::{Kind, LogOptions};
use std::collections::hash_map::RandomState;
use std::fs::File;
use std::hash::{BuildHasher, Hasher};
use std::io::{BufWriter, Read, Seek, SeekFrom, Write};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

const NOT_FOUND: &str = "404 Not Found";
const NO_STORE: (&str, &str) = ("Cache-Control", "no-store");

pub(crate) fn run(args: &PageArgs) -> Result<()> {
    let log = Served::of(args)?;
    let page = page(args.web.as_deref())?;
    let listener = TcpListener::bind("127.0.0.1:0").context("nothing can be served on 127.0.0.1")?;
    let address = listener.local_addr().context("an address of this machine")?.to_string();
    let token = format!("/{}/", token());
    let query = format!("log=log&size={}&name={}", log.bytes, escaped(&log.name));
    outln!("http://{address}{token}#{query}")?;
    serve(&listener, |asked| match asked.path.strip_prefix(&token) {
        _ if asked.host != Some(&address) => Answer::empty(NOT_FOUND),
        Some("") => {
            let fields = [("Content-Type", "text/html; charset=utf-8"), NO_STORE];
            Answer::new("200 OK", &fields, page.as_slice(), page.len() as u64)
        }
        Some("log") => log.answer(asked),
        _ => Answer::empty(NOT_FOUND),
    })
}

/// A log as bytes.
struct Served {
    name: String,
    file: Mutex<File>,
    bytes: u64,
}

impl Served {
    fn of(args: &PageArgs) -> Result<Self> {
        let path = &args.log.path;
        let mut name =
            path.file_name().map_or_else(|| "log".into(), |name| name.to_string_lossy().into_owned());
        let plain = path.is_file()
            && log::options_of(&args.log) == LogOptions::default()
            && Kind::of(path)? != Kind::Sqlite;
        let mut file = if plain {
            File::open(path).with_context(|| path.display().to_string())?
        } else {
            let recording = log::read(&args.log)?.recording;
            let scratch = scratch_file().context("a temporary file")?;
            let mut out = BufWriter::new(scratch.as_file());
            write_imu_rows(&mut out, &recording).and_then(|()| out.flush()).context("a temporary file")?;
            outln!("read here, and served as its {} samples", recording.len())?;
            // What a name ends in says what the file is.
            name.push_str(".csv");
            scratch.reopen().context("a temporary file")?
        };
        let bytes = file.seek(SeekFrom::End(0)).with_context(|| path.display().to_string())?;
        Ok(Self { name, file: Mutex::new(file), bytes })
    }

    /// The part that was asked for.
    fn answer(&self, asked: &Asked<'_>) -> Answer<'_> {
        let Some((from, to)) = asked.range.and_then(|asked| range(asked, self.bytes)) else {
            return Answer::empty("416 Range Not Satisfiable");
        };
        let place = format!("bytes {from}-{to}/{}", self.bytes);
        let fields = [("Content-Type", "application/octet-stream"), ("Content-Range", &place), NO_STORE];
        Answer::new("206 Partial Content", &fields, Part { file: &self.file, at: from }, to - from + 1)
    }
}

/// A file from one place on; others read it elsewhere meanwhile.
struct Part<'a> {
    file: &'a Mutex<File>,
    at: u64,
}

impl Read for Part<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(self.at))?;
        let read = file.read(bytes)?;
        self.at += read as u64;
        Ok(read)
    }
}

/// 128 bits that nobody can guess: the standard library's keys, which are the system's.
fn token() -> String {
    (0..2).map(|_| format!("{:016x}", RandomState::new().build_hasher().finish())).collect()
}

/// For an address: all but letters, digits and `.-_` by their bytes.
fn escaped(text: &str) -> String {
    let plain = |b: u8| b.is_ascii_alphanumeric() || b".-_".contains(&b);
    text.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}

/// The page that the program carries, where it was built with one.
#[cfg(feature = "page")]
const CARRIED: Option<&[u8]> = Some(include_bytes!(concat!(env!("OUT_DIR"), "/page.html")));
#[cfg(not(feature = "page"))]
const CARRIED: Option<&[u8]> = None;

/// The page, from the first place that has it: one that was named, else the program's own.
fn page(web: Option<&Path>) -> Result<Vec<u8>> {
    let named = web.map(Path::to_path_buf).or_else(|| std::env::var_os("DPN_WEB").map(PathBuf::from));
    let places = match (named, CARRIED) {
        (Some(dir), _) => vec![dir],
        (None, Some(page)) => return Ok(page.to_vec()),
        (None, None) => {
            let beside = std::env::current_exe().ok().and_then(|exe| Some(exe.parent()?.join("web")));
            beside.into_iter().chain([PathBuf::from("target/web/page")]).collect()
        }
    };
    for place in &places {
        if let Ok(page) = std::fs::read(place.join("index.html")) {
            return Ok(page);
        }
    }
    let looked: Vec<String> =
        places.iter().map(|place| place.join("index.html").display().to_string()).collect();
    refuse(
        format!("no page: looked for {}", looked.join(", ")),
        "a release carries it; `cargo xtask web` makes it, in target/web/page: name its folder by --web or DPN_WEB, or lay it beside the program as `web`",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_plain_characters_and_a_token_that_nobody_can_guess() {
        assert_eq!(escaped("a b/ä.bag"), "a%20b%2F%C3%A4.bag");
        assert!(token().len() == 32 && token() != token());
    }
}
