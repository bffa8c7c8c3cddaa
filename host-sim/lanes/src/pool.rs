//! The loop: every iteration moves each lane by one step of flight and, if it met the surface, through the contact. A
//! lane whose cell is done takes the next one.

mod long;

use std::f64::consts::TAU;
use std::mem;

use super::flight::{FlightLanes, HammerLanes, path};
use super::job::{Job, Tuning, Work};
use super::meet::meet;
use super::number::{Mask, Num};
use super::reduce::{StrobeRecord, converged, outcome};
use super::ring::flight_with_ring;
use super::rows::Rows;
use super::series::{horner, sin_cos};
use super::sustained::Sustained;
use super::touch::{Anchor, HeldCart, SurfaceLanes, contact};
use super::width::{LaneNumbers, LaneWidth, MAX_LANES};
use super::{CellOutcome, CellPlan};

/// What a lane holds beside its rows.
#[derive(Default)]
struct Lane {
    job: Option<usize>,
    /// The sustained contact it is in, if any; its row then stands still.
    sustained: Option<Sustained>,
    /// In contact at the last section.
    carried: bool,
    chatter: bool,
    /// Whether the first section is still to come (a start at another phase).
    before_first: bool,
    records: Vec<StrobeRecord>,
}

/// The numbers of the bits that are set.
#[inline(always)]
fn each(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros();
        bits &= bits.wrapping_sub(1);
        (lane < u32::BITS).then_some(lane as usize)
    })
}

/// The lanes of one thread.
struct Pool<'a, W: LaneWidth> {
    w: W,
    jobs: &'a [Job],
    next: usize,
    plan: &'a CellPlan,
    tuning: Tuning,
    rows: Box<Rows>,
    lanes: Vec<Lane>,
    out: Vec<Option<CellOutcome>>,
    /// Whether contacts have no closed form.
    by_law: bool,
    /// Lanes in a sustained contact, by bit.
    in_sustained: u32,
    /// Lanes whose cell is done, by bit.
    finished: u32,
    busy: usize,
    work: Work,
}

/// Runs `jobs`, all of one kind; none where an event was uncertain. With and without a cart that recoils (`RECOIL`) it is
/// a function of its own: one that does both takes the compiler several times as long.
#[inline(always)]
pub fn run<W: LaneWidth, const RECOIL: bool>(
    w: W,
    beams: bool,
    jobs: &[Job],
    plan: &CellPlan,
    tuning: Tuning,
) -> (Vec<Option<CellOutcome>>, Work) {
    let mut pool = Pool {
        w,
        jobs,
        next: 0,
        plan,
        tuning,
        rows: Box::default(),
        lanes: (0..W::LANES).map(|_| Lane::default()).collect(),
        out: jobs.iter().map(|_| None).collect(),
        by_law: jobs.iter().any(|job| job.constants.surface.is_some()),
        in_sustained: 0,
        finished: 0,
        busy: W::LANES,
        work: Work::default(),
    };
    for lane in 0..W::LANES {
        pool.refill(lane);
    }
    while pool.busy > 0 {
        pool.work.iterations += 1;
        pool.work.room += W::LANES as u64;
        pool.work.steps += pool.busy as u64;
        pool.iterate::<RECOIL>(beams);
    }
    (pool.out, pool.work)
}

