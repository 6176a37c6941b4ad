//! `genomctl bag`: makes a bag of ROS 2 of a recording.

use std::io::Write as _;
use std::path::PathBuf;

use genom_recording::{BagError, Recording, write_bag};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// Make a bag of ROS 2 of a recording, for `ros2 bag play` and other tools.
///
/// The bag is a directory with the samples of ports under their topics. Calls and activities, which
/// a bag cannot have, are left out. Nodes that read it need the messages of the component: see
/// `genomctl ros2-package`. `genomctl replay` plays bags, too.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// An MCAP file of `genomctl record`, of the black box or of the web console.
    file: PathBuf,
    /// The directory to make.
    #[arg(long, short, value_name = "DIRECTORY")]
    output: PathBuf,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let failed = |why: BagError| match why {
        BagError::There(_) => Failure::usage(why.to_string(), "name another directory"),
        BagError::Write { .. } => Failure::refused("file", why.to_string()),
        why => Failure::file(&args.file, why),
    };
    let recording = Recording::open(&args.file).map_err(BagError::from);
    let mut recording = recording.map_err(failed)?;
    let bagged = write_bag("genomctl", &mut recording, &args.output).map_err(failed)?;
    for topic in &bagged.left_out {
        let _ = writeln!(std::io::stderr().lock(), "left out: {topic}, which is no topic of ROS");
    }
    let topics = bagged.topics.iter();
    let topics: Vec<Value> = topics
        .map(|topic| json!({"topic": topic.name, "type": topic.ty, "messages": topic.messages}))
        .collect();
    let reply = json!({"bag": args.output, "topics": topics, "left_out": bagged.left_out});
    session.show_own(&reply, || {
        let rows = bagged.topics.iter();
        let rows = rows
            .map(|topic| vec![topic.name.clone(), topic.ty.clone(), topic.messages.to_string()]);
        Table { header: vec!["TOPIC", "TYPE", "MESSAGES"], rows: rows.collect() }
    })
}
