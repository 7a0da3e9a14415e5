//! The topics of a bag, and the samples of those that are IMUs.

use crate::imu_message::{Encoding, Undecodable, decode};
use crate::{LogError, LogOptions};
use dpn_core::{ImuSample, Stamp};
use dpn_io::{Sieve, Sieved};
use std::collections::BTreeMap;
use std::path::Path;

/// One topic.
#[derive(Debug)]
struct Topic {
    name: String,
    /// Its type, as the bag writes it.
    kind: String,
    messages: u64,
    imu: Option<Imu>,
    /// Of an IMU whose messages are written in a way that is not known: its name.
    foreign: Option<String>,
}

/// What is kept of an IMU's topic.
#[derive(Debug)]
struct Imu {
    encoding: Encoding,
    sieve: Sieve,
    /// Messages that are no `sensor_msgs/Imu`, by why.
    undecodable: BTreeMap<Undecodable, u64>,
    /// Messages whose header has no stamp: the bag's is taken.
    unstamped: u64,
}

/// Takes what a bag's reader finds, topic by topic. Only IMU messages are looked into, and with a wanted topic only that one's.
#[derive(Debug)]
pub(crate) struct Topics {
    wanted: Option<String>,
    all: Vec<Topic>,
    /// From a connection's or channel's number to a topic.
    numbers: Vec<(u32, usize)>,
}

/// What the chosen topic gives.
#[derive(Debug)]
pub(crate) struct Chosen {
    pub(crate) topic: String,
    pub(crate) samples: Vec<ImuSample>,
    pub(crate) sieved: Sieved,
    pub(crate) remarks: Vec<String>,
}

impl Topics {
    pub(crate) fn new(options: &LogOptions) -> Self {
        Self { wanted: options.topic.clone(), all: Vec::new(), numbers: Vec::new() }
    }

    /// Forgets the numbers of connections: the next file of a bag has its own.
    pub(crate) fn next_file(&mut self) {
        self.numbers.clear();
    }

    /// A connection, channel or row of a topic table. Returns whether its messages are wanted.
    pub(crate) fn declare(
        &mut self,
        number: u32,
        name: &str,
        kind: &str,
        encoding: Result<Encoding, String>,
    ) -> bool {
        let index = self.all.iter().position(|t| t.name == name).unwrap_or_else(|| {
            let is_imu = matches!(kind, "sensor_msgs/Imu" | "sensor_msgs/msg/Imu");
            let wanted = self.wanted.as_deref().is_none_or(|wanted| wanted == name);
            let (imu, foreign) = match encoding {
                _ if !(is_imu && wanted) => (None, None),
                Ok(encoding) => {
                    let (sieve, undecodable) = (Sieve::default(), BTreeMap::new());
                    (Some(Imu { encoding, sieve, undecodable, unstamped: 0 }), None)
                }
                Err(foreign) => (None, Some(foreign)),
            };
            self.all.push(Topic { name: name.to_owned(), kind: kind.to_owned(), messages: 0, imu, foreign });
            self.all.len() - 1
        });
        match self.numbers.iter_mut().find(|(n, _)| *n == number) {
            Some(known) => known.1 = index,
            None => self.numbers.push((number, index)),
        }
        self.all[index].imu.is_some()
    }

    /// A message on a declared number; `received_ns` is the bag's own stamp.
    pub(crate) fn message(&mut self, number: u32, received_ns: i64, data: &[u8]) {
        let Some(&(_, index)) = self.numbers.iter().find(|(n, _)| *n == number) else {
            return;
        };
        let topic = &mut self.all[index];
        topic.messages += 1;
        let Some(imu) = &mut topic.imu else { return };
        match decode(data, imu.encoding) {
            Ok(message) => {
                let mut sample = message.sample;
                if !message.stamped {
                    imu.unstamped += 1;
                    sample.t = Stamp::from_ns(received_ns);
                }
                imu.sieve.push(sample, topic.messages);
            }
            Err(why) => *imu.undecodable.entry(why).or_default() += 1,
        }
    }

