//! `host-sim link PORT …`.

mod check;
mod page;
mod show;
mod sweep;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Subcommand;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serialport::SerialPort;
use shared::control::{self, Mode, State};
use shared::link::{Hello, LinkAct, RATES};
use shared::settings::{Settings, TICK_RATE_HZ};

use super::arguments::output::Format;
use super::interrupt;
use super::terminal::{print, say};
use crate::link::by_hand;
use crate::link::client::{self, Client};
use crate::link::clock::Clock;
use crate::link::recording;
use check::check;
use files::UserError;
use files::made_from::MadeFrom;
use files::read_text;
use files::rigfile;
use files::settings_file;
use numerics::NamedRig;
use show::line;
use sweep::{Sweep, sweep};

type Port = Client<Box<dyn SerialPort>>;

/// Time between two messages to the board while in command; without them its link timeout trips.
const PACE: Duration = Duration::from_millis(200);

/// Talk to a board over its serial port: status, start, stop, settings, recording, a sweep by hand
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  host-sim link /dev/ttyACM0 status\n  host-sim link /dev/ttyACM0 --page\n  host-sim link /dev/ttyACM0 sweep --from-hz 3 --to-hz 4 --step-hz 0.1 --csv curve.csv"
)]
pub struct Args {
    /// The serial port, or an emulated board's pseudo-terminal: /dev/ttyACM0, COM3, /dev/pts/4
    #[arg(value_name = "PORT")]
    port: String,

    /// Bits per second [default: 2250000, or if nothing answers 921600; a pseudo-terminal does not care]
    #[arg(long, value_name = "N")]
    baud: Option<u32>,

    /// Show the board in a browser, until interrupted: one page commands, others watch
    #[arg(long)]
    page: bool,

    /// With --page: port of this machine's loopback to serve at [default: any that is free]
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        hide_default_value = true,
        requires = "page"
    )]
    page_port: u16,

    /// With --page: print the address only; open no browser
    #[arg(long, requires = "page")]
    no_open: bool,

    /// With --page: serve this file in place of the page in the program
    #[arg(long, value_name = "FILE", hide = true, requires = "page")]
    page_file: Option<PathBuf>,

    #[command(subcommand)]
    what: Option<What>,

    /// What is asked for, as answers and recordings carry it.
    #[arg(skip)]
    pub made_from: MadeFrom,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Print the controller's state
    Status {
        /// Form of the answer
        #[arg(long, value_parser = text_or_json(), default_value = "text")]
        format: Format,
    },
    /// Start: find the operating frequency and hold it; or steer by hand
    Start(Start),
    /// Lower the amplitude and go to Idle
    Stop,
    /// Clear the fault after its cause is gone
    ClearFault(Session),
    /// Confirm that the older copy of the settings is this rig's, after the newest was found damaged
    Confirm(Session),
    /// Print the settings as a TOML file
    Get,
    /// Send settings; in Idle the board checks them as a whole, uses them and stores them
    Set(Set),
    /// Set the processor's brown-out reset to the level that its clock needs, once per board; without it the board drives
    /// nothing
    SetBrownOut(SetBrownOut),
    /// Print the controller's forecast over frequency
    Forecast {
        /// Form of the answer
        #[arg(long, value_enum, default_value = "text")]
        format: Format,
    },
    /// Record every tick into a Parquet log that `host-sim replay` reads
    Record(Recording),
    /// Measure the force curve by hand; its CSV is what `host-sim sweep --measured` reads
    Sweep(Sweep),
    /// Print a line of status at regular intervals
    Monitor {
        /// Duration, s of the controller's time [default: until interrupted]
        #[arg(long = "for", value_name = "S")]
        duration_s: Option<f64>,
        /// Lines per second
        #[arg(long, value_name = "HZ", default_value_t = 2.0)]
        rate: f64,
    },
}

/// For whatever steers.
#[derive(Clone, Copy, Debug, clap::Args)]
struct Session {
    /// Take over the session of another program, which can then no longer steer
    #[arg(long)]
    take_over: bool,
}

#[derive(Debug, clap::Args)]
struct Start {
    /// Steer by hand: this program stays in command, and when it ends, the board's link timeout trips
    #[arg(long)]
    manual: bool,
    /// Drive frequency by hand, Hz [default: where the controller starts]
    #[arg(long, value_name = "HZ", requires = "manual")]
    frequency: Option<f64>,
    /// Cart amplitude by hand, mm [default: the rig's]
    #[arg(long, value_name = "MM", requires = "manual")]
    amplitude: Option<f64>,
    /// Stop after this time, s of the controller's time [default: until interrupted]
    #[arg(long = "for", value_name = "S", requires = "manual")]
    duration_s: Option<f64>,
    #[command(flatten)]
    session: Session,
}

#[derive(Debug, clap::Args)]
struct SetBrownOut {
    /// Yes, write the processor's option bytes; the board keeps its power meanwhile
    #[arg(long)]
    yes: bool,
    #[command(flatten)]
    session: Session,
}

