//! `--view`: Foxglove's WebSocket beside a live run, in its protocol (`foxglove.sdk.v1`, `foxglove.websocket.v1`): topics are advertised, a viewer
//! subscribes, messages are binary.
//!
//! One thread serves all viewers and waits for none. The run hands it what a frame gave and goes on; where [`QUEUE`] frames wait, the next is dropped. A viewer
//! has [`BEHIND`] bytes that it has not taken; what does not fit is dropped. Both are counted. Without viewers nothing but the way is kept.
//! Nothing that a viewer sends changes a run. Whoever reaches the address may look, pages of a browser on this machine too.

use super::super::VERSION;
use super::messages::{Onlooker, Topic, image, is_due, of_update, path, sigma, tracks};
use crate::ui::{Fault, errln};
use anyhow::Result;
use dpn_core::{GrayImage, ImuNoise, Stamp, TrackFrame};
use dpn_vio::estimator::{FrontEndObserver, Update};
use dpn_vio::frontend::Fed;
use nalgebra::Isometry3;
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::io;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tungstenite::handshake::MidHandshake;
use tungstenite::handshake::server::{ErrorResponse, Request, Response, ServerHandshake};
use tungstenite::http::HeaderValue;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, HandshakeError, Message, WebSocket, accept_hdr_with_config};

/// Subprotocols that are spoken: they do not differ in what is used here.
const PROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];
/// Topics that a live run has: there is no truth.
const TOPICS: [Topic; 7] = [
    Topic::Tf,
    Topic::Estimate,
    Topic::EstimatePath,
    Topic::Image,
    Topic::Tracks,
    Topic::Sigma,
    Topic::State,
];
/// Images are shown so often \[s\], the way \[s\], of so many poses at most.
const IMAGE_EVERY_S: f64 = 0.1;
const PATH_EVERY_S: f64 = 1.0;
const PATH: usize = 2000;
/// Frames that wait to be shown.
const QUEUE: usize = 16;
/// Bytes that wait for a viewer.
const BEHIND: usize = 8 << 20;
/// Viewers at a time, subscriptions of one, and bytes and number of its messages at a time.
const VIEWERS: usize = 16;
const SUBSCRIPTIONS: usize = 64;
const ASKED: usize = 64 << 10;
const ASKED_AT_ONCE: usize = 32;
/// How long a viewer may take to say what it is.
const PATIENCE: Duration = Duration::from_secs(5);
/// How often viewers are looked after.
const LOOK: Duration = Duration::from_millis(20);

/// A run's end of it.
pub(super) struct View {
    frames: SyncSender<Frame>,
    server: JoinHandle<()>,
    counts: Arc<Counts>,
    /// Images of which no frame has come back yet.
    images: VecDeque<(Stamp, GrayImage, TrackFrame)>,
    image: Option<Stamp>,
}

#[derive(Default)]
struct Counts {
    viewers: AtomicUsize,
    dropped: AtomicU64,
}

/// What is shown of a frame.
struct Frame {
    t: Stamp,
    update: Update,
    noise: Option<ImuNoise>,
    latency_s: Option<f64>,
    image: Option<(GrayImage, TrackFrame)>,
}

impl View {
    /// Serves on `address`.
    ///
    /// # Errors
    /// An address that is taken, or none of this machine.
    pub(super) fn open(address: SocketAddr) -> Result<Self> {
        let taken = |error| {
            Fault::new(format!("nothing can be served on {address}: {error}"))
                .hint("another address: --view=127.0.0.1:PORT")
        };
        let listener = TcpListener::bind(address).map_err(taken)?;
        let address = listener.local_addr().map_err(taken)?;
        let view = Self::on(listener).map_err(taken)?;
        errln!("view: ws://{address}, for Foxglove (Open connection)");
        Ok(view)
    }

    fn on(listener: TcpListener) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        let (sender, frames) = sync_channel(QUEUE);
        let counts = Arc::<Counts>::default();
        let server = Server {
            listener,
            counts: Arc::clone(&counts),
            viewers: Vec::new(),
            path: Path { every: 1, ..Path::default() },
        };
        let server = std::thread::spawn(move || server.serve(&frames));
        Ok(Self { frames: sender, server, counts, images: VecDeque::new(), image: None })
    }
}

