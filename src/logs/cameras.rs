//! The topics of a bag that carry images, and the choice of one.

use crate::LogError;
use crate::fields::{Encoding, Undecodable};
use crate::image_message::{ImageKind, ImageMessage, decode};
use crate::topics::{shortened, similar};
use dpn_core::{GrayImage, Stamp};
use dpn_io::{IoError, printable};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Where none of so many first images can be read, none is waited for.
const FIRST: u64 = 10;

/// One topic of images.
#[derive(Debug)]
struct Topic {
    name: String,
    kind: ImageKind,
    encoding: Result<Encoding, String>,
    messages: u64,
    unstamped: u64,
    /// What was wrong with the first images, as long as none could be read.
    fault: Option<IoError>,
    readable: bool,
}

/// The topics of images, as far as they are wanted.
#[derive(Debug)]
pub(crate) struct Cameras {
    path: PathBuf,
    wanted: Option<String>,
    size: [usize; 2],
    all: Vec<Topic>,
    names: HashMap<String, usize>,
    numbers: HashMap<u32, usize>,
}

/// An image's message, or why it is none.
pub(crate) struct Seen<'a> {
    topic: String,
    /// The header's stamp, else the bag's.
    pub(crate) t: Stamp,
    message: Result<ImageMessage<'a>, Undecodable>,
    /// The message's number on its topic, from 1.
    number: u64,
}

impl Seen<'_> {
    /// The image, grey.
    ///
    /// # Errors
    /// As [`ImageMessage::grey`]; a message that is none.
    pub(crate) fn grey(&self, path: &Path, size: [usize; 2]) -> Result<GrayImage, IoError> {
        let (number, topic) = (self.number, &self.topic);
        let place = PathBuf::from(format!("{}: image {number} on {topic}", path.display()));
        match &self.message {
            Ok(message) => message.grey(&place, size),
            Err(Undecodable::Short) => {
                let problem = "is cut off: its message ends before its fields do".to_owned();
                Err(IoError::BadImage { path: place, problem })
            }
            Err(other) => {
                let problem = format!("cannot be read: such messages {other}");
                Err(IoError::BadImage { path: place, problem })
            }
        }
    }
}

impl Cameras {
    /// Images of `size` \[width, height\] on the topic `wanted`, or on any; `path` is for messages.
    pub(crate) fn new(path: &Path, wanted: Option<String>, size: [usize; 2]) -> Self {
        let (all, names, numbers) = (Vec::new(), HashMap::new(), HashMap::new());
        Self { path: path.to_path_buf(), wanted, size, all, names, numbers }
    }

    pub(crate) fn next_file(&mut self) {
        self.numbers.clear();
    }

    /// As [`crate::messages::Messages::declare`].
    pub(crate) fn declare(
        &mut self,
        number: u32,
        name: &str,
        kind: &str,
        encoding: Result<Encoding, String>,
    ) -> bool {
        // A number may come to mean another topic.
        self.numbers.remove(&number);
        let Some(kind) = ImageKind::of(kind) else { return false };
        let name = printable(name);
        let index = *self.names.entry(name.clone()).or_insert_with(|| {
            let encoding = encoding.map_err(|foreign| printable(&foreign));
            let topic =
                Topic { name, kind, encoding, messages: 0, unstamped: 0, fault: None, readable: false };
            self.all.push(topic);
            self.all.len() - 1
        });
        self.numbers.insert(number, index);
        self.wanted.as_deref().is_none_or(|wanted| wanted == self.all[index].name)
    }

    /// A message, if it is a wanted image's.
    pub(crate) fn message<'a>(&mut self, number: u32, received_ns: i64, data: &'a [u8]) -> Option<Seen<'a>> {
        let topic = &mut self.all[*self.numbers.get(&number)?];
        topic.messages += 1;
        if self.wanted.as_deref().is_some_and(|wanted| wanted != topic.name) {
            return None;
        }
        let message = decode(data, *topic.encoding.as_ref().ok()?, topic.kind);
        let stamped = message.as_ref().map_or(0, |message| message.t_ns);
        topic.unstamped += u64::from(stamped == 0);
        let t = Stamp::from_ns(if stamped == 0 { received_ns } else { stamped });
        Some(Seen { topic: topic.name.clone(), t, message, number: topic.messages })
    }

    /// The same for who only wants to know what there is: reads images until one can be.
    pub(crate) fn probe(&mut self, number: u32, data: &[u8]) {
        let Some(&index) = self.numbers.get(&number) else { return };
        let (path, size, topic) = (self.path.clone(), self.size, &self.all[index]);
        let known = topic.readable || topic.messages >= FIRST;
        if known {
            self.all[index].messages += 1;
            return;
        }
        let read = self.message(number, 0, data).map(|seen| seen.grey(&path, size));
        let topic = &mut self.all[index];
        match read {
            Some(Ok(_)) => topic.readable = true,
            Some(Err(fault)) => topic.fault = topic.fault.take().or(Some(fault)),
            None => {}
        }
    }

    /// Whether images come on more than one topic.
    pub(crate) fn are_several(&self) -> bool {
        self.wanted.is_none() && self.all.iter().filter(|topic| topic.messages > 0).count() > 1
    }

    /// Says so.
    pub(crate) fn several(&self) -> LogError {
        let used = || self.all.iter().filter(|topic| topic.messages > 0);
        let one = used().next().map_or_else(String::new, |topic| topic.name.clone());
        LogError::SeveralImageTopics {
            path: self.path.clone(),
            count: used().count(),
            topics: self.listed(),
            one,
        }
    }

    fn listed(&self) -> String {
        shortened(self.all.iter().map(|t| format!("{} ({} images)", t.name, t.messages)))
    }

    /// Messages of the chosen topic without a stamp of their own; the bag's is taken.
    pub(crate) fn remark(&self) -> Option<String> {
        let topic = self.all.iter().find(|topic| topic.unstamped > 0)?;
        Some(format!(
            "images on {} have no stamp of their own: the bag's time of arrival is taken",
            topic.name
        ))
    }

    /// The wanted topic, or the only one with images, of whose first images one can be read. `others` lists what else there is.
    ///
    /// # Errors
    /// No topic of images, several, a wanted one that is none of them; messages that cannot be understood; none of the first images of use.
    pub(crate) fn choose(mut self, others: &str) -> Result<String, LogError> {
        let path = self.path.clone();
        let index = match &self.wanted {
            Some(wanted) => match self.names.get(wanted) {
                Some(index) => *index,
                None => {
                    let names = shortened(self.all.iter().map(|t| t.name.clone()));
                    let topics = if self.all.is_empty() { others.to_owned() } else { names };
                    let similar = similar(self.all.iter().map(|t| t.name.as_str()), wanted);
                    return Err(LogError::NoImageTopic { path, wanted: wanted.clone(), topics, similar });
                }
            },
            None if self.are_several() => return Err(self.several()),
            None => match self.all.iter().position(|topic| topic.messages > 0) {
                Some(index) => index,
                None => return Err(LogError::NoImages { path, topics: others.to_owned() }),
            },
        };
        let Topic { name, encoding, fault, readable, messages, .. } = self.all.swap_remove(index);
        match (encoding, fault) {
            (Err(encoding), _) => Err(LogError::Encoding { path, topic: name, encoding }),
            (_, Some(fault)) if !readable => Err(fault.into()),
            _ if messages == 0 => Err(LogError::NoImages { path, topics: others.to_owned() }),
            _ => Ok(name),
        }
    }
}