#[derive(Debug, clap::Args)]
struct Set {
    #[command(flatten)]
    new: NewSettings,
    #[command(flatten)]
    session: Session,
}

#[derive(Debug, clap::Args)]
#[group(required = true, multiple = true)]
struct NewSettings {
    /// Settings to change, as `get` prints them
    #[arg(value_name = "FILE.toml")]
    file: Option<PathBuf>,
    /// Begin from the usual settings of this rig, not from the board's present ones
    #[arg(long, value_name = "NAME|FILE.toml")]
    rig: Option<String>,
}

#[derive(Debug, clap::Args)]
struct Recording {
    /// File to write; an existing one is not replaced
    #[arg(value_name = "OUT.parquet")]
    out: PathBuf,
    /// Duration, s of the controller's time
    #[arg(long = "for", value_name = "S", default_value_t = 60.0)]
    duration_s: f64,
    /// Start the controller after the recording has begun, and stop it at the end, also after an interruption
    #[arg(long)]
    start: bool,
    #[command(flatten)]
    session: Session,
}

/// A status has no form as a table.
fn text_or_json() -> impl TypedValueParser<Value = Format> {
    PossibleValuesParser::new(["text", "json"]).map(|word| match word.as_str() {
        "json" => Format::Json,
        _ => Format::Text,
    })
}

pub fn run(args: &Args) -> Result<i32, UserError> {
    let what = match &args.what {
        Some(what) if !args.page => what,
        None if args.page => return page::run(args),
        Some(_) => {
            return Err(UserError::new(
                "--page and a command do not go together; leave one of them out",
            ));
        }
        None => {
            return Err(UserError::new(format!(
                "no command is given; for example `host-sim link {0} status`, or `host-sim link {0} --page`; see --help",
                args.port
            )));
        }
    };
    check(what)?;
    if matches!(what, What::Stop) && client::stop_beside_another(&args.port)? {
        print(
            "sent; another program uses the port and gets the answer, so watch whether the drive stops\n",
        );
        return Ok(0);
    }
    let opened = client::open(&args.port, args.baud)?;
    say_the_rate(args, opened.baud);
    let (mut port, hello) = (opened.client, opened.hello);
    let port = &mut port;
    let done = match what {
        What::Status { format } => show::status(port, &hello, *format, &args.made_from),
        What::Start(start) => in_session(port, start.session, |port| {
            if start.manual {
                steer(port, start)
            } else {
                start_automatic(port)
            }
        }),
        What::Stop => command(port, control::Command::Stop),
        What::ClearFault(session) => in_session(port, *session, |port| {
            command(port, control::Command::ClearFault)
        }),
        What::Confirm(session) => in_session(port, *session, |port| {
            port.command(control::Command::ConfirmSettings)?;
            print("the older copy of the settings is confirmed and stored; clear the fault now\n");
            Ok(())
        }),
        What::Get => port
            .settings()
            .map(|settings| print(&settings_file::to_toml(&settings))),
        What::Set(set) => in_session(port, set.session, |port| {
            send_settings(port, &hello, &set.new)
        }),
        What::SetBrownOut(set) => in_session(port, set.session, |port| {
            port.steer(LinkAct::SetBrownOut)?;
            print(
                "the brown-out reset is set; unplug the board, wait a second, and plug it in again\n",
            );
            Ok(())
        }),
        What::Forecast { format } => show::forecast(port, &hello, *format, &args.made_from),
        What::Record(recording) => {
            return in_session(port, recording.session, |port| {
                record(port, &hello, recording, &args.made_from)
            });
        }
        What::Sweep(plan) => {
            return in_session(port, plan.session, |port| {
                sweep(port, &hello, plan, &args.made_from)
            });
        }
        What::Monitor { duration_s, rate } => show::monitor(port, *duration_s, *rate),
    };
    done.map(|()| 0)
}

/// Says so if the board answers only at the slower rate.
fn say_the_rate(args: &Args, baud: u32) {
    let [usual, slower] = RATES;
    if args.baud.is_none() && baud == slower {
        say(&format!(
            "{}: no answer at {usual} Bd, so {slower} Bd, too slow to record every tick (`--baud {slower}` avoids this wait)",
            args.port
        ));
    }
}

/// Does `work` in a session, which ends with it, however that ends.
fn in_session<T>(
    port: &mut Port,
    session: Session,
    work: impl FnOnce(&mut Port) -> Result<T, UserError>,
) -> Result<T, UserError> {
    port.open_session(session.take_over)?;
    let done = work(port);
    // Another program may have taken it over, or the board is gone: that has been said, or does not matter.
    let _ = port.steer(LinkAct::Release);
    done
}

