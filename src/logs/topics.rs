//! The topics of a bag, and the samples of those that are IMUs.

use crate::budget::Budget;
use crate::chosen::Chosen;
use crate::fields::{Encoding, Undecodable};
use crate::imu_message::{decode, is_imu};
use crate::join::join;
use crate::messages::Messages;
use crate::two_clocks::TwoClocks;
use crate::{LogError, LogOptions};
use dpn_core::{ImuSample, Sensor, Stamp};
use dpn_io::{IoError, Sieve, printable};
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// One topic.
#[derive(Debug)]
struct Topic {
    name: String,
    /// Its type, as the bag writes it.
    kind: String,
    messages: u64,
    imu: Option<Box<Imu>>,
    /// Of an IMU whose messages are written in a way that is not known: its name.
    foreign: Option<String>,
}

/// What is kept of an IMU's topic.
#[derive(Debug)]
struct Imu {
    encoding: Encoding,
    sieve: Sieve,
    /// Of which sensors the samples kept speak.
    speaks: Speaks,
    /// Messages that are no `sensor_msgs/Imu`, by why.
    undecodable: BTreeMap<Undecodable, u64>,
    /// Messages whose header has no stamp: the bag's is taken.
    unstamped: u64,
    /// Stamp and time of arrival \[ns\] of the first sample kept, and of the last.
    ends: Option<[[i64; 2]; 2]>,
    /// What the first message says of its variances, as long as all say the same.
    variances: Option<[Option<[f64; 3]>; 2]>,
}

impl Imu {
    fn new(encoding: Encoding) -> Self {
        Self {
            encoding,
            sieve: Sieve::default(),
            speaks: Speaks::default(),
            undecodable: BTreeMap::new(),
            unstamped: 0,
            ends: None,
            variances: None,
        }
    }

    /// Takes note of when a sample arrived.
    fn arrived(&mut self, t: Stamp, received_ns: i64) {
        let now = [t.ns(), received_ns];
        let first = self.ends.map_or(now, |[first, _]| first);
        self.ends = Some([first, now]);
    }

    /// Says what of its messages was left out or amended.
    fn complain(&self, name: &str, messages: u64, remarks: &mut Vec<String>) {
        for (why, count) in &self.undecodable {
            remarks.push(format!("{count} of {messages} messages on {name} {why}; they are left out"));
        }
        if self.unstamped > 0 {
            let unstamped = self.unstamped;
            remarks.push(format!(
                "{unstamped} of {messages} messages on {name} have no stamp of their own: the bag's time of arrival is taken"
            ));
        }
    }
}

impl Topic {
    /// The only sensor whose values are not zero throughout, where there is one.
    fn half(&self) -> Option<Sensor> {
        self.imu.as_ref()?.speaks.half()
    }
}

/// The first dozen of a list that a hostile bag may have made endless, each name of a length that can be read.
pub(crate) fn shortened(names: impl ExactSizeIterator<Item = String>) -> String {
    const MOST: usize = 12;
    const LONGEST: usize = 120;
    let is_long = names.len() > MOST;
    let cut = |name: String| match name.char_indices().nth(LONGEST) {
        Some((at, _)) => format!("{}...", &name[..at]),
        None => name,
    };
    let mut names: Vec<String> = names.take(MOST).map(cut).collect();
    if is_long {
        names.push("...".to_owned());
    }
    names.join(", ")
}

/// The topic of the other sensor, where a camera names its gyroscope's and its accelerometer's alike: `/camera/gyro/sample`, `/camera/accel/sample`.
pub(crate) fn sibling(name: &str) -> Option<String> {
    let pairs = [("gyro", "accel"), ("Gyro", "Accel"), ("GYRO", "ACCEL")];
    let both_ways = pairs.into_iter().flat_map(|(gyro, accel)| [(gyro, accel), (accel, gyro)]);
    both_ways.into_iter().find(|(one, _)| name.contains(one)).map(|(one, other)| name.replace(one, other))
}

/// Whether the topic `name` is `wanted`, or its sibling; without a wanted one each is.
pub(crate) fn is_wanted(wanted: Option<&str>, name: &str) -> bool {
    wanted.is_none_or(|wanted| wanted == name || sibling(wanted).is_some_and(|other| other == name))
}

