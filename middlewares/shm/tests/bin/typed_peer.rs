//! A program that uses iceoryx2 and nothing of ours: it declares the type and the name of a port,
//! and reads or writes it. The tests control it through its standard input and output.
//!
//! `shm-typed-peer PREFIX ROOT read|read-double|write|create|write-bytes|wrong SERVICE`

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program of the tests")]

use std::io::BufRead;

use iceoryx2::prelude::*;

/// The type `::demo::state` of the IDL.
#[derive(Clone, Copy, Debug, ZeroCopySend)]
#[type_name("demo::state")]
#[repr(C)]
struct State {
    count: u64,
    values: [f64; 7],
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [prefix, root, role, service] = arguments.as_slice() else {
        println!("usage: PREFIX ROOT ROLE SERVICE");
        return;
    };
    let mut config = Config::default();
    config.global.prefix = FileName::new(prefix.as_bytes()).unwrap();
    config.global.set_root_path(&Path::new(root.as_bytes()).unwrap());
    let node = NodeBuilder::new().config(&config).create::<ipc::Service>().unwrap();
    let name = ServiceName::new(service).unwrap();
    let lines = std::io::stdin().lock().lines().map(Result::unwrap);
    match role.as_str() {
        "read" => {
            let port = node.service_builder(&name).publish_subscribe::<State>().open().unwrap();
            let reader = port.subscriber_builder().create().unwrap();
            println!("ready");
            // Each input line asks for one sample.
            for _ in lines {
                let sample = loop {
                    if let Some(sample) = reader.receive().unwrap() {
                        break sample;
                    }
                    std::thread::yield_now();
                };
                println!("{} {:?}", sample.count, sample.values);
            }
        }
        "read-double" => {
            let port = node.service_builder(&name).publish_subscribe::<f64>().open().unwrap();
            let reader = port.subscriber_builder().create().unwrap();
            println!("ready");
            for _ in lines {
                let sample = loop {
                    if let Some(sample) = reader.receive().unwrap() {
                        break sample;
                    }
                    std::thread::yield_now();
                };
                println!("{}", *sample);
            }
        }
        "write" | "create" => {
            let builder = node.service_builder(&name).publish_subscribe::<State>();
            let port =
                if role == "write" { builder.open().unwrap() } else { builder.create().unwrap() };
            let writer = port.publisher_builder().create().unwrap();
            println!("ready");
            // Each input line is a count to publish.
            for line in lines {
                let count: u64 = line.parse().unwrap();
                let values = std::array::from_fn(|i| count as f64 + i as f64);
                writer.send_copy(State { count, values }).unwrap();
                println!("sent");
            }
        }
        "write-bytes" => {
            let port = node.service_builder(&name).publish_subscribe::<[u8]>().open().unwrap();
            let writer = port.publisher_builder().initial_max_slice_len(64).create().unwrap();
            println!("ready");
            // Each input line is a sample, as decimal bytes.
            for line in lines {
                let bytes: Vec<u8> = line.split(' ').map(|byte| byte.parse().unwrap()).collect();
                let sample = writer.loan_slice_uninit(bytes.len()).unwrap();
                sample.write_from_slice(&bytes).send().unwrap();
                println!("sent");
            }
        }
        "wrong" => {
            let port = node.service_builder(&name).publish_subscribe::<u64>().open();
            println!("{:?}", port.err().unwrap());
        }
        other => println!("no role {other}"),
    }
}