    /// Every topic with its type.
    fn listed(&self) -> String {
        let mut names: Vec<String> =
            self.all.iter().take(12).map(|t| format!("{} ({})", t.name, t.kind)).collect();
        if self.all.len() > 12 {
            names.push("...".to_owned());
        }
        names.join(", ")
    }

    /// The wanted topic, or the only IMU there is.
    ///
    /// # Errors
    /// No IMU, several, a wanted topic that is none of them.
    pub(crate) fn choose(mut self, path: &Path, damage: Option<&str>) -> Result<Chosen, LogError> {
        let path_buf = path.to_path_buf();
        let index = match &self.wanted {
            Some(wanted) => {
                let Some(at) = self.all.iter().position(|t| t.name == *wanted) else {
                    let near = |t: &&Topic| strsim::normalized_damerau_levenshtein(&t.name, wanted) > 0.6;
                    let mut names: Vec<&Topic> = self.all.iter().filter(near).collect();
                    names.sort_by(|a, b| {
                        strsim::normalized_damerau_levenshtein(&b.name, wanted)
                            .total_cmp(&strsim::normalized_damerau_levenshtein(&a.name, wanted))
                    });
                    let slashed = format!("/{wanted}");
                    let exact = self.all.iter().find(|t| t.name == slashed);
                    return Err(LogError::NoTopic {
                        path: path_buf,
                        similar: exact.or(names.first().copied()).map(|t| t.name.clone()),
                        topics: self.listed(),
                        wanted: wanted.clone(),
                    });
                };
                if self.all[at].imu.is_none() {
                    let Topic { name, kind, foreign, .. } = self.all.swap_remove(at);
                    return Err(match foreign {
                        Some(encoding) => LogError::Encoding { path: path_buf, topic: name, encoding },
                        None => LogError::NotImu { path: path_buf, topic: name, kind },
                    });
                }
                at
            }
            None => {
                let mut imus: Vec<usize> =
                    (0..self.all.len()).filter(|&i| self.all[i].imu.is_some()).collect();
                // A topic that was announced and never used is no choice.
                if imus.len() > 1 {
                    imus.retain(|&i| self.all[i].messages > 0);
                }
                match imus[..] {
                    [] => {
                        let foreign = |t: &Topic| Some((t.name.clone(), t.foreign.clone()?));
                        if let Some((topic, encoding)) = self.all.iter().find_map(foreign) {
                            return Err(LogError::Encoding { path: path_buf, topic, encoding });
                        }
                        return Err(LogError::NoImu {
                            path: path_buf,
                            topics: self.listed(),
                            damage: damage.map(str::to_owned),
                        });
                    }
                    [only] => only,
                    _ => {
                        let name =
                            |&i: &usize| format!("{} ({} messages)", self.all[i].name, self.all[i].messages);
                        return Err(LogError::SeveralTopics {
                            path: path_buf,
                            count: imus.len(),
                            topics: imus.iter().map(name).collect::<Vec<_>>().join(", "),
                            one: self.all[imus[0]].name.clone(),
                        });
                    }
                }
            }
        };
        let Topic { name, messages, imu, .. } = self.all.swap_remove(index);
        let Some(Imu { sieve, undecodable, unstamped, .. }) = imu else {
            return Err(LogError::NotImu { path: path_buf, topic: name, kind: String::new() });
        };
        let mut remarks = Vec::new();
        for (why, count) in undecodable {
            remarks.push(format!("{count} of {messages} messages on {name} {why}; they are left out"));
        }
        if unstamped > 0 {
            remarks.push(format!(
                "{unstamped} of {messages} messages on {name} have no stamp of their own: the bag's time of arrival is taken"
            ));
        }
        let (samples, sieved) = sieve.done();
        Ok(Chosen { topic: name, samples, sieved, remarks })
    }
}