/// Whether a topic's gyroscope has said anything but zeros, and its accelerometer.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Speaks([bool; 2]);

impl Speaks {
    pub(crate) fn hear(&mut self, sample: &ImuSample) {
        self.0[0] |= sample.gyro != [0.0; 3];
        self.0[1] |= sample.accel != [0.0; 3];
    }

    /// The only sensor that has spoken, where there is one.
    pub(crate) fn half(self) -> Option<Sensor> {
        match self.0 {
            [true, false] => Some(Sensor::Gyro),
            [false, true] => Some(Sensor::Accel),
            _ => None,
        }
    }

    /// Whether both have.
    #[cfg(feature = "images")]
    pub(crate) fn are_both(self) -> bool {
        self.0 == [true; 2]
    }
}

/// Of names the one that `wanted` may have been meant for.
pub(crate) fn similar<'a>(names: impl Iterator<Item = &'a str> + Clone, wanted: &str) -> Option<String> {
    let slashed = format!("/{wanted}");
    if names.clone().any(|name| name == slashed) {
        return Some(slashed);
    }
    // Nobody mistypes a name of hundreds of letters, and likening one takes time with the square of them.
    let short = names.filter(|name| name.len() <= 200 && wanted.len() <= 200);
    let likened = short.map(|name| (strsim::normalized_damerau_levenshtein(name, wanted), name));
    let near = likened.filter(|(likeness, _)| *likeness > 0.6);
    near.reduce(|best, next| if next.0 > best.0 { next } else { best }).map(|(_, name)| name.to_owned())
}

/// Takes what a bag's reader finds, topic by topic. Only IMU messages are looked into, and with a wanted topic only that one's
/// and its sibling's.
#[derive(Debug)]
pub(crate) struct Topics {
    wanted: Option<String>,
    all: Vec<Topic>,
    /// From a topic's name to its place: a file may have a hundred thousand.
    names: HashMap<String, usize>,
    /// From a connection's or channel's number to a topic.
    numbers: HashMap<u32, usize>,
    /// What the log may unpack to.
    budget: Budget,
}

impl Topics {
    pub(crate) fn new(options: &LogOptions) -> Self {
        Self {
            wanted: options.topic.clone(),
            all: Vec::new(),
            names: HashMap::new(),
            numbers: HashMap::new(),
            budget: Budget::new(options.max_uncompressed),
        }
    }

    /// Every topic with its type.
    pub(crate) fn listed(&self) -> String {
        shortened(self.all.iter().map(|t| format!("{} ({})", t.name, t.kind)))
    }

