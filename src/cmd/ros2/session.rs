//! What both nodes have: topics that are waited for, a clock, diagnostics once a second.

use crate::args::NodeArgs;
use crate::cmd::stop;
use crate::ui::errln;
use anyhow::Result;
use dpn_core::Stamp;
use dpn_ros2::incoming::{self, kind};
use dpn_ros2::outgoing::{self, Level, Status};
use dpn_ros2::{Domain, Message, Names, Node, Publisher, Quality, TopicId};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// How long a message is waited for before the node looks around.
const LOOK: Duration = Duration::from_millis(100);
/// Diagnostics and words about what is waited for, at most.
const SECOND: Duration = Duration::from_secs(1);
/// The same words are said again after so long.
const AGAIN: Duration = Duration::from_secs(10);
/// What has not been heard of for so long is waited for.
const SILENT: Duration = Duration::from_secs(2);

/// Stamps farther than this from the clock are another clock's [s].
const NEAR_S: f64 = 10.0;

/// A topic that something is waited for on.
#[derive(Debug)]
struct Input {
    topic: TopicId,
    what: &'static str,
    /// The beginning, or the last message.
    since: Instant,
    messages: u64,
    lost: u64,
    /// Whether one message is enough.
    once: bool,
}

/// A node that is on.
pub(super) struct Session {
    node: Node,
    names: Names,
    messages: Option<Receiver<Message>>,
    stop: Arc<AtomicBool>,
    inputs: Vec<Input>,
    diagnostics: Publisher,
    /// The topic of simulated time, and what it says.
    clock: Option<(TopicId, Option<Stamp>)>,
    looked: Instant,
    said: Option<(String, Instant)>,
}

/// What came, or that nothing did for a while.
pub(super) enum Next {
    Message(Message),
    Nothing,
    /// Somebody asked to end.
    Asked,
}

impl Session {
    /// Takes part in the domain of the environment.
    pub(super) fn new(names: Names, args: &NodeArgs) -> Result<Self> {
        // Signals first: the threads of DDS are not to take them.
        let stop = stop::on_any_end()?;
        let domain = Domain::of_environment()?;
        let mut node = Node::new(domain)?;
        let diagnostics = node.publish(&names.topic("/diagnostics")?, outgoing::kind::DIAGNOSTICS)?;
        let quality = Quality { reliable: false, latched: false, depth: 10 };
        let mut inputs = Vec::new();
        let clock = match args.use_sim_time {
            true => {
                let topic = node.subscribe(&names.topic("/clock")?, kind::CLOCK, quality)?;
                inputs.push(Input::new(topic, "simulated time", false));
                Some((topic, None))
            }
            false => None,
        };
        let range = if domain.local { ", on this machine alone" } else { "" };
        errln!("node {} in domain {}{range}", names.node(), domain.id);
        Ok(Self {
            node,
            names,
            messages: None,
            stop,
            inputs,
            diagnostics,
            clock,
            looked: Instant::now(),
            said: None,
        })
    }

