//! Bare iceoryx2: slices of octets, copied in and out.

use std::hint::black_box;
use std::path::Path;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::pair::{Receive, Send};

/// Opens ends of services by the size of their values.
#[derive(Debug)]
pub struct Bare(Node<ipc_threadsafe::Service>);

struct Out(Publisher<ipc_threadsafe::Service, [u8], ()>, Vec<u8>);

struct In(Subscriber<ipc_threadsafe::Service, [u8], ()>, Vec<u8>);

impl Send for Out {
    fn send(&mut self) {
        let sample = self.0.loan_slice_uninit(self.1.len()).unwrap();
        sample.write_from_slice(black_box(&self.1)).send().unwrap();
    }
}

impl Receive for In {
    fn arrived(&mut self) -> bool {
        let Some(sample) = self.0.receive().unwrap() else { return false };
        self.1.copy_from_slice(sample.payload());
        black_box(&mut self.1);
        true
    }
}

impl Bare {
    /// In a folder that nothing else uses; both processes open the same.
    ///
    /// # Panics
    /// iceoryx2 refuses.
    #[must_use]
    pub fn open(place: &Path) -> Self {
        let name = place.file_name().unwrap_or_default().to_string_lossy().replace('.', "");
        let mut config = Config::default();
        config.global.prefix = FileName::new(format!("bare{name}_").as_bytes()).unwrap();
        let root = place.join("bare").display().to_string();
        config.global.set_root_path(&iceoryx2::prelude::Path::new(root.as_bytes()).unwrap());
        Self(NodeBuilder::new().config(&config).create().unwrap())
    }

    fn service(&self, bytes: usize) -> PortFactory<ipc_threadsafe::Service, [u8], ()> {
        let name = ServiceName::new(&format!("bare/{bytes}")).unwrap();
        self.0.service_builder(&name).publish_subscribe::<[u8]>().open_or_create().unwrap()
    }

    /// The writing end for values of so many bytes.
    ///
    /// # Panics
    /// iceoryx2 refuses.
    #[must_use]
    pub fn writer(&self, bytes: usize) -> Box<dyn Send> {
        let service = self.service(bytes);
        let writer = service.publisher_builder().initial_max_slice_len(bytes).create().unwrap();
        Box::new(Out(writer, vec![1; bytes]))
    }

    /// The reading end.
    ///
    /// # Panics
    /// iceoryx2 refuses.
    #[must_use]
    pub fn reader(&self, bytes: usize) -> Box<dyn Receive> {
        let reader = self.service(bytes).subscriber_builder().create().unwrap();
        Box::new(In(reader, vec![0; bytes]))
    }
}
