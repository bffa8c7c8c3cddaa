//! Runs the board's image in the model.

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;

use board::rig::{Rig, Wire, wired};
use emulator::log::Reader;
use emulator::scenario::load;
use host_sim::link::client::Client;
use host_sim::link::recording::record;
use host_sim::progress::Progress;
use host_sim::replay::replay;
use shared::control::{Command, Mode};
use shared::link::Act;

fn main() {
    let path = PathBuf::from(std::env::args().nth(1).expect("path"));
    let seconds: f64 = std::env::args().nth(2).map_or(2.0, |s| s.parse().unwrap());
    let scenario = load("field").unwrap();
    let rig = Rig::power_up(&path, &scenario, wired()).unwrap();
    let rig = Rc::new(RefCell::new(rig));
    let t = std::time::Instant::now();
    let run = || -> Result<(), Box<dyn std::error::Error>> {
        rig.borrow_mut().advance(100_000)?;
        let mut client = Client::new(Wire(rig.clone()), "the board");
        let hello = client.hello()?;
        println!("{hello:?}");
        client.open_session(false)?;
        client.steer(Act::SetSettings(scenario.settings))?;
        client.command(Command::ClearFault)?;
        let log = std::env::temp_dir().join("board-log");
        let log = record(
            &mut client,
            &hello,
            &log,
            (seconds * 20_000.0) as u64,
            Some(Command::Start(Mode::Automatic)),
        )?;
        println!("{:?}", client.status()?);
        let mut reader = Reader::open(&log)?;
        println!("{:?}", replay(&mut reader, &Progress::new("", 1, true))?);
        Ok(())
    };
    if let Err(e) = run() {
        println!("{e}");
    }
    let m = &rig.borrow().machine;
    let e = t.elapsed().as_secs_f64();
    println!(
        "{} ms, {} instr, {:.1} M/s, {} ticks",
        m.now / 720_000,
        m.instructions,
        m.instructions as f64 / e / 1e6,
        m.ticks
    );
    for (i, n) in m.entered.iter().enumerate().filter(|x| *x.1 > 0) {
        println!("exception {i}: {n}");
    }
}
