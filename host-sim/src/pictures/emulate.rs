//! The picture of an emulated run: the controller's states and commands, and the true contact force over time.

use shared::control::State;

use emulator::names::state_name;
use emulator::record::{BlockRow, RunEvent, RunEventKind, RunObserver, TickRow, TrueContact};
use emulator::summary::cut_away_from_contacts;
use plot::{Axis, Color, Figure, Item, Panel, Point, Shape, Stroke};

/// Initial time between two points of a curve, s.
const POINT_S: f64 = 0.05;

/// Most points of a curve. At this number every other point is dropped and the time between points doubles.
const MOST_POINTS: usize = 20_000;

/// How often the largest force is shown while there is no drive, Hz.
const OFF_HZ: f64 = 4.0;

/// Most bands of states, and most marks, of a panel. A run with more shows as many, evenly over it; faults are all shown.
const MOST_BANDS: usize = 600;
const MOST_MARKS: usize = 60;
const MOST_FAULTS: usize = 200;

/// Most marks with a name; more names would overlap.
const NAMED_MARKS: usize = 8;

/// The curves of a run: an [`RunObserver`] that keeps a few thousand points.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// When the controller came into a state, s, and which.
    states: Vec<(f64, State)>,
    /// Drive frequency while the drive is on, Hz.
    frequency: Vec<Point>,
    /// The forecast's target, Hz.
    target: Vec<Point>,
    /// Commanded and measured cart amplitude, mm.
    commanded: Vec<Point>,
    measured: Vec<Point>,
    /// Largest true contact force of each drive period, N, at the period's end.
    peaks: Vec<Point>,
    marks: Vec<(f64, String, bool)>,
    /// Drive periods since the last whole one, and the largest force since.
    period: f64,
    peak_n: f64,
    next_point_s: f64,
    /// How often every other point was dropped.
    thinned: i32,
    time_s: f64,
    on: bool,
}

impl Trace {
    /// Keeps a run of any length drawable.
    fn thin(&mut self) {
        if self.frequency.len() < MOST_POINTS {
            return;
        }
        self.thinned += 1;
        for curve in [
            &mut self.frequency,
            &mut self.target,
            &mut self.commanded,
            &mut self.measured,
        ] {
            *curve = curve.iter().step_by(2).copied().collect();
        }
    }

    /// The frequencies between which the controller searches and holds, with `optimum` and a margin, Hz; none where it
    /// never does. The ramp from rest would leave the search a flat line.
    fn searched(&self, optimum: Option<f64>) -> Option<(f64, f64)> {
        let ends = self.states.iter().skip(1).map(|(at, _)| *at);
        let spans = self.states.iter().zip(ends.chain([f64::INFINITY]));
        let searching =
            |(state, _): &(&(f64, State), f64)| matches!(state.1, State::Seek | State::Hold);
        let spans: Vec<_> = spans
            .filter(searching)
            .map(|((from, _), to)| *from..to)
            .collect();
        let within = |(t, _): &&Point| spans.iter().any(|span| span.contains(t));
        let seen = self.frequency.iter().filter(within).map(|(_, hz)| *hz);
        let seen = seen.chain(optimum).filter(|hz| hz.is_finite());
        let (low, high) = seen.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), hz| {
            (low.min(hz), high.max(hz))
        });
        let margin = (0.15 * (high - low)).max(0.01 * high);
        (!spans.is_empty() && low < high).then_some((low - margin, high + margin))
    }

    /// Rig time seen so far, s.
    pub fn time_s(&self) -> f64 {
        self.time_s
    }
}

impl RunObserver for Trace {
    fn tick(&mut self, row: &TickRow) {
        self.time_s = row.time_s;
        self.on = row.output.enable;
        self.peak_n = self.peak_n.max(row.true_force_n);
    }

    fn block(&mut self, row: &BlockRow) {
        let status = row.status;
        let frequency_hz = f64::from(status.frequency_hz);
        if self.states.last().map(|(_, state)| *state) != Some(status.state) {
            self.states.push((self.time_s, status.state));
        }
        let hertz = if self.on { frequency_hz } else { OFF_HZ };
        self.period += row.ticks as f64 * shared::settings::TICK_S * hertz;
        if self.period >= 1.0 {
            self.period = self.period.fract();
            // With the drive off only what still strikes is shown.
            let shown = self.on || self.peak_n > 0.0;
            let peak_n = if shown { self.peak_n } else { f64::NAN };
            self.peaks.push((self.time_s, peak_n));
            self.peak_n = 0.0;
        }
        if self.time_s < self.next_point_s {
            return;
        }
        self.thin();
        self.next_point_s = self.time_s + POINT_S * 2f64.powi(self.thinned);
        let while_on = |value: f64| if self.on { value } else { f64::NAN };
        let point = |value: f64| (self.time_s, value);
        let target_hz = f64::from(status.target_hz);
        let target_hz = if target_hz > 0.0 { target_hz } else { f64::NAN };
        self.frequency.push(point(while_on(frequency_hz)));
        self.target.push(point(target_hz));
        let millimetres = |metres: f32| while_on(f64::from(metres) * 1e3);
        self.commanded.push(point(millimetres(status.amplitude_m)));
        self.measured
            .push(point(millimetres(status.measured_amplitude_m)));
    }

