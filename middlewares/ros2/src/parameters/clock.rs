//! `use_sim_time`, a parameter of every node in ROS: whether its time is that of a simulator.
//!
//! All components of a daemon have one clock, so that the parameter cannot be changed.

use ros2_client::parameters::ParameterValue as Value;

use super::error::SetError;
use super::value;

/// Its name.
pub(super) const NAME: &str = "use_sim_time";
/// What it says, for users.
pub(super) const DESCRIPTION: &str = "whether components live in the time of /clock";
pub(super) const CONSTRAINT: &str = "what the clock of the daemon is";

/// The parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    pub(super) simulated: bool,
}

impl Clock {
    pub(super) fn value(self) -> Value {
        Value::Boolean(self.simulated)
    }

    /// Setting it to what it is succeeds, so that launch files may say what is true.
    pub(super) fn set(self, wanted: &Value) -> Result<(), SetError> {
        match wanted {
            Value::Boolean(wanted) if *wanted == self.simulated => Ok(()),
            Value::Boolean(true) => Err(SetError::OwnTime),
            Value::Boolean(false) => Err(SetError::SimulatedTime),
            other => {
                let given = value::name_of(other.to_parameter_type());
                Err(SetError::Type { wanted: "bool", given })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_can_be_set_to_what_it_is_and_to_nothing_else() {
        let set = |simulated, wanted| Clock { simulated }.set(&wanted).map_err(|e| e.to_string());
        for simulated in [false, true] {
            assert_eq!(set(simulated, Value::Boolean(simulated)), Ok(()));
            let why = set(simulated, Value::Boolean(!simulated)).unwrap_err();
            assert!(why.contains("clock of all components is that of the daemon"), "{why}");
            let why = set(simulated, Value::Integer(1)).unwrap_err();
            assert_eq!(why, "it is of type bool, not integer");
        }
        assert!(set(false, Value::Boolean(true)).unwrap_err().contains("--clock ros"));
        assert!(set(true, Value::Boolean(false)).unwrap_err().contains("--clock monotonic"));
    }
}