impl<W: LaneWidth> Pool<'_, W> {
    #[inline(always)]
    fn iterate<const RECOIL: bool>(&mut self, beams: bool) {
        let w = self.w;
        let load = |row: &LaneNumbers| Num::load(w, row);
        let rows = &mut *self.rows;
        let field = FlightLanes {
            rest: load(&rows.rest),
            bend: load(&rows.bend),
            spring: load(&rows.spring),
            damping: load(&rows.damping),
            per_step: load(&rows.per_step),
            push: None,
        };
        let at = HammerLanes {
            x: load(&rows.x),
            v: load(&rows.v),
            tau: load(&rows.tau),
        };
        let h = load(&rows.step);
        let turn = Num::splat(w, TAU);
        let zero = Num::splat(w, 0.0);
        let (path, h, per_step, ring) = if RECOIL {
            let ring = rows.ring.each_ref().map(load);
            let flown = flight_with_ring(
                beams,
                &rows.ringing.map(load),
                field,
                at,
                h,
                ring,
                &self.tuning,
            );
            (flown.path, flown.h, flown.per_step, Some(flown.ring))
        } else {
            (path(beams, &field, &at, h), h, field.per_step, None)
        };
        let met = meet(&path, self.tuning.margins);
        let (x, slope) = horner(&path, met.at);
        let mut v = slope * per_step;
        let mut x = met.hit.choose(zero, x);
        if let Some(ring) = ring {
            let (z, slope) = horner(&ring, met.at);
            let rate = slope * per_step;
            (x, v) = (x - z, v - rate);
            z.store(&mut rows.ring[0]);
            rate.store(&mut rows.ring[1]);
        }
        let tau = met.at.mul_add(h, at.tau);
        let strobe = !tau.lt(turn);
        let strobes = if strobe.any() {
            let when = (turn - at.tau) * per_step;
            let (x, slope) = horner(&path, when);
            Some((strobe, x, slope * per_step))
        } else {
            None
        };
        x.store(&mut rows.x);
        v.store(&mut rows.v);
        tau.store(&mut rows.tau);
        if let Some((strobe, x, v)) = strobes {
            self.section(strobe, x, v);
        }
        let mut uncertain = met.uncertain;
        if met.hit.any() {
            uncertain = uncertain | self.touch::<RECOIL>(met.hit);
        }
        if uncertain.any() {
            for lane in each(uncertain.bits()) {
                self.give_up(lane);
            }
        }
        for lane in each(self.in_sustained & !self.finished) {
            self.run_sustained(lane);
        }
        for lane in each(mem::take(&mut self.finished)) {
            self.refill(lane);
        }
    }

    /// Lanes that passed the section: their records, and their clocks put back.
    #[inline(always)]
    fn section(&mut self, strobe: Mask<W>, x: Num<W>, v: Num<W>) {
        let w = self.w;
        let rows = &*self.rows;
        let load = |row: &LaneNumbers| Num::load(w, row);
        let from_rest = x + load(&rows.rest);
        let swing2 = from_rest.mul_add(from_rest, v * v * load(&rows.soft));
        let tame = swing2.lt(load(&rows.widest2));
        let (mut xs, mut vs) = ([0.0; MAX_LANES], [0.0; MAX_LANES]);
        x.store(&mut xs);
        v.store(&mut vs);
        for lane in each((strobe & tame).bits()) {
            let onsets = self.rows.onsets[lane];
            let held = &mut self.lanes[lane];
            let record = StrobeRecord {
                x: xs[lane],
                v: vs[lane],
                force: self.rows.peak[lane] as f32,
                onsets: onsets as u16,
                touched: onsets > 0.0 || mem::take(&mut held.carried),
                chatter: mem::take(&mut held.chatter),
            };
            held.carried = false;
            self.record(lane, record);
        }
        let wild = strobe & !tame;
        if wild.any() {
            for lane in each(wild.bits()) {
                self.give_up(lane);
            }
        }
        let zero = Num::splat(w, 0.0);
        let back = strobe.choose(Num::splat(w, TAU), zero);
        let rows = &mut *self.rows;
        for row in [&mut rows.tau].into_iter().chain(&mut rows.recent) {
            (Num::load(w, row) - back).store(row);
        }
        for row in [&mut rows.peak, &mut rows.onsets] {
            strobe.choose(zero, Num::load(w, row)).store(row);
        }
    }

    /// Takes lanes that met the surface through the contact. Returns those in which it was uncertain.
    #[inline(always)]
    fn touch<const RECOIL: bool>(&mut self, hit: Mask<W>) -> Mask<W> {
        self.work.contact_rounds += 1;
        let w = self.w;
        let load = |row: &LaneNumbers| Num::load(w, row);
        let rows = &mut *self.rows;
        let anchor = |rows: &[LaneNumbers; 3]| Anchor {
            phase: load(&rows[0]),
            cos: load(&rows[1]),
            sin: load(&rows[2]),
        };
        let (tau, mut v) = (load(&rows.tau), load(&rows.v));
        let mut cart = None;
        if RECOIL {
            let joint = rows.joint.map(load);
            let ring = rows.ring.each_ref().map(load);
            let y = load(&rows.x) + load(&rows.rest);
            let there = joint.cart([y, v], ring, sin_cos(tau));
            v = v + ring[1];
            for (row, value) in rows.cart.iter_mut().zip(there) {
                value.store(row);
            }
            cart = Some(HeldCart { joint, at: there });
        }
        let surface = SurfaceLanes {
            drive: load(&rows.drive),
            pull: load(&rows.pull),
            damping: load(&rows.damping),
            spring: load(&rows.contact_spring),
            damper: load(&rows.contact_damper),
            decay: load(&rows.decay),
            pulsation: load(&rows.pulsation),
            short: load(&rows.short),
            rho: load(&rows.rho),
            forced_sin: load(&rows.forced_sin),
            forced_cos: load(&rows.forced_cos),
            forced_mean: load(&rows.forced_mean),
            release: anchor(&rows.release),
            peak: anchor(&rows.top),
            cart,
        };
        let left = contact(&surface, tau, v, self.tuning.margins.grazing);
        let none = hit & !hit;
        let closed = hit & left.good & left.tau.lt(Num::splat(w, TAU));
        let good = if self.by_law { none } else { closed };
        let one = Num::splat(w, 1.0);
        let onsets = load(&rows.onsets);
        good.choose(onsets + one, onsets).store(&mut rows.onsets);
        let recent = rows.recent.each_ref().map(load);
        good.choose(recent[1], recent[2]).store(&mut rows.recent[2]);
        good.choose(recent[0], recent[1]).store(&mut rows.recent[1]);
        good.choose(tau, recent[0]).store(&mut rows.recent[0]);
        let peak = load(&rows.peak);
        good.choose(peak.max(left.force), peak)
            .store(&mut rows.peak);
        good.choose(left.tau, tau).store(&mut rows.tau);
        match surface.cart {
            None => good.choose(left.v, v).store(&mut rows.v),
            Some(HeldCart { joint, .. }) => {
                let phase = sin_cos(left.tau);
                let ring = joint.ring([load(&rows.rest), left.v], left.cart, phase);
                let now = [-ring[0], left.v - ring[1], ring[0], ring[1]];
                let [z, w] = &mut rows.ring;
                for (row, value) in [&mut rows.x, &mut rows.v, z, w].into_iter().zip(now) {
                    good.choose(value, load(row)).store(row);
                }
            }
        }
        self.work.contacts += u64::from(good.bits().count_ones());
        let slow = hit & !good;
        if slow.any() {
            for lane in each(slow.bits() & !self.finished) {
                self.enter(lane);
            }
        }
        hit & left.grazing
    }

    /// Leaves a lane's cell without an outcome.
    #[inline(never)]
    fn give_up(&mut self, lane: usize) {
        if self.lanes[lane].job.is_some() {
            self.finished |= 1 << lane;
            self.lanes[lane].records.clear();
        }
    }

    /// A strobe of a lane; ends its cell where that was the last, or where it has converged.
    #[inline(always)]
    fn record(&mut self, lane: usize, mut record: StrobeRecord) {
        let held = &mut self.lanes[lane];
        let Some(job) = held.job else {
            return;
        };
        if held.before_first {
            held.before_first = false;
            record = StrobeRecord {
                x: record.x,
                v: record.v,
                ..StrobeRecord::default()
            };
            held.records.push(record);
            return;
        }
        held.records.push(record);
        let cycles = held.records.len() - 1;
        self.work.cycles += 1;
        let last = cycles >= self.plan.cycles as usize;
        let test = self.plan.early && !last;
        let settled = test
            .then(|| converged(&held.records, self.tuning.grain))
            .flatten();
        if last || settled.is_some() {
            let constants = &self.jobs[job].constants;
            self.out[job] = Some(outcome(constants, &held.records, self.plan, settled));
            self.finished |= 1 << lane;
        }
    }

    /// Puts the next cell into a lane; an idle one rests.
    #[inline(never)]
    fn refill(&mut self, lane: usize) {
        let rows = &mut *self.rows;
        let held = &mut self.lanes[lane];
        self.in_sustained &= !(1 << lane);
        held.sustained = None;
        held.chatter = false;
        held.carried = false;
        held.records.clear();
        let Some(job) = self.jobs.get(self.next) else {
            held.job = None;
            self.busy -= 1;
            rows.stand(lane);
            return;
        };
        held.job = Some(self.next);
        self.next += 1;
        let c = &job.constants;
        held.before_first = job.tau > 0.0;
        if !held.before_first {
            held.records.push(StrobeRecord {
                x: job.x,
                v: job.v,
                ..StrobeRecord::default()
            });
        }
        rows.fill(lane, job, self.tuning.step / c.fastest);
    }
}
