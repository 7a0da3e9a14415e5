//! `dpn page` with few files to open (`ulimit -n`), among connections that say nothing and bodies without end.
#![cfg(unix)]

use crate::recording::sound;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Command, Stdio};
use std::time::Duration;

#[test]
fn who_has_the_token_is_heard_with_few_files_among_connections_that_say_nothing() {
    let tmp = tempfile::tempdir().unwrap();
    let log = sound(tmp.path()).join("still/mav0/imu0/data.csv");
    std::fs::write(tmp.path().join("index.html"), "the page").unwrap();
    for files in [24, 256] {
        let mut server = Command::new("sh")
            .args([
                "-c",
                &format!("ulimit -n {files}; exec \"$0\" \"$@\""),
                env!("CARGO_BIN_EXE_dpn"),
                "page",
            ])
            .arg(&log)
            .arg("--web")
            .arg(tmp.path())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let (address, path) = line.trim_start_matches("http://").split_once('/').unwrap();
        let path = path.split('#').next().unwrap();
        let connect = || {
            let stream = TcpStream::connect(address).unwrap();
            stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
            stream
        };
        // Those that were let go read an end.
        let silent: Vec<TcpStream> = (0..300).map(|_| connect()).collect();
        let mut body = connect();
        let head = format!("POST /{path} HTTP/1.1\r\nHost: {address}\r\nContent-Length: 1000000000\r\n\r\n");
        body.write_all(head.as_bytes()).unwrap();
        let piece = vec![b'x'; 1 << 20];
        assert!((0..1000).any(|_| body.write_all(&piece).is_err()), "a gigabyte is taken");
        let mut asked = connect();
        asked.write_all(format!("GET /{path} HTTP/1.1\r\nHost: {address}\r\n\r\n").as_bytes()).unwrap();
        let mut said = String::new();
        let read = asked.read_to_string(&mut said);
        server.kill().unwrap();
        server.wait().unwrap();
        assert!(read.is_ok() && said.ends_with("\r\n\r\nthe page"), "{files} files: {read:?} {said}");
        drop(silent);
    }
}
