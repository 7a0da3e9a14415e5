//! Topics over DDS.

use crate::raw::{AsBytes, Came, Sent};
use crate::{Domain, Ros2Error};
use bytes::Bytes;
use rustdds::no_key::{DataWriter, SimpleDataReader};
use rustdds::policy::{Durability, History, Reliability};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, DomainParticipantStatusEvent,
    DomainParticipantStatusListener, GUID, QosPolicies, QosPolicyBuilder, StatusEvented, Topic, TopicKind,
};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::task::{Wake, Waker};
use std::thread::Thread;
use std::time::{Duration, Instant};

/// Messages that wait for whoever takes them; beyond it they wait in DDS, as many of a topic as its [`Quality`] keeps.
const QUEUE: usize = 64;
/// How long the reading thread sleeps at most.
const NAP: Duration = Duration::from_millis(100);
/// How long it is waited for those who listen.
const SETTLING: Duration = Duration::from_millis(300);
/// Messages that are kept for a reader that asks for them again.
const SENT: i32 = 100;

/// A topic that is listened to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct TopicId(usize);

/// How a topic is listened to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quality {
    /// Lost messages are asked for again; publishers that are best effort do not fit then.
    pub reliable: bool,
    /// What was sent before is asked for, as `/tf_static` has it; publishers that keep nothing do not fit then.
    pub latched: bool,
    /// So many messages wait; older ones are dropped, and counted.
    pub depth: u16,
}

/// A message, with the four bytes of its representation in front.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// Where.
    pub topic: TopicId,
    /// What.
    pub data: Vec<u8>,
    /// How many of its publisher's messages before it never came.
    pub lost: u64,
    /// When it came.
    pub came: Instant,
}

/// What is known of a topic that is listened to.
#[derive(Debug)]
struct Listened {
    name: String,
    kind: &'static str,
    reader: GUID,
    publishers: BTreeSet<GUID>,
}

/// A participant with its topics. Nothing is heard before [`listen`](Self::listen).
pub struct Node {
    participant: DomainParticipant,
    publisher: rustdds::Publisher,
    subscriber: rustdds::Subscriber,
    status: DomainParticipantStatusListener,
    readers: Vec<SimpleDataReader<Came, AsBytes>>,
    listened: Vec<Listened>,
    /// What was said of whom: once is enough.
    said: BTreeSet<(GUID, GUID)>,
    words: VecDeque<String>,
    dropped: Arc<AtomicU64>,
}

impl std::fmt::Debug for Node {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Node").field("listened", &self.listened).finish_non_exhaustive()
    }
}

/// Sends messages on one topic.
pub struct Publisher {
    writer: DataWriter<Sent, AsBytes>,
    dropped: Arc<AtomicU64>,
}

impl std::fmt::Debug for Publisher {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Publisher")
    }
}