    /// The wanted topic, or the only IMU there is.
    ///
    /// # Errors
    /// No IMU, several, a wanted topic that is none of them.
    ///
    /// A RealSense and its like write each sensor on a topic of its own, the other's values zero: where one of each is all there is, they are
    /// joined; beside a topic that has both, they are no choice. Of several such cameras the wanted topic chooses one, its [`sibling`] with it.
    pub(crate) fn choose(mut self, path: &Path, damage: Option<&str>) -> Result<Chosen, LogError> {
        let path_buf = path.to_path_buf();
        let mut other = None;
        let mut guesses = Vec::new();
        let index = match &self.wanted {
            Some(wanted) => {
                let Some(&at) = self.names.get(wanted) else {
                    let names = self.all.iter().map(|t| t.name.as_str());
                    return Err(LogError::NoTopic {
                        path: path_buf,
                        similar: similar(names, wanted),
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
                let beside = sibling(wanted).and_then(|name| self.names.get(&name).copied());
                match (self.all[at].half(), beside.and_then(|i| Some((i, self.all[i].half()?)))) {
                    (Some(Sensor::Gyro), Some((beside, Sensor::Accel))) => {
                        other = Some(beside);
                        at
                    }
                    (Some(Sensor::Accel), Some((beside, Sensor::Gyro))) => {
                        other = Some(at);
                        beside
                    }
                    _ => at,
                }
            }
            None => {
                let mut imus: Vec<usize> =
                    (0..self.all.len()).filter(|&i| self.all[i].imu.is_some()).collect();
                // A topic that was announced and never used is no choice.
                if imus.len() > 1 {
                    imus.retain(|&i| self.all[i].messages > 0);
                }
                let all = &self.all;
                let halves =
                    |half| imus.iter().copied().filter(|i| all[*i].half() == half).collect::<Vec<usize>>();
                let [whole, gyros, accels] = [None, Some(Sensor::Gyro), Some(Sensor::Accel)].map(halves);
                match (imus.len(), &whole[..], &gyros[..], &accels[..]) {
                    (2, [], [gyro], [accel]) => {
                        other = Some(*accel);
                        imus = vec![*gyro];
                    }
                    (2.., [whole], ..) => {
                        let name = &self.all[*whole].name;
                        guesses.push(format!(
                            "{name}, the only topic with both sensors of {} (--topic)",
                            imus.len()
                        ));
                        imus = vec![*whole];
                    }
                    _ => {}
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
                            topics: shortened(imus.iter().map(name)),
                            one: self.all[imus[0]].name.clone(),
                        });
                    }
                }
            }
        };
        let accel = other.and_then(|at| {
            Some((self.all[at].name.clone(), self.all[at].imu.take()?, self.all[at].messages))
        });
        let Topic { name, messages, imu, .. } = self.all.swap_remove(index);
        let Some(imu) = imu else {
            return Err(LogError::NotImu { path: path_buf, topic: name, kind: String::new() });
        };
        let mut remarks = Vec::new();
        imu.complain(&name, messages, &mut remarks);
        let storing = |e| IoError::reading(path, e);
        let mut clocks = None;
        let mut variances = imu.variances.unwrap_or_default();
        let mut sifted = imu.sieve.done().map_err(storing)?;
        if let Some((accel_name, accel, messages)) = accel {
            accel.complain(&accel_name, messages, &mut remarks);
            variances[1] = accel.variances.unwrap_or_default()[1];
            let clock = imu.ends.zip(accel.ends).and_then(|(gyro, accel)| TwoClocks::of(gyro, accel));
            clocks = clock.map(|clock| clock.words(&name, &accel_name));
            let accel = accel.sieve.done().map_err(storing)?.part.samples;
            let accel = match clock {
                Some(clock) => {
                    accel.changed(|s| Some(ImuSample { t: clock.at(s.t), ..s })).map_err(storing)?
                }
                None => accel,
            };
            let joined = join(&sifted.part.samples, &accel).map_err(storing)?;
            guesses.push(joined.remark(&name, &accel_name));
            remarks.extend(joined.left_out());
            sifted = sifted.with(joined.samples);
        }
        Ok(Chosen { topic: name, sifted, clocks, variances, remarks, guesses })
    }
}

impl Messages for Topics {
    fn next_file(&mut self) {
        self.numbers.clear();
    }

    fn declare(&mut self, number: u32, name: &str, kind: &str, encoding: Result<Encoding, String>) -> bool {
        let name = printable(name);
        let index = match self.names.get(&name) {
            Some(index) => *index,
            None => {
                let wanted = is_wanted(self.wanted.as_deref(), &name);
                let (imu, foreign) = match encoding {
                    _ if !(is_imu(kind) && wanted) => (None, None),
                    Ok(encoding) => (Some(Box::new(Imu::new(encoding))), None),
                    Err(foreign) => (None, Some(printable(&foreign))),
                };
                self.names.insert(name.clone(), self.all.len());
                self.all.push(Topic { name, kind: printable(kind), messages: 0, imu, foreign });
                self.all.len() - 1
            }
        };
        self.numbers.insert(number, index);
        self.all[index].imu.is_some()
    }

    fn message(&mut self, number: u32, received_ns: i64, data: &[u8]) {
        let Some(&index) = self.numbers.get(&number) else { return };
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
                if imu.sieve.push(sample, topic.messages) {
                    imu.speaks.hear(&sample);
                    let first = *imu.variances.get_or_insert(message.variances);
                    if first != message.variances {
                        imu.variances = Some([None; 2]);
                    }
                    imu.arrived(sample.t, received_ns);
                }
            }
            Err(why) => *imu.undecodable.entry(why).or_default() += 1,
        }
    }

    fn budget(&mut self) -> &mut Budget {
        &mut self.budget
    }
}