impl Onlooker for View {
    fn show(&mut self, (t, update): (Stamp, &Update), noise: Option<ImuNoise>, image: Option<(Stamp, f64)>) {
        let index = self.images.iter().position(|(at, _, _)| Some(*at) == image.map(|(at, _)| at));
        let shown = index.and_then(|index| self.images.drain(..=index).next_back());
        let frame = Frame {
            t,
            update: update.clone(),
            noise,
            latency_s: image.map(|(_, latency_s)| latency_s),
            image: shown.map(|(_, image, frame)| (image, frame)),
        };
        if self.frames.try_send(frame).is_err() {
            self.counts.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn finish(self: Box<Self>) -> u64 {
        drop(self.frames);
        // It waits for nobody.
        let _ = self.server.join();
        self.counts.dropped.load(Ordering::Relaxed)
    }
}

impl FrontEndObserver for View {
    fn end(&mut self, image: &GrayImage, fed: &Fed) {
        let Some(frame) = &fed.frame else { return };
        let watched = self.counts.viewers.load(Ordering::Relaxed) > 0;
        if watched && is_due(&mut self.image, fed.report.t, IMAGE_EVERY_S) {
            self.images.truncate(QUEUE);
            self.images.push_back((fed.report.t, image.clone(), frame.clone()));
        }
    }
}

struct Server {
    listener: TcpListener,
    counts: Arc<Counts>,
    viewers: Vec<Viewer>,
    path: Path,
}

/// The way so far: of every so many poses one, so that a run of hours is no larger.
#[derive(Default)]
struct Path {
    poses: Vec<Isometry3<f64>>,
    every: usize,
    seen: usize,
    shown: Option<Stamp>,
}

impl Server {
    /// Shows frames until the run ends.
    fn serve(mut self, frames: &Receiver<Frame>) {
        loop {
            match frames.recv_timeout(LOOK) {
                Ok(frame) => self.show(&frame),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            while let Ok((stream, _)) = self.listener.accept() {
                // Whoever says nothing goes for who comes to look.
                let silent = || self.viewers.iter().position(Viewer::is_shaking);
                if let Some(oldest) = (self.viewers.len() >= VIEWERS).then(silent).flatten() {
                    self.viewers.remove(oldest);
                }
                let viewer = (self.viewers.len() < VIEWERS).then(|| Viewer::new(stream)).flatten();
                self.viewers.extend(viewer);
            }
            self.viewers.retain_mut(Viewer::look);
            self.counts.viewers.store(self.viewers.len(), Ordering::Relaxed);
        }
        for viewer in &mut self.viewers {
            if let State::Open(socket) = &mut viewer.state {
                // Who does not take it is gone in a moment anyway.
                let _ = socket.close(None).and_then(|()| socket.flush());
            }
        }
    }

    fn show(&mut self, frame: &Frame) {
        let t = frame.t;
        for (topic, value) in of_update(t, &frame.update, frame.latency_s) {
            self.send(topic, t, || value.to_string());
        }
        if let Some(state) = &frame.update.state {
            self.path.add(state.world_from_body);
            if is_due(&mut self.path.shown, t, PATH_EVERY_S) {
                let way = path(t, "world", self.path.poses.iter()).to_string();
                self.send(Topic::EstimatePath, t, || way);
            }
        }
        if let Some(noise) = &frame.noise {
            self.send(Topic::Sigma, t, || sigma(t, noise).to_string());
        }
        if let Some((shown, points)) = &frame.image {
            self.send(Topic::Image, t, || {
                image(t, shown).expect("what a camera of a few thousand pixels saw fits a PNG").to_string()
            });
            self.send(Topic::Tracks, t, || tracks(t, points).to_string());
        }
    }

    /// Sends a message to all who subscribed; it is made where there are any.
    fn send(&mut self, topic: Topic, t: Stamp, message: impl FnOnce() -> String) {
        let mut all: Vec<(&mut Viewer, u32)> = Vec::new();
        for viewer in &mut self.viewers {
            if let Some((id, _)) = viewer.subscriptions.iter().find(|(_, of)| *of == topic) {
                let id = *id;
                all.push((viewer, id));
            }
        }
        if all.is_empty() {
            return;
        }
        let message = message();
        for (viewer, id) in all {
            let header = [&[1][..], &id.to_le_bytes(), &t.ns().to_le_bytes()].concat();
            if !viewer.send(Message::binary([&header[..], message.as_bytes()].concat())) {
                self.counts.dropped.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
}

impl Path {
    fn add(&mut self, pose: Isometry3<f64>) {
        if self.seen.is_multiple_of(self.every) {
            self.poses.push(pose);
        }
        self.seen += 1;
        if self.poses.len() > PATH {
            let mut index = 0;
            self.poses.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.every *= 2;
        }
    }
}

/// Somebody who looks on, or is about to.
struct Viewer {
    state: State,
    since: Instant,
    subscriptions: Vec<(u32, Topic)>,
}

type Choice = fn(&Request, Response) -> Result<Response, ErrorResponse>;

enum State {
    Shaking(MidHandshake<ServerHandshake<TcpStream, Choice>>),
    Open(WebSocket<TcpStream>),
    Gone,
}

impl Viewer {
    fn new(stream: TcpStream) -> Option<Self> {
        stream.set_nonblocking(true).and_then(|()| stream.set_nodelay(true)).ok()?;
        let config = WebSocketConfig::default()
            .write_buffer_size(0)
            .max_write_buffer_size(BEHIND)
            .max_message_size(Some(ASKED))
            .max_frame_size(Some(ASKED));
        let mut viewer = Self { state: State::Gone, since: Instant::now(), subscriptions: Vec::new() };
        viewer.shaken(accept_hdr_with_config(stream, choose as Choice, Some(config)));
        Some(viewer)
    }

    fn shaken(
        &mut self,
        done: Result<WebSocket<TcpStream>, HandshakeError<ServerHandshake<TcpStream, Choice>>>,
    ) {
        self.state = match done {
            Ok(socket) => State::Open(socket),
            Err(HandshakeError::Interrupted(rest)) if self.since.elapsed() < PATIENCE => State::Shaking(rest),
            Err(_) => State::Gone,
        };
        if matches!(self.state, State::Open(_)) {
            let name = VERSION;
            self.send(Message::text(
                json!({ "op": "serverInfo", "name": name, "capabilities": [] }).to_string(),
            ));
            let channels: Vec<Value> = TOPICS
                .iter()
                .enumerate()
                .map(|(id, topic)| {
                    let (topic_name, schema) = topic.names();
                    json!({
                        "id": id, "topic": topic_name, "encoding": "json", "schemaName": schema, "schema": topic.schema(),
                        "schemaEncoding": "jsonschema",
                    })
                })
                .collect();
            self.send(Message::text(json!({ "op": "advertise", "channels": channels }).to_string()));
        }
    }

    /// Whether it has not said yet what it is.
    fn is_shaking(&self) -> bool {
        matches!(self.state, State::Shaking(_))
    }

    /// Takes what was asked and hands on what waits; whether it is still there.
    fn look(&mut self) -> bool {
        if let State::Shaking(_) = &self.state
            && let State::Shaking(rest) = std::mem::replace(&mut self.state, State::Gone)
        {
            self.shaken(rest.handshake());
            return !matches!(self.state, State::Gone);
        }
        for _ in 0..ASKED_AT_ONCE {
            let State::Open(socket) = &mut self.state else { return false };
            match socket.read() {
                Ok(Message::Text(text)) => self.asked(&text),
                Ok(_) => {}
                Err(error) if waits(&error) => break,
                Err(_) => return false,
            }
        }
        let State::Open(socket) = &mut self.state else { return false };
        socket.flush().map_or_else(|error| waits(&error), |()| true)
    }

    /// Subscriptions and their end; everything else is passed over.
    fn asked(&mut self, text: &str) {
        let Ok(asked) = serde_json::from_str::<Value>(text) else { return };
        let number = |value: &Value| value.as_u64().and_then(|number| u32::try_from(number).ok());
        let list = |key: &str| asked[key].as_array().into_iter().flatten();
        match asked["op"].as_str() {
            Some("subscribe") => {
                for one in list("subscriptions") {
                    let topic = number(&one["channelId"]).and_then(|id| TOPICS.get(id as usize));
                    if let (Some(id), Some(topic), true) =
                        (number(&one["id"]), topic, self.subscriptions.len() < SUBSCRIPTIONS)
                    {
                        self.subscriptions.push((id, *topic));
                    }
                }
            }
            Some("unsubscribe") => {
                let gone: Vec<u32> = list("subscriptionIds").filter_map(number).collect();
                self.subscriptions.retain(|(id, _)| !gone.contains(id));
            }
            _ => {}
        }
    }

    /// Whether the message will go out.
    fn send(&mut self, message: Message) -> bool {
        let State::Open(socket) = &mut self.state else { return false };
        match socket.write(message) {
            Ok(()) => true,
            // It waits with others.
            Err(error) if waits(&error) => true,
            Err(Error::WriteBufferFull(_)) => false,
            Err(_) => {
                self.state = State::Gone;
                false
            }
        }
    }
}

fn waits(error: &Error) -> bool {
    matches!(error, Error::Io(error) if error.kind() == io::ErrorKind::WouldBlock)
}

/// Agrees on the first subprotocol that both speak.
#[allow(clippy::result_large_err)]
fn choose(request: &Request, mut response: Response) -> Result<Response, ErrorResponse> {
    let fields = request.headers().get_all("sec-websocket-protocol").iter();
    let offered: Vec<&str> = fields
        .filter_map(|field| field.to_str().ok())
        .flat_map(|field| field.split(','))
        .map(str::trim)
        .collect();
    match PROTOCOLS.into_iter().find(|ours| offered.contains(ours)) {
        Some(ours) => {
            response.headers_mut().insert("sec-websocket-protocol", HeaderValue::from_static(ours));
            Ok(response)
        }
        None => {
            let mut refused =
                ErrorResponse::new(Some(format!("one of these subprotocols: {}", PROTOCOLS.join(", "))));
            *refused.status_mut() = tungstenite::http::StatusCode::BAD_REQUEST;
            Err(refused)
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use dpn_core::Track;
    use dpn_vio::NavState;
    use dpn_vio::estimator::Phase;
    use std::io::{Read, Write};
    use tungstenite::client::IntoClientRequest;
    use tungstenite::stream::MaybeTlsStream;

    type Client = WebSocket<MaybeTlsStream<TcpStream>>;

    fn connect(address: SocketAddr, protocol: &str) -> tungstenite::Result<Client> {
        let mut request = format!("ws://{address}").into_client_request()?;
        request.headers_mut().insert("sec-websocket-protocol", protocol.parse().unwrap());
        let (client, _) = tungstenite::connect(request)?;
        if let MaybeTlsStream::Plain(stream) = client.get_ref() {
            stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        }
        Ok(client)
    }

    fn said(client: &mut Client) -> Value {
        serde_json::from_str(client.read().unwrap().to_text().unwrap()).unwrap()
    }

    /// Subscribed to all topics by their ids.
    fn subscribed(address: SocketAddr) -> Client {
        let mut client = connect(address, "foxglove.websocket.v1, other").unwrap();
        assert_eq!(said(&mut client)["op"], "serverInfo");
        let channels = said(&mut client)["channels"].as_array().unwrap().clone();
        assert_eq!(channels.len(), TOPICS.len());
        let ids: Vec<Value> = channels
            .iter()
            .map(|c| json!({ "id": c["id"].as_u64().unwrap() + 100, "channelId": c["id"] }))
            .collect();
        let text = json!({ "op": "subscribe", "subscriptions": ids }).to_string();
        client.send(Message::text(text)).unwrap();
        client
    }

    fn show(view: &mut View, k: i64) {
        let t = Stamp::from_ns(50_000_000 * k + 1_000_000_000);
        let update = Update {
            t,
            phase: Phase::Tracking,
            state: Some(NavState::identity()),
            covariance: None,
            scale_std: Some(0.25),
            tracked: 7,
            landmarks: 5,
            outliers: 0,
            iterations: 2,
            whitened: None,
            levels: None,
            jump: None,
            seconds: 0.001,
        };
        // Noise, which no PNG makes small.
        let image = GrayImage::from_fn(752, 480, |x, y| ((x * 7919 + y * 104_729) ^ (x * y)) as u8).unwrap();
        let tracks = vec![Track { id: 1, px: [3.0, 4.0].into() }];
        view.images.push_back((t, image, TrackFrame::new(t, tracks)));
        let noise = ImuNoise::from_values([0.1; 3], [0.01; 3]).unwrap();
        view.show((t, &update), Some(noise), Some((t, 0.006)));
    }

    #[test]
    fn a_viewer_sees_every_topic_and_one_that_takes_nothing_makes_nobody_wait() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let mut view = View::on(listener).unwrap();
        // Nobody, as often as viewers are let in, nonsense, another protocol.
        let _silent: Vec<_> = (0..VIEWERS).map(|_| TcpStream::connect(address).unwrap()).collect();
        let mut nonsense = TcpStream::connect(address).unwrap();
        nonsense.write_all(b"GET / HTTP/1.1\r\n\r\n").unwrap();
        let _ = nonsense.read(&mut [0; 64]);
        let refused = connect(address, "other").unwrap_err().to_string();
        assert!(refused.contains("400"), "{refused}");

        let mut viewer = subscribed(address);
        for text in ["", "{", "[]", r#"{"op":"subscribe","subscriptions":[{"id":-1,"channelId":99},7]}"#] {
            viewer.send(Message::text(text)).unwrap();
        }
        let _deaf = subscribed(address);
        let seen = std::thread::spawn(move || {
            let mut seen = std::collections::BTreeMap::<u32, Value>::new();
            while let Ok(message) = viewer.read() {
                if let Message::Binary(bytes) = message {
                    let id = u32::from_le_bytes(bytes[1..5].try_into().unwrap());
                    assert!(
                        bytes[0] == 1
                            && u64::from_le_bytes(bytes[5..13].try_into().unwrap()) >= 1_000_000_000
                    );
                    seen.insert(id - 100, serde_json::from_slice(&bytes[13..]).unwrap());
                }
            }
            seen
        });
        // Until both are there.
        std::thread::sleep(Duration::from_millis(300));
        let mut longest = Duration::ZERO;
        for k in 0..120 {
            let begun = Instant::now();
            show(&mut view, k);
            longest = longest.max(begun.elapsed());
            std::thread::sleep(Duration::from_millis(10));
        }
        assert!(longest < Duration::from_millis(500), "{longest:?}");
        assert!(Box::new(view).finish() > 0, "the deaf one has 8 MB and no more");
        let seen = seen.join().unwrap();
        assert_eq!(seen.len(), TOPICS.len(), "{:?}", seen.keys());
        let of = |topic| &seen[&(TOPICS.iter().position(|other| *other == topic).unwrap() as u32)];
        assert_eq!(
            (&of(Topic::State)["scale_std"], &of(Topic::State)["latency_ms"]),
            (&json!(0.25), &json!(6.0))
        );
        assert_eq!(of(Topic::Estimate)["pose"]["orientation"]["w"], 1.0);
        assert!(of(Topic::EstimatePath)["poses"].as_array().unwrap().len() > 1);
        assert_eq!(of(Topic::Tracks)["points"][0]["points"][0]["x"], 3.0);
        assert!(of(Topic::Image)["data"].as_str().unwrap().starts_with("iVBORw0KGgo"), "a PNG in base64");
    }

    #[test]
    fn the_way_stays_short_and_keeps_its_first_pose() {
        let mut path = Path { every: 1, ..Path::default() };
        for k in 0..100_000 {
            path.add(Isometry3::translation(f64::from(k), 0.0, 0.0));
        }
        assert!(path.poses.len() <= PATH && path.poses.len() > PATH / 3, "{}", path.poses.len());
        let steps: Vec<f64> =
            path.poses.windows(2).map(|w| w[1].translation.x - w[0].translation.x).collect();
        assert!(path.poses[0].translation.x == 0.0 && steps.iter().all(|step| *step == path.every as f64));
    }
}
