//! Bare iceoryx2: slices of octets, copied in and out.

use std::fmt::Debug;
use std::hint::black_box;
use std::path::Path;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use super::ends::Bare;
use crate::error::FloorError;
use crate::pair::{Receive, Send};

/// A node of iceoryx2.
#[derive(Debug)]
pub struct Iceoryx(Node<ipc_threadsafe::Service>);

struct Out(Publisher<ipc_threadsafe::Service, [u8], ()>, Vec<u8>);

struct In(Subscriber<ipc_threadsafe::Service, [u8], ()>, Vec<u8>);

fn refused(error: impl Debug) -> FloorError {
    FloorError::of("iceoryx2")(format!("{error:?}"))
}

impl Send for Out {
    fn send(&mut self) -> Result<(), FloorError> {
        let sample = self.0.loan_slice_uninit(self.1.len()).map_err(refused)?;
        sample.write_from_slice(black_box(&self.1)).send().map(drop).map_err(refused)
    }
}

impl Receive for In {
    fn arrived(&mut self) -> Result<bool, FloorError> {
        let Some(sample) = self.0.receive().map_err(refused)? else { return Ok(false) };
        self.1.copy_from_slice(sample.payload());
        black_box(&mut self.1);
        Ok(true)
    }
}

impl Iceoryx {
    /// In a folder that nothing else uses; both processes open the same.
    ///
    /// # Errors
    /// iceoryx2 refuses.
    pub fn open(place: &Path) -> Result<Self, FloorError> {
        let name = place.file_name().unwrap_or_default().to_string_lossy().replace('.', "");
        let mut config = Config::default();
        config.global.prefix = FileName::new(format!("bare{name}_").as_bytes()).map_err(refused)?;
        let root = place.join("bare").display().to_string();
        let root = iceoryx2::prelude::Path::new(root.as_bytes()).map_err(refused)?;
        config.global.set_root_path(&root);
        NodeBuilder::new().config(&config).create().map(Self).map_err(refused)
    }

    fn service(
        &self,
        bytes: usize,
    ) -> Result<PortFactory<ipc_threadsafe::Service, [u8], ()>, FloorError> {
        let name = ServiceName::new(&format!("bare/{bytes}")).map_err(refused)?;
        let service = self.0.service_builder(&name).publish_subscribe::<[u8]>();
        service.open_or_create().map_err(refused)
    }
}

impl Bare for Iceoryx {
    fn writer(&self, bytes: usize) -> Result<Box<dyn Send>, FloorError> {
        let service = self.service(bytes)?;
        let writer = service.publisher_builder().initial_max_slice_len(bytes).create();
        Ok(Box::new(Out(writer.map_err(refused)?, vec![1; bytes])))
    }

    fn reader(&self, bytes: usize) -> Result<Box<dyn Receive>, FloorError> {
        let reader = self.service(bytes)?.subscriber_builder().create().map_err(refused)?;
        Ok(Box::new(In(reader, vec![0; bytes])))
    }
}
