//! Samples of a connection on their way: dropped, late, or changed.

use std::collections::VecDeque;

use genom_protocol::{Address, ConnectionRequest};
use serde_json::Value;

use crate::model::{Fault, Harm};

/// A connection whose samples pass through here.
#[derive(Debug)]
pub(super) struct Relay {
    pub(super) fault: Fault,
    /// The connection as it was.
    pub(super) was: ConnectionRequest,
    pub(super) from: Address,
    /// Samples that the out port had written when it was looked at last.
    pub(super) seen: u64,
    /// How many came, and how many of them were hit.
    pub(super) came: u64,
    pub(super) hit: u64,
    /// Samples on their way, with the times at which they arrive.
    pub(super) waiting: VecDeque<(u64, Value)>,
}

impl Relay {
    /// A sample was written at `now`.
    pub(super) fn take(&mut self, now: u64, value: Value) {
        self.came += 1;
        let left = self.fault.samples.is_none_or(|most| self.hit < most);
        let mut at = now;
        let mut passed = Some(value);
        if left && self.came.is_multiple_of(self.fault.every) {
            self.hit += 1;
            match &self.fault.harm {
                Harm::Drop => passed = None,
                Harm::Delay(time) => at = now.saturating_add(*time),
                Harm::Corrupt(with) => passed.iter_mut().for_each(|value| replace(value, with)),
            }
        }
        // Samples stay in order, as on every middleware: one that is late holds up the next.
        let last = self.waiting.back().map_or(0, |(last, _)| *last);
        self.waiting.extend(passed.map(|value| (at.max(last), value)));
    }

    /// The next sample that has arrived by `now`.
    pub(super) fn arrived(&mut self, now: u64) -> Option<Value> {
        let first = self.waiting.front().filter(|(at, _)| *at <= now);
        first.is_some().then(|| self.waiting.pop_front()).flatten().map(|(_, value)| value)
    }
}

/// Replaces members of a value.
fn replace(value: &mut Value, with: &Value) {
    match (value, with) {
        (Value::Object(members), Value::Object(with)) => {
            for (key, with) in with {
                replace(members.entry(key.as_str()).or_insert(Value::Null), with);
            }
        }
        (value, with) => *value = with.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn relay(harm: Harm, every: u64, samples: Option<u64>) -> Relay {
        let port: Address = "a/in".parse().unwrap();
        let was = ConnectionRequest {
            inport: String::new(),
            outport: String::new(),
            policy: None,
            over: None,
            wait: false,
        };
        Relay {
            fault: Fault { port: port.clone(), harm, every, samples },
            was,
            from: port,
            seen: 0,
            came: 0,
            hit: 0,
            waiting: VecDeque::new(),
        }
    }

    /// What arrives, and when, of samples 1 to 6 that are written at times 10 to 60.
    fn arrivals(mut relay: Relay) -> Vec<(u64, Value)> {
        let mut all = Vec::new();
        for now in (10..=100).step_by(10) {
            if now <= 60 {
                relay.take(now, json!(now / 10));
            }
            all.extend(std::iter::from_fn(|| relay.arrived(now)).map(|value| (now, value)));
        }
        all
    }

    fn numbers(of: Vec<(u64, Value)>) -> Vec<u64> {
        of.into_iter().map(|(_, value)| value.as_u64().unwrap()).collect()
    }

    #[test]
    fn samples_are_dropped_by_their_number_and_only_so_many() {
        assert_eq!(numbers(arrivals(relay(Harm::Drop, 1, None))), [0_u64; 0]);
        assert_eq!(numbers(arrivals(relay(Harm::Drop, 2, None))), [1, 3, 5]);
        assert_eq!(numbers(arrivals(relay(Harm::Drop, 1, Some(4)))), [5, 6]);
    }

    #[test]
    fn samples_that_are_late_stay_in_order() {
        let all = arrivals(relay(Harm::Delay(25), 3, None));
        let times: Vec<u64> = all.iter().map(|(now, _)| *now).collect();
        // The third, of 30, and the sixth, of 60, are 25 later.
        assert_eq!(times, [10, 20, 60, 60, 60, 90]);
        assert_eq!(numbers(all), [1, 2, 3, 4, 5, 6]);
    }

    #[test]
    fn members_are_replaced_and_the_others_stay() {
        let mut value = json!({"x": 1, "in": {"a": 1, "b": 2}});
        replace(&mut value, &json!({"in": {"b": "inf"}}));
        assert_eq!(value, json!({"x": 1, "in": {"a": 1, "b": "inf"}}));
        replace(&mut value, &json!(7));
        assert_eq!(value, json!(7));
    }
}
