//! Inputs of a request: all of them or, for an attribute, some of them; the others keep their
//! present values (genom3.md 4.10).

use std::sync::mpsc::channel;
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use genom_description::model::{Direction, ServiceIx, ServiceKind};
use genom_runtime::{Exception, Inputs, Outcome, Progress, Ticket, input_record};
use genom_types::Record;
use serde_json::Value;

use super::hosted::Hosted;
use super::input::{Asked, Completion, InputError, Rest};

/// How long to wait for codels before giving up reading an attribute's present values.
const PATIENCE: Duration = Duration::from_millis(250);

impl Hosted {
    /// Converts the inputs of a service from JSON.
    pub fn asked(
        &self,
        service: ServiceIx,
        given: &Value,
        rest: Rest,
    ) -> Result<Asked, InputError> {
        let model = &self.model().services[service];
        let filled = self.filled(service, given);
        if rest == Rest::Zero {
            return filled.map(Asked::Whole);
        }
        if model.kind == ServiceKind::Attribute {
            return match filled {
                // Whether the member of a union is valid depends on the present value, for which
                // the default was used here: this is decided when the request is executed.
                Err(error) if !error.depends => Err(error),
                _ => Ok(Asked::Partial(given.clone())),
            };
        }
        let record = filled?;
        let defaults: serde_json::Map<_, _> = model
            .parameters
            .iter()
            .filter(|one| one.direction != Direction::Out)
            .filter_map(|one| Some((one.name.clone(), one.default.as_ref()?.value.clone()?)))
            .collect();
        match record.missing(&[given, &Value::Object(defaults)]) {
            Some(path) => Err(InputError::missing(&model.name, path)),
            None => Ok(Asked::Whole(record)),
        }
    }

    /// The given inputs, completed with the defaults of the description, or zero where there is
    /// none.
    pub fn filled(&self, service: ServiceIx, given: &Value) -> Result<Record, InputError> {
        let name = self.model().services[service].name.as_str();
        let refused = |error| InputError::new(name, error);
        let empty = || Record::new(&self.plan().services()[service].input);
        let mut record = input_record(self.plan(), service).map_err(refused)?.unwrap_or_else(empty);
        record.merge_json(given).map_err(refused)?;
        Ok(record)
    }

    /// The present values of an attribute's inputs. `None` if the service is not an attribute, or
    /// if codels exclude reading them for longer than a moment. Blocks meanwhile.
    pub fn current(&self, service: ServiceIx) -> Option<Value> {
        let model = &self.model().services[service];
        let takes = model.parameters.iter().any(|one| one.direction != Direction::Out);
        if model.kind != ServiceKind::Attribute || !takes {
            return None;
        }
        let (sender, told) = channel();
        let ticket = Ticket::default();
        let reply = Box::new(move |progress| {
            if let Progress::Ended(Outcome::Success(record)) = progress {
                let _ = sender.send(record.to_json());
            }
        });
        self.instance.request_by(&ticket, service, Inputs::Look, reply);
        let current = told.recv_timeout(PATIENCE).ok();
        if current.is_none() {
            let _ = self.instance.give_up(service, &ticket);
        }
        current
    }

    /// The inputs in the form that the runtime takes. For partial inputs, also the place where the
    /// completed inputs, or the reason for refusing them, are stored.
    pub(super) fn inputs(&self, service: ServiceIx, asked: Asked) -> (Inputs, Option<Completion>) {
        let given = match asked {
            Asked::Whole(record) => return (Inputs::Whole(record), None),
            Asked::Partial(given) => given,
        };
        let completion = Completion::default();
        let (done, name) = (Arc::clone(&completion), self.model().services[service].name.clone());
        let fill = move |inputs: &mut Record| {
            let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
            match inputs.merge_json(&given) {
                Ok(()) => {
                    done.inputs = Some(inputs.to_json());
                    Ok(())
                }
                Err(error) => {
                    done.refused = Some(InputError::new(&name, error));
                    let name = "::genom::serialization".to_owned();
                    Err(Exception { name, detail: Value::Null })
                }
            }
        };
        (Inputs::Partial(Box::new(fill)), Some(completion))
    }
}
