//! The control task: a block of samples in, a block of set-points out.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::DWT;
use rtic::Mutex;
use shared::{
    control::Unfit,
    fault::FaultRecord,
    io::{Frame, Output},
    settings::Interlock as Wired,
};

use super::{blocks, drive, report, retained};
use crate::{
    BLOCK_TICKS, bench::Bench, hardware::board, interlock::InterlockInputs,
    record_keeper::RecordKeeper, recorder::ControlRecorder,
};

/// Processor cycles of the last block and of the longest since they were last taken.
static CYCLES: [AtomicU32; 2] = [AtomicU32::new(0), AtomicU32::new(0)];

/// Cycles of the last block, and of the longest since the last call.
pub fn take_cycles() -> [u32; 2] {
    let [last, longest] = &CYCLES;
    [
        last.load(Ordering::Relaxed),
        longest.swap(0, Ordering::Relaxed),
    ]
}

/// What the task owns.
pub struct Control {
    sampler: board::AdcSampler,
    set_points: board::SetPoints,
    chain: board::ChainPin,
    enable: Option<drive::Enable>,
    bench: Option<Bench>,
    outputs: [Output; BLOCK_TICKS],
    keeper: RecordKeeper,
    reports: board::Reports,
    interlock: InterlockInputs,
    /// Which of the reports the rig has.
    wired: Wired,
}

impl Control {
    /// At rest; without the `enable`'s pin, nothing is ever driven. `kept`: the record in the memory that outlives a reset.
    pub(super) fn new(
        (sampler, set_points): (board::AdcSampler, board::SetPoints),
        (chain, reports): (board::ChainPin, board::Reports),
        enable: Option<board::EnablePin>,
        bench: Option<Bench>,
        kept: Option<FaultRecord>,
    ) -> Self {
        Self {
            sampler,
            set_points,
            chain,
            enable: enable.map(drive::Enable::new),
            bench,
            outputs: [Output::SAFE; BLOCK_TICKS],
            keeper: RecordKeeper::new(kept),
            reports,
            interlock: InterlockInputs::default(),
            wired: Wired {
                relay: false,
                ready: false,
            },
        }
    }

    /// Samples and plays from now on.
    pub(super) fn begin(&mut self) {
        self.sampler.start();
    }

    /// A block: what was sampled in the last 10 ticks in, the set-points of the 10 after the next out.
    ///
    /// Deadline: the set-points 491 µs after the interrupt, when the DMA fetches the first of them; the rest 500 µs, when
    /// the next block is complete. A block that ends later has overrun: what it writes late is played half old, half new,
    /// the next block starts at once, and the overrun is reported to the controller; more than one in five and it trips. If
    /// two blocks were due, the older is lost. If none is served for 2 to 3 ms, the guard takes the enable away.
    #[inline]
    pub fn block(&mut self, shared: &mut impl Mutex<T = ControlRecorder>) {
        let began = DWT::cycle_count();
        let outputs: &mut [Output; BLOCK_TICKS] = &mut self.outputs;
        let arrived = self.sampler.arrived();
        let enabled = drive::is_driving();
        let against = self
            .interlock
            .contradicts(enabled, self.reports.read(), self.wired);
        let open = self.chain.is_open();
        drive::note_chain(open);
        let tripped = open || drive::is_taken_away() || (against && self.enable.is_some());
        if self.sampler.reference_is_lost() && enabled {
            report::unfit(Unfit::REFERENCE);
        }
        let mut frames = [Frame::default(); BLOCK_TICKS];
        match &mut self.bench {
            Some(bench) => bench.block(outputs, &mut frames),
            None => frames = self.sampler.take(arrived.half, tripped),
        }
        let stale =
            blocks::take_stale() || blocks::others_are_late() || arrived.failed || !arrived.any;
        let late = arrived.lost && !blocks::is_paused();
        let wired = &mut self.wired;
        let record = shared.lock(|recorder| {
            if late {
                recorder.note_overrun();
            }
            recorder.block((!stale).then_some(&frames), outputs);
            *wired = recorder.controller().settings().interlock;
            recorder.controller().fault().copied()
        });
        let in_time = if arrived.any {
            self.set_points.play(arrived.half, outputs) || blocks::is_paused()
        } else {
            // Whichever of them is played: nothing tells.
            for half in blocks::HALVES {
                self.set_points.play(half, outputs);
            }
            true
        };
        if let Some(enable) = &mut self.enable {
            let on = outputs.iter().all(|output| output.enable);
            if on && board::supply_is_low() {
                report::unfit(Unfit::SUPPLY);
            }
            enable.apply(on, tripped);
        }
        // The drive is off; a reset from here on finds the fault.
        self.keeper.after_block(record.as_ref(), retained::keep);
        if arrived.any {
            blocks::served_one();
        }

        let cycles = DWT::cycle_count().wrapping_sub(began);
        let [last, longest] = &CYCLES;
        last.store(cycles, Ordering::Relaxed);
        longest.fetch_max(cycles, Ordering::Relaxed);
        if self.sampler.overrun() || !in_time {
            shared.lock(ControlRecorder::note_overrun);
        }
    }
}