    fn contact(&mut self, contact: &TrueContact) {
        // Between ticks the force is larger than at them.
        self.peak_n = self.peak_n.max(contact.peak_force_n);
        self.period = cut_away_from_contacts(self.period);
    }

    fn event(&mut self, event: &RunEvent) {
        let (text, fault) = match &event.what {
            RunEventKind::Scenario { text } => (text.clone(), false),
            RunEventKind::Fault { fault, .. } => (fault.name().to_owned(), true),
            _ => return,
        };
        self.marks.push((event.time_s, text, fault));
    }
}

/// Title, subtitle and reference lines of the picture.
#[derive(Clone, Debug, Default)]
pub struct About {
    /// Title of the picture, its bold first line.
    pub title: String,
    /// Smaller text under the title; may be empty.
    pub subtitle: String,
    /// The hammer's weight, N: forces are shown as multiples of it.
    pub weight_n: f64,
    /// Frequency and peak force in N of the true rig's optimum.
    pub optimum: Option<(f64, f64)>,
}

/// The picture: frequency, force and amplitude over time, one above the other, under the controller's state.
pub fn figure(trace: &Trace, about: &About) -> Figure {
    let end_s = trace.time_s;
    let across = |y: f64| vec![(0.0, y), (end_s, y)];
    let time = || Axis::new("time, s").fixed(0.0, end_s);
    let weight = if about.weight_n > 0.0 {
        about.weight_n
    } else {
        1.0
    };
    let optimum = |value: f64, text: String| {
        Item::curve(text, Color::INK, (Stroke::Dashed, 1.1), across(value))
    };

    let (axis, cut) = match trace.searched(about.optimum.map(|(hz, _)| hz)) {
        Some((low, high)) => (
            Axis::new("frequency, Hz").fixed(low, high),
            " (lower frequencies, on the way there, are cut off)",
        ),
        None => (Axis::new("frequency, Hz"), ""),
    };
    let mut frequency = panel(trace, time(), axis, true).titled(format!(
        "Drive frequency, and what the controller is doing{cut}"
    ));
    let mut force = panel(trace, time(), Axis::new("F/(m g)").with_zero(), false)
        .titled("Largest true contact force of each drive period over the hammer's weight");
    if let Some((hz, newtons)) = about.optimum {
        frequency = frequency.item(optimum(hz, format!("optimum of the true rig {hz:.3} Hz")));
        let ratio = newtons / weight;
        force = force.item(optimum(
            ratio,
            format!("optimum of the true rig {ratio:.1}"),
        ));
    }
    let (dotted, target) = ((Stroke::Dotted, 1.6), trace.target.clone());
    frequency = frequency
        .item(Item::curve(
            "forecast's target",
            Color::ORANGE,
            dotted,
            target,
        ))
        .item(Item::line("drive", Color::BLUE, trace.frequency.clone()));
    let ratios = trace.peaks.iter().map(|(t, n)| (*t, n / weight));
    force = force.item(Item::line("peak force", Color::BLUE, ratios.collect()));
    let amplitude = panel(trace, time(), Axis::new("amplitude, mm").with_zero(), false)
        .titled("Amplitude of the cart")
        .item(Item::dashed(
            "commanded",
            Color::ORANGE,
            trace.commanded.clone(),
        ))
        .item(Item::line("measured", Color::BLUE, trace.measured.clone()));
    Figure::new(about.title.clone())
        .subtitle(about.subtitle.clone())
        .size(1100, 980)
        .panel(frequency)
        .panel(force)
        .panel(amplitude)
}

/// A panel over time with the states as bands and the marks as lines; named in the first panel only.
fn panel(trace: &Trace, x: Axis, y: Axis, named: bool) -> Panel {
    let mut panel = Panel::new(x, y);
    let ends = trace.states.iter().skip(1).map(|(at, _)| *at);
    let ends = ends.chain([trace.time_s]);
    let mut seen = Vec::new();
    let every = trace.states.len().div_ceil(MOST_BANDS).max(1);
    for ((from, state), to) in trace.states.iter().zip(ends).step_by(every) {
        let first = !seen.contains(state);
        seen.push(*state);
        let Some(color) = state_color(*state) else {
            continue;
        };
        let label = if named && first {
            state_name(*state)
        } else {
            ""
        };
        panel = panel.item(Item::new(label, color, Shape::BandX { from: *from, to }));
    }
    let every = trace.marks.len().div_ceil(MOST_MARKS).max(1);
    let faults = trace.marks.iter().filter(|(.., fault)| *fault).count();
    for (i, (at, text, fault)) in trace.marks.iter().enumerate() {
        let matters = i <= NAMED_MARKS || *fault && faults <= MOST_FAULTS;
        if !matters && !i.is_multiple_of(every) {
            continue;
        }
        let label = match i {
            _ if !named || i > NAMED_MARKS => String::new(),
            NAMED_MARKS => format!("{} more", trace.marks.len() - i),
            _ => text.clone(),
        };
        let (color, stroke) = match fault {
            true => (Color::RED, Stroke::Solid),
            false => (Color::INK, Stroke::Dotted),
        };
        panel = panel.item(Item::new(label, color, Shape::MarkX { x: *at, stroke }));
    }
    panel
}