/// Starts in automatic mode. If the settings ask for a heartbeat, this program stays and gives it.
fn start_automatic(port: &mut Port) -> Result<(), UserError> {
    command(port, control::Command::Start(Mode::Automatic))?;
    if !port.settings()?.operator.heartbeat {
        return Ok(());
    }
    say(
        "operator.heartbeat is set: when this program ends, the board's link timeout trips; `stop` in another window ramps down",
    );
    let mut clock = Clock::new();
    let until = Instant::now() + by_hand::START;
    loop {
        std::thread::sleep(PACE);
        port.command(control::Command::Alive)?;
        let status = port.status()?;
        print(&format!("{}\n", line(&status)));
        clock.goes_on(&status).map_err(|why| port.complaint(why))?;
        match status.state {
            State::Fault => return Err(port.complaint("a fault has switched the drive off")),
            State::Idle => return Ok(()),
            State::SelfTest | State::Prove if Instant::now() > until => {
                return Err(never_starts(port, "ramps up"));
            }
            _ => {}
        }
    }
}

fn command(port: &mut Port, command: control::Command) -> Result<(), UserError> {
    port.command(command)?;
    let status = port.status()?;
    print(&format!("{}\n", line(&status)));
    Ok(())
}

fn send_settings(port: &mut Port, hello: &Hello, set: &NewSettings) -> Result<(), UserError> {
    let mut new = match &set.rig {
        Some(name) => {
            // A file's shaker is the machine's; that of a built-in rig is assumed.
            let rig = rigfile::load(name, &[])?;
            let rig = match NamedRig::preset(name) {
                Ok(_) => rig,
                Err(_) => rig.recoiling().unwrap_or(rig),
            };
            Settings::for_rig(&rig.params).for_real()
        }
        None => port.settings()?,
    };
    if set.rig.is_some() && hello.board == "emulator" {
        // It has no button that a person could press.
        new.operator.acknowledge = false;
    }
    if let Some(path) = &set.file {
        let text = read_text(path)?;
        new = settings_file::overlay(&new, &text).map_err(|e| e.at(path.display()))?;
    }
    port.steer(LinkAct::SetSettings(new))?;
    print("the settings are in use and stored\n");
    Ok(())
}

fn record(
    port: &mut Port,
    hello: &Hello,
    recording: &Recording,
    made: &MadeFrom,
) -> Result<i32, UserError> {
    let command = recording
        .start
        .then_some(control::Command::Start(Mode::Automatic));
    let ticks = (recording.duration_s * f64::from(TICK_RATE_HZ)) as u64;
    interrupt::finish_first();
    let stop = &interrupt::interrupted;
    let (written, recorded) =
        recording::record(port, hello, &recording.out, made, ticks, command, stop)?;
    say(&format!("wrote {}", written.display()));
    if recorded >= ticks {
        return Ok(0);
    }
    say(&format!("interrupted after {recorded} of {ticks} ticks"));
    Ok(interrupt::CODE)
}

/// The complaint that the controller does not do `what` in time.
fn never_starts(port: &Port, what: &str) -> UserError {
    port.complaint(format!(
        "the controller never {what}, after {} s; reset the board",
        by_hand::START.as_secs()
    ))
}

/// Steers by hand until the time is over.
fn steer(port: &mut Port, start: &Start) -> Result<(), UserError> {
    let amplitude_m = match start.amplitude {
        Some(mm) => 1e-3 * mm,
        None => port.settings()?.rig.amplitude_m,
    };
    port.command(control::Command::Start(Mode::Manual))?;
    let mut set = start.frequency.is_none() && start.amplitude.is_none();
    let mut begun = None;
    let until = Instant::now() + by_hand::START;
    let end = start.duration_s.map(|s| until + by_hand::at_most(s));
    let mut clock = Clock::new();
    loop {
        port.command(control::Command::Alive)?;
        let status = port.status()?;
        print(&format!("{}\n", line(&status)));
        clock.goes_on(&status).map_err(|why| port.complaint(why))?;
        match status.state {
            State::Manual => {
                let begun = *begun.get_or_insert(status.tick);
                let passed = f64::from(status.tick.wrapping_sub(begun)) / f64::from(TICK_RATE_HZ);
                if start.duration_s.is_some_and(|limit_s| passed >= limit_s) {
                    return command(port, control::Command::Stop);
                }
                if !set {
                    set = true;
                    let frequency_hz = start.frequency.map_or(status.frequency_hz, |hz| hz as f32);
                    let amplitude_m = amplitude_m as f32;
                    port.command(control::Command::SetPoint {
                        frequency_hz,
                        amplitude_m,
                    })?;
                }
            }
            State::Fault => return Err(port.complaint("a fault has switched the drive off")),
            _ if begun.is_some() => {
                return Err(port.complaint("somebody else has stopped the drive"));
            }
            _ if Instant::now() > until => {
                return Err(never_starts(port, "reaches manual mode"));
            }
            _ => {}
        }
        if end.is_some_and(|end| Instant::now() > end) {
            return Err(port.complaint("the controller's time does not pass; reset the board"));
        }
        std::thread::sleep(PACE);
    }
}