    /// Listens to a topic, as the node's names have it; `once` where one message is enough.
    pub(super) fn listen(
        &mut self,
        name: &str,
        kind: &'static str,
        quality: Quality,
        (what, once): (&'static str, bool),
    ) -> Result<TopicId> {
        let topic = self.node.subscribe(&self.names.topic(name)?, kind, quality)?;
        errln!("{what}: {} ({kind})", self.node.name(topic));
        self.inputs.push(Input::new(topic, what, once));
        Ok(topic)
    }

    /// Sends on a topic, as the node's names have it.
    pub(super) fn send(&self, name: &str, kind: &str) -> Result<Publisher> {
        Ok(self.node.publish(&self.names.topic(name)?, kind)?)
    }

    /// A topic as ROS calls it.
    pub(super) fn name(&self, topic: TopicId) -> &str {
        self.node.name(topic)
    }

    /// Whether time is simulated: then this machine's clock tells nothing of silence.
    pub(super) fn is_simulated(&self) -> bool {
        self.clock.is_some()
    }

    /// The next message. Nothing is heard before the first call.
    pub(super) fn next(&mut self) -> Next {
        if self.stop.load(Ordering::Relaxed) {
            return Next::Asked;
        }
        let node = &mut self.node;
        let messages = self.messages.get_or_insert_with(|| node.listen());
        match messages.recv_timeout(LOOK) {
            Ok(message) => {
                self.heard(&message);
                Next::Message(message)
            }
            Err(RecvTimeoutError::Timeout) => Next::Nothing,
            Err(RecvTimeoutError::Disconnected) => Next::Asked,
        }
    }

    fn heard(&mut self, message: &Message) {
        if let Some((topic, now)) = &mut self.clock
            && *topic == message.topic
        {
            *now = incoming::clock(&message.data).ok().or(*now);
        }
        self.compare(message);
        if let Some(input) = self.inputs.iter_mut().find(|input| input.topic == message.topic) {
            input.since = message.came;
            input.messages += 1;
            input.lost += message.lost;
        }
    }

    /// Says where a sensor's first stamp is another clock's than the one that poses are looked up by.
    fn compare(&self, message: &Message) {
        let is_first = |input: &&Input| input.topic == message.topic && input.messages == 0 && !input.once;
        let is_clock = self.clock.is_some_and(|(topic, _)| topic == message.topic);
        let (Some(_), Some(now), false) = (self.inputs.iter().find(is_first), self.now(), is_clock) else {
            return;
        };
        let Ok(t) = incoming::stamp(&message.data) else { return };
        let ahead = t.seconds_since(now);
        if ahead.abs() > NEAR_S {
            let (way, name) =
                (if ahead > 0.0 { "ahead of" } else { "behind" }, self.node.name(message.topic));
            let clock = if self.is_simulated() {
                "/clock"
            } else {
                "this machine's clock (use_sim_time takes that of a bag that is played)"
            };
            errln!(
                "note: the stamps of {name} are {:.0} s {way} {clock}; poses and transforms have the sensors' stamps",
                ahead.abs()
            );
        }
    }

    /// Whether a second has gone by; what publishers do not fit and what is waited for is said.
    pub(super) fn is_due(&mut self) -> bool {
        if self.looked.elapsed() < SECOND {
            return false;
        }
        self.looked = Instant::now();
        while let Some(words) = self.node.take_words() {
            errln!("warning: {words}");
        }
        let waiting = self.waiting();
        let key = waiting.iter().map(|(what, _)| what.as_str()).collect::<Vec<_>>().join("; ");
        let is_new = self.said.as_ref().is_none_or(|(said, at)| *said != key || at.elapsed() >= AGAIN);
        if waiting.is_empty() {
            self.said = None;
        } else if is_new {
            let words: Vec<String> =
                waiting.into_iter().map(|(what, since)| format!("{what}, for {since:.0} s")).collect();
            errln!("waits for {}", words.join("; "));
            self.said = Some((key, Instant::now()));
        }
        true
    }

    /// What is waited for, and for how many seconds.
    fn waiting(&self) -> Vec<(String, f64)> {
        let waits = |input: &&Input| {
            let begun = input.messages == 0;
            let long = input.since.elapsed() >= if begun { SECOND } else { SILENT };
            long && (begun || !input.once)
        };
        let words = |input: &Input| {
            let from = match self.node.publishers(input.topic) {
                0 => "which nobody sends".to_owned(),
                1 => "whose publisher is silent".to_owned(),
                n => format!("whose {n} publishers are silent"),
            };
            let (name, kind) = (self.node.name(input.topic), self.node.kind(input.topic));
            (format!("{} on {name} ({kind}), {from}", input.what), input.since.elapsed().as_secs_f64())
        };
        self.inputs.iter().filter(waits).map(words).collect()
    }

    /// Sends diagnostics: `status` with what is waited for, and messages and losses of every topic.
    pub(super) fn diagnose(&self, mut status: Status) {
        let waiting = self.waiting();
        if !waiting.is_empty() {
            let silent =
                self.inputs.iter().any(|input| input.messages > 0 && input.since.elapsed() >= SILENT);
            status.level = status.level.max(if silent { Level::Stale } else { Level::Warn });
            let words: Vec<String> =
                waiting.into_iter().map(|(what, since)| format!("{what}, for {since:.0} s")).collect();
            status.message = format!("waits for {}", words.join("; "));
        }
        for input in &self.inputs {
            let name = self.node.name(input.topic);
            status.values.push((format!("{name}: messages"), input.messages.to_string()));
            status.values.push((format!("{name}: lost"), input.lost.to_string()));
        }
        status.values.push(("messages that could not be sent".to_owned(), self.node.dropped().to_string()));
        status.name = format!("{}: {}", self.names.node().trim_start_matches('/'), status.name);
        let now = self.now().unwrap_or(Stamp::from_ns(0));
        self.diagnostics.send(outgoing::diagnostics(now, &[status]));
    }

    /// How many messages of all topics never came.
    pub(super) fn lost(&self) -> u64 {
        self.inputs.iter().map(|input| input.lost).sum()
    }

    /// The time; none before simulated time is told.
    fn now(&self) -> Option<Stamp> {
        if let Some((_, now)) = self.clock {
            return now;
        }
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Some(Stamp::from_ns(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)))
    }
}

impl Input {
    fn new(topic: TopicId, what: &'static str, once: bool) -> Self {
        Self { topic, what, since: Instant::now(), messages: 0, lost: 0, once }
    }
}