/// The colour of a state's band; a controller at rest has none.
fn state_color(state: State) -> Option<Color> {
    match state {
        State::Idle => None,
        State::SelfTest => Some(Color::PURPLE),
        State::Prove => Some(Color(0xF0, 0xE4, 0x42)),
        State::Ramp => Some(Color::SKY),
        State::Seek => Some(Color::ORANGE),
        State::Hold => Some(Color::GREEN),
        State::Stop => Some(Color::GREY),
        State::Fault => Some(Color::RED),
        State::Manual => Some(Color::BLUE),
    }
}

#[cfg(test)]
mod tests {
    use shared::control::{Basin, Status};
    use shared::io::{Frame, Output};
    use shared::model::regime::Regime;

    use super::*;
    use plot::render_svg;

    /// Watches `seconds` of a run: idle, a start at 1 s, a contact every half second, a fault at the end.
    fn watched(seconds: u32) -> Trace {
        let mut trace = Trace::default();
        // A block of 0.05 s, so that a long run is short to test.
        for k in 1..=seconds * 20 {
            let time_s = f64::from(k) * 0.05;
            let on = time_s > 1.0;
            let output = Output {
                enable: on,
                ..Output::SAFE
            };
            trace.tick(&TickRow {
                tick: u64::from(k) * 1000,
                time_s,
                frame: Frame::default(),
                output,
                true_force_n: 0.0,
                hammer_m: 0.0,
                cart_m: 0.0,
                powered: on,
                faulty: false,
            });
            if on && k.is_multiple_of(10) {
                trace.contact(&TrueContact {
                    peak_force_n: 96.0,
                    ..TrueContact::default()
                });
            }
            trace.block(&BlockRow {
                tick: u64::from(k) * 1000,
                ticks: 1000,
                given: &[],
                frames: &[],
                outputs: &[],
                delivered: true,
                overrun: false,
                stale: false,
                slices: 0,
                status: &status(if on { State::Hold } else { State::Idle }),
            });
        }
        trace.event(&RunEvent {
            tick: 0,
            time_s: f64::from(seconds),
            what: RunEventKind::Fault {
                fault: shared::fault::Fault::OverForce,
                origin: shared::fault::Origin::Force,
                value: 1.0,
            },
        });
        trace
    }

    fn status(state: State) -> Status {
        Status {
            tick: 0,
            state,
            fault: None,
            limits: shared::control::ActiveLimits::NONE,
            frequency_hz: 2.0,
            amplitude_m: 1e-3,
            measured_amplitude_m: 1e-3,
            lag_rad: 0.0,
            regime: Regime::None,
            peak_n: 0.0,
            impulse_n_s: 0.0,
            target_hz: 2.1,
            target_n: 0.0,
            basin: Basin::Unknown,
            reseeks: 0,
            overruns: 0,
            events_dropped: 0,
        }
    }

    #[test]
    fn every_period_shows_its_blow_and_the_picture_names_states_faults_and_units() {
        let trace = watched(20);
        assert_eq!(trace.states.len(), 2);
        let whole = trace.peaks.iter().filter(|(t, _)| *t > 2.0);
        assert!(whole.clone().count() >= 35);
        assert!(whole.clone().all(|(_, n)| *n == 96.0), "{:?}", trace.peaks);
        let about = About {
            title: "a run".into(),
            subtitle: String::new(),
            weight_n: 3.0,
            optimum: Some((2.2, 99.0)),
        };
        let svg = render_svg(&figure(&trace, &about)).unwrap();
        for text in [
            "hold",
            "over-force",
            "frequency, Hz",
            "F/(m g)",
            "amplitude, mm",
            "optimum of the true rig 2.200 Hz",
            "optimum of the true rig 33.0",
        ] {
            assert!(svg.contains(text), "{text}");
        }
    }

    #[test]
    fn a_long_run_stays_drawable() {
        let trace = watched(5000);
        assert!(trace.frequency.len() <= MOST_POINTS);
        let last = trace.frequency.last().unwrap();
        assert!(last.0 > 4999.0, "{last:?}");
        assert!(trace.frequency.windows(2).all(|w| w[0].0 < w[1].0));
    }
}