impl Publisher {
    /// Sends a message of [`outgoing`](crate::outgoing). One that nobody listens to, or that a slow listener has no room for, is dropped, the
    /// latter [counted](Node::dropped).
    pub fn send(&self, fields: Vec<u8>) {
        // The only errors are a full history, and a participant that has gone.
        if self.writer.write(Sent(Bytes::from(fields)), None).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Waits a moment for those who listen reliably to have all that was sent: before an end.
    pub fn settle(&self) {
        // Whoever has not heard by then has gone.
        let _unheard = self.writer.wait_for_acknowledgments(SETTLING);
    }
}

impl Node {
    /// Takes part in `domain`.
    ///
    /// # Errors
    /// No socket.
    pub fn new(domain: Domain) -> Result<Self, Ros2Error> {
        let mut builder = DomainParticipantBuilder::new(domain.id);
        if domain.local {
            builder = builder.with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]);
        }
        let of = |problem: &dyn std::fmt::Display| dds(&format!("domain {}", domain.id), problem);
        let participant = builder.build().map_err(|error| of(&error))?;
        let qos = sending();
        let publisher = participant.create_publisher(&qos).map_err(|error| of(&error))?;
        let subscriber = participant.create_subscriber(&qos).map_err(|error| of(&error))?;
        let status = participant.status_listener();
        Ok(Self {
            participant,
            publisher,
            subscriber,
            status,
            readers: Vec::new(),
            listened: Vec::new(),
            said: BTreeSet::new(),
            words: VecDeque::new(),
            dropped: Arc::default(),
        })
    }

    /// Listens to the topic that ROS calls `name`, with messages of the type that ROS calls `kind`.
    ///
    /// # Errors
    /// A topic that DDS refuses.
    pub fn subscribe(
        &mut self,
        name: &str,
        kind: &'static str,
        quality: Quality,
    ) -> Result<TopicId, Ros2Error> {
        let qos = listening(quality);
        let topic = self.topic(name, kind, &qos)?;
        let reader = self.subscriber.create_simple_datareader_no_key(&topic, Some(qos));
        let reader = reader.map_err(|error| dds(name, &error))?;
        let guid = reader.guid();
        self.readers.push(reader);
        self.listened.push(Listened {
            name: name.to_owned(),
            kind,
            reader: guid,
            publishers: BTreeSet::new(),
        });
        Ok(TopicId(self.listened.len() - 1))
    }

    /// Announces the topic that ROS calls `name`: reliable, so that listeners of both kinds fit.
    ///
    /// # Errors
    /// A topic that DDS refuses.
    pub fn publish(&self, name: &str, kind: &str) -> Result<Publisher, Ros2Error> {
        let qos = sending();
        let topic = self.topic(name, kind, &qos)?;
        let writer = self.publisher.create_datawriter_no_key(&topic, Some(qos));
        let writer = writer.map_err(|error| dds(name, &error))?;
        Ok(Publisher { writer, dropped: Arc::clone(&self.dropped) })
    }

    /// How many messages could not be sent, of all topics.
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    fn topic(&self, name: &str, kind: &str, qos: &QosPolicies) -> Result<Topic, Ros2Error> {
        self.participant
            .create_topic(format!("rt{name}"), dds_type(kind), qos, TopicKind::NoKey)
            .map_err(|error| dds(name, &error))
    }

    /// Hears all topics from here on, on a thread of its own that ends with the receiver.
    pub fn listen(&mut self) -> Receiver<Message> {
        let (sender, messages) = sync_channel(QUEUE);
        let readers = std::mem::take(&mut self.readers);
        std::thread::spawn(move || hear(&readers, &sender));
        messages
    }

    /// A topic as ROS calls it.
    pub fn name(&self, topic: TopicId) -> &str {
        &self.listened[topic.0].name
    }

    /// Its type as ROS calls it.
    pub fn kind(&self, topic: TopicId) -> &'static str {
        self.listened[topic.0].kind
    }

    /// How many publishers it has that fit.
    pub fn publishers(&self, topic: TopicId) -> usize {
        self.listened[topic.0].publishers.len()
    }

    /// What somebody should know of publishers that do not fit, each once.
    pub fn take_words(&mut self) -> Option<String> {
        while let Some(event) = self.status.try_recv_status() {
            self.take(event);
        }
        self.words.pop_front()
    }

    fn take(&mut self, event: DomainParticipantStatusEvent) {
        use DomainParticipantStatusEvent as Event;
        match event {
            Event::RemoteWriterMatched { local_reader, remote_writer } => {
                if let Some(listened) =
                    self.listened.iter_mut().find(|listened| listened.reader == local_reader)
                {
                    listened.publishers.insert(remote_writer);
                }
            }
            Event::WriterLost { guid, .. } => {
                for listened in &mut self.listened {
                    listened.publishers.remove(&guid);
                }
            }
            Event::RemoteWriterQosIncompatible {
                local_reader,
                remote_writer,
                requested_qos,
                offered_qos,
            } => {
                let Some(listened) = self.listened.iter().find(|listened| listened.reader == local_reader)
                else {
                    return;
                };
                let unfit = unfit(&requested_qos, &offered_qos);
                let words = format!("a publisher of {} does not fit: {unfit}", listened.name);
                if self.said.insert((local_reader, remote_writer)) {
                    self.words.push_back(words);
                }
            }
            Event::WriterDetected { writer } => {
                for listened in &self.listened {
                    let wanted = dds_type(listened.kind);
                    let is_other =
                        writer.topic_name == format!("rt{}", listened.name) && writer.type_name != wanted;
                    if is_other && self.said.insert((listened.reader, writer.guid)) {
                        self.words.push_back(format!(
                            "a publisher of {} sends {}, not {}",
                            listened.name,
                            ros_type(&writer.type_name),
                            listened.kind
                        ));
                    }
                }
            }
            _ => {}
        }
    }
}

