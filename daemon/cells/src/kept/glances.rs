//! What the ends of files tell, which is read once for each.

use std::collections::BTreeMap;
use std::fs::{File, Metadata};
use std::path::Path;
use std::sync::Mutex;
use std::time::SystemTime;

use genom_protocol::{KeptRecording, KeptState};
use genom_recording::{Glance, glance};

use super::base::lock;

/// Size and date by which a file is known again.
type Stamp = (u64, Option<SystemTime>);

/// What a file is: whole, or why not.
type Found = Result<Glance, KeptState>;

/// What was seen, by name.
#[derive(Default)]
pub(super) struct Glances(Mutex<BTreeMap<String, (Stamp, Found)>>);

impl Glances {
    /// Says of a recording what its file tells.
    pub(super) fn tell(&self, path: &Path, found: &Metadata, told: &mut KeptRecording) {
        let stamp = (found.len(), found.modified().ok());
        let known =
            lock(&self.0).get(&told.file).filter(|(seen, _)| *seen == stamp).map(|one| one.1);
        let seen = known.unwrap_or_else(|| {
            let file = File::open(path).map_err(genom_recording::ReadError::from);
            match file.and_then(|file| glance(&file)) {
                Ok(Some(glance)) => Ok(glance),
                Ok(None) => Err(KeptState::Cut),
                Err(_) => Err(KeptState::Damaged),
            }
        });
        lock(&self.0).insert(told.file.clone(), (stamp, seen));
        match seen {
            Ok(Glance { messages, seconds }) => {
                told.state = KeptState::Whole;
                (told.messages, told.seconds) = (Some(messages), Some(seconds));
            }
            Err(state) => told.state = state,
        }
    }

    /// Forgets files that are gone.
    pub(super) fn forget_but(&self, names: &[String]) {
        lock(&self.0).retain(|file, _| names.contains(file));
    }
}
