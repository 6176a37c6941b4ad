//! One numbering of channels and samples out of several.

use std::collections::HashMap;

use genom_protocol::frames::{Channel, Frame, Lost, Sample};

use super::order::{Held, Order};

/// Key and rank of the daemon; cells follow.
const OWN: usize = 0;

/// Channels of a recording: their numbers have 16 bits.
const MOST: usize = 1 << 16;

/// Which process a frame is of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    /// By which the channels there are known.
    pub(super) key: usize,
    /// Its rank in the order of processes; the next process of a cell has the same.
    pub(super) rank: usize,
}

impl Origin {
    /// The daemon itself.
    pub(super) const DAEMON: Self = Self { key: OWN, rank: OWN };
}

/// Makes one stream of several: with one numbering, and in order where there is one.
#[derive(Default)]
pub(super) struct Merger {
    /// Number of a channel by source and number there.
    channels: HashMap<(usize, u16), u16>,
    by_topic: HashMap<String, u16>,
    /// Samples passed on, by channel.
    samples: HashMap<u16, u32>,
    /// Samples lost, by channel and source.
    lost: HashMap<u16, HashMap<usize, u64>>,
    /// Channels that were begun; a recording has [`MOST`] at most.
    begun: usize,
    /// If samples are to be in order: of so many processes, and what it is once it is known that their
    /// clock is stepped.
    processes: usize,
    order: Option<Order>,
}

impl Merger {
    /// For samples of so many processes, in order if they can be.
    pub(super) fn ordered(processes: usize) -> Self {
        Self { processes, ..Self::default() }
    }

    /// Takes a frame of a source, and appends what becomes of it.
    pub(super) fn take(&mut self, of: Origin, frame: Frame<'_>, out: &mut Vec<u8>) {
        let Origin { key, rank } = of;
        match frame {
            Frame::Start(start) if key == OWN => {
                if self.processes > 0 && start.clock.is_stepped() {
                    self.order = Some(Order::of(self.processes));
                }
                Frame::Start(start).append(out);
            }
            Frame::Start(_) | Frame::End(_) => {}
            Frame::Channel(channel) => self.channel(key, channel, out),
            Frame::Sample(sample) => {
                let Some(&channel) = self.channels.get(&(key, sample.channel)) else { return };
                let Sample { date, message, .. } = sample;
                match &mut self.order {
                    Some(order) => {
                        let message = message.to_vec();
                        order.hold(rank, Held { channel, date, message });
                    }
                    None => self.pass(channel, date, message, out),
                }
            }
            Frame::Until(date) => self.has_come(rank, date, out),
            Frame::Lost(Lost { channel, lost }) => {
                let Some(&channel) = self.channels.get(&(key, channel)) else { return };
                let all = self.lost.entry(channel).or_default();
                all.insert(key, lost);
                Frame::Lost(Lost { channel, lost: all.values().sum() }).append(out);
            }
        }
    }

    /// What is dated before that has come from a process; all of it, from one that has ended.
    pub(super) fn has_come(&mut self, rank: usize, until: u64, out: &mut Vec<u8>) {
        if let Some(order) = &mut self.order {
            order.has_come(rank, until);
            self.pass_held(out);
        }
    }

    /// Nothing more will come.
    pub(super) fn end(&mut self, out: &mut Vec<u8>) {
        if let Some(order) = &mut self.order {
            order.end();
            self.pass_held(out);
        }
    }

    fn pass_held(&mut self, out: &mut Vec<u8>) {
        while let Some(Held { channel, date, message }) = self.order.as_mut().and_then(Order::next)
        {
            self.pass(channel, date, &message, out);
        }
    }

    fn pass(&mut self, channel: u16, date: u64, message: &[u8], out: &mut Vec<u8>) {
        let next = self.samples.entry(channel).or_default();
        Frame::Sample(Sample { channel, number: *next, date, message }).append(out);
        *next = next.wrapping_add(1);
    }

    fn channel(&mut self, source: usize, channel: Channel, out: &mut Vec<u8>) {
        let there = channel.channel;
        let here = match self.by_topic.get(&channel.topic) {
            Some(&known) => known,
            None => {
                let Ok(new) = u16::try_from(self.begun) else {
                    let topic = channel.topic;
                    tracing::warn!("{topic} is not recorded: a recording has {MOST} channels");
                    return;
                };
                self.begun += 1;
                self.by_topic.insert(channel.topic.clone(), new);
                Frame::Channel(Channel { channel: new, ..channel }).append(out);
                new
            }
        };
        self.channels.insert((source, there), here);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn channel(number: u16, topic: &str) -> Frame<'static> {
        Frame::Channel(Channel {
            channel: number,
            topic: topic.to_owned(),
            encoding: String::new(),
            schema: String::new(),
            definition: String::new(),
            metadata: BTreeMap::new(),
        })
    }

    fn sample(channel: u16, number: u32, message: &[u8]) -> Frame<'_> {
        Frame::Sample(Sample { channel, number, date: 0, message })
    }

    fn all(mut bytes: &[u8]) -> Vec<String> {
        let mut told = Vec::new();
        while let Some((frame, length)) = Frame::first(bytes).unwrap() {
            told.push(match frame {
                Frame::Channel(one) => format!("{} {}", one.channel, one.topic),
                Frame::Sample(one) => format!("{}:{} {:?}", one.channel, one.number, one.message),
                Frame::Lost(one) => format!("{} lost {}", one.channel, one.lost),
                other => format!("{other:?}"),
            });
            bytes = &bytes[length..];
        }
        told
    }

    #[test]
    fn channels_of_one_topic_are_one_and_samples_are_numbered_without_gaps() {
        let (mut merger, mut out) = (Merger::default(), Vec::new());
        for (source, frame) in [
            (0, channel(0, "/genom/calls")),
            (0, channel(1, "/genom/changes")),
            (1, channel(0, "/genom/calls")),
            (1, channel(1, "/genom/changes")),
            (1, channel(4, "/far/pose")),
            (1, sample(0, 0, &[1])),
            (0, sample(0, 0, &[2])),
            (1, sample(1, 0, &[3])),
            (1, sample(4, 0, &[4])),
            (0, Frame::Lost(Lost { channel: 0, lost: 2 })),
            (1, Frame::Lost(Lost { channel: 0, lost: 3 })),
        ] {
            merger.take(Origin { key: source, rank: source }, frame, &mut out);
        }
        let told = all(&out);
        assert_eq!(
            told,
            [
                "0 /genom/calls",
                "1 /genom/changes",
                "2 /far/pose",
                "0:0 [1]",
                "0:1 [2]",
                "1:0 [3]",
                "2:0 [4]",
                "0 lost 2",
                "0 lost 5"
            ]
        );
    }

    #[test]
    fn no_two_channels_have_one_number_however_many_there_are() {
        let (mut merger, mut out) = (Merger::default(), Vec::new());
        for number in 0..MOST + 2 {
            let of = (number % MOST) as u16;
            let origin = Origin { key: number / MOST, rank: 0 };
            merger.take(origin, channel(of, &format!("/a/{number}")), &mut out);
        }
        let told = all(&out);
        assert_eq!((told.len(), told.last().unwrap().as_str()), (MOST, "65535 /a/65535"));
        out.clear();
        merger.take(Origin { key: 1, rank: 1 }, sample(1, 0, &[1]), &mut out);
        assert!(out.is_empty(), "it has no channel");
    }
}