/// What a publisher offers less of than is asked for.
fn unfit(requested: &QosPolicies, offered: &QosPolicies) -> String {
    if requested.is_reliable() && !offered.is_reliable() {
        return "it is best effort, and reliable is asked for".to_owned();
    }
    match (requested.durability(), offered.durability()) {
        (Some(asked), has) if has.is_none_or(|has| has < asked) => {
            "it is volatile, and what was sent before is asked for (transient local)".to_owned()
        }
        _ => format!("it offers {offered:?}, asked for is {requested:?}"),
    }
}

fn dds(what: &str, problem: &dyn std::fmt::Display) -> Ros2Error {
    Ros2Error::Dds { what: what.to_owned(), problem: problem.to_string() }
}

fn listening(quality: Quality) -> QosPolicies {
    let reliability = if quality.reliable {
        Reliability::Reliable { max_blocking_time: rustdds::Duration::ZERO }
    } else {
        Reliability::BestEffort
    };
    let durability = if quality.latched { Durability::TransientLocal } else { Durability::Volatile };
    let depth = i32::from(quality.depth);
    QosPolicyBuilder::new()
        .reliability(reliability)
        .durability(durability)
        .history(History::KeepLast { depth })
        .build()
}

fn sending() -> QosPolicies {
    QosPolicyBuilder::new()
        .reliability(Reliability::Reliable { max_blocking_time: rustdds::Duration::ZERO })
        .durability(Durability::Volatile)
        .history(History::KeepLast { depth: SENT })
        .build()
}

/// `sensor_msgs/msg/Imu` as DDS has it.
fn dds_type(kind: &str) -> String {
    let mut parts: Vec<&str> = kind.split('/').collect();
    let name = parts.pop().unwrap_or_default();
    format!("{}::dds_::{name}_", parts.join("::"))
}

/// And back, where it is one.
fn ros_type(kind: &str) -> String {
    kind.strip_suffix('_').map_or(kind.to_owned(), |kind| kind.replace("::dds_::", "/").replace("::", "/"))
}

/// Wakes a thread that sleeps.
struct Unpark(Thread);

impl Wake for Unpark {
    fn wake(self: Arc<Self>) {
        self.0.unpark();
    }
}

/// Takes what comes, a message of each topic in turn, until nobody receives any more.
fn hear(readers: &[SimpleDataReader<Came, AsBytes>], sender: &SyncSender<Message>) {
    let waker = Waker::from(Arc::new(Unpark(std::thread::current())));
    let mut last: BTreeMap<GUID, i64> = BTreeMap::new();
    loop {
        let mut idle = true;
        for (index, reader) in readers.iter().enumerate() {
            reader.drain_read_notifications();
            // Before the look, so that what comes behind it wakes.
            reader.set_waker(Some(waker.clone()));
            // An error is a message of a foreign representation; the next one is another.
            let Ok(taken) = reader.try_take_one() else {
                idle = false;
                continue;
            };
            let Some(change) = taken else { continue };
            idle = false;
            let number = i64::from(change.sequence_number);
            let before = last.insert(change.writer_guid, number);
            let lost = before.map_or(0, |before| u64::try_from(number - before - 1).unwrap_or(0));
            let message =
                Message { topic: TopicId(index), data: change.sample.0, lost, came: Instant::now() };
            if sender.send(message).is_err() {
                return;
            }
        }
        if idle {
            std::thread::park_timeout(NAP);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_have_two_names() {
        assert_eq!(dds_type("sensor_msgs/msg/Imu"), "sensor_msgs::msg::dds_::Imu_");
        assert_eq!(ros_type("sensor_msgs::msg::dds_::Imu_"), "sensor_msgs/msg/Imu");
        assert_eq!(ros_type("ShapeType"), "ShapeType");
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let asked = |reliable, latched| listening(Quality { reliable, latched, depth: 1 });
        assert_eq!(
            unfit(&asked(true, false), &asked(false, false)),
            "it is best effort, and reliable is asked for"
        );
        assert!(unfit(&asked(false, true), &asked(false, false)).contains("transient local"));
    }
}
