//! The processor in the loop: the controller on QEMU's MPS2 AN386, against a plant on the desktop.
//!
//! The desktop writes a block of samples into a pipe and waits; here the control task runs on it, through the
//! interrupt, then so many slices of the forecast in idle, and the answer goes back through another pipe
//! ([`shared::link::in_the_loop`]). Time is what the plant says it is. `cargo xtask pil` compares all of it, bit for bit,
//! with the same run on the desktop.
#![no_main]
#![no_std]

use cortex_m_rt as _;

#[rtic::app(device = firmware::hardware::board::device, peripherals = false)]
mod app {
    use cortex_m::peripheral::SCB;
    use cortex_m_semihosting::hprintln;
    use firmware::hardware::{
        board::{self, SysTickStopwatch, pipes::Pipes},
        stack,
    };
    use heapless::Vec;
    use shared::{
        control::{Lockstep, MAX_BLOCK},
        io::{Frame, Output},
        link::in_the_loop::{
            ExchangeReply, ExchangeRequest, LENGTH, MAX_EVENTS, MAX_MESSAGE, encode,
        },
    };

    /// Input and output of the control task.
    pub struct PilBlock {
        frames: Vec<Frame, MAX_BLOCK>,
        blind: bool,
        outputs: Vec<Output, MAX_BLOCK>,
        delivered: bool,
        counts: u32,
    }

    #[shared]
    struct Shared {
        lockstep: Option<Lockstep>,
        block: PilBlock,
    }

    #[local]
    struct Local {
        stopwatch: SysTickStopwatch,
    }

    #[init]
    fn init(context: init::Context) -> (Shared, Local) {
        let block = PilBlock {
            frames: Vec::new(),
            blind: false,
            outputs: Vec::new(),
            delivered: false,
            counts: 0,
        };
        let shared = Shared {
            lockstep: None,
            block,
        };
        let local = Local {
            stopwatch: SysTickStopwatch::start(context.core.SYST),
        };
        (shared, local)
    }

    /// Passes messages on, and ends the run with success if it was ended by the other side.
    #[idle(shared = [lockstep, block])]
    fn idle(mut context: idle::Context) -> ! {
        let Some(mut pipes) = Pipes::open() else {
            hprintln!("the two pipes cannot be opened");
            board::exit(false);
        };
        let mut buffer = [0; LENGTH + MAX_MESSAGE];
        loop {
            let reply = match pipes.receive::<ExchangeRequest>() {
                None => {
                    hprintln!("the plant has closed its pipe: the run is incomplete");
                    board::exit(false);
                }
                Some(ExchangeRequest::End) => {
                    hprintln!("stack {} of {}", stack::peak(), stack::reserved());
                    board::exit(true);
                }
                Some(ExchangeRequest::Begin { settings, boot }) => {
                    context.shared.lockstep.lock(|slot| {
                        *slot = Lockstep::new(&settings, &boot).ok();
                        ExchangeReply::Begun(slot.is_some())
                    })
                }
                Some(ExchangeRequest::Command(command)) => context.shared.lockstep.lock(|slot| {
                    slot.as_mut().map_or(ExchangeReply::Noted, |lockstep| {
                        ExchangeReply::Command(lockstep.controller.command(command))
                    })
                }),
                Some(ExchangeRequest::Overrun) => context.shared.lockstep.lock(|slot| {
                    if let Some(lockstep) = slot {
                        lockstep.controller.note_overrun();
                    }
                    ExchangeReply::Noted
                }),
                Some(ExchangeRequest::Block {
                    frames,
                    blind,
                    slices,
                }) => {
                    context.shared.block.lock(|block| {
                        block.frames = frames;
                        block.blind = blind;
                    });
                    // The control task runs now, and is done before the next line.
                    SCB::set_pendst();
                    cortex_m::asm::isb();
                    let block = &mut context.shared.block;
                    (&mut context.shared.lockstep, block)
                        .lock(|slot, block| answer(slot, block, slices))
                }
            };
            let sent = encode(&reply, &mut buffer).and_then(|bytes| pipes.send(bytes));
            if sent.is_none() {
                hprintln!("a reply could not be sent");
                board::exit(false);
            }
        }
    }

    /// The slices of the forecast, and the reply.
    fn answer(slot: &mut Option<Lockstep>, block: &mut PilBlock, slices: u16) -> ExchangeReply {
        let Some(lockstep) = slot else {
            return ExchangeReply::Noted;
        };
        lockstep.idle(u32::from(slices));
        let mut events = Vec::new();
        while !events.is_full() {
            let Some(event) = lockstep.controller.take_event() else {
                break;
            };
            let _ = events.push(event);
        }
        const { assert!(MAX_EVENTS > 0) };
        ExchangeReply::Block {
            outputs: block.outputs.clone(),
            status: lockstep.controller.status(),
            events,
            delivered: block.delivered,
            instructions: block.counts * board::NANOSECONDS,
        }
    }

    /// A block. Deadline: none, time waits for it here.
    #[task(binds = SysTick, priority = 2, shared = [lockstep, block], local = [stopwatch])]
    fn control(context: control::Context) {
        let stopwatch: &SysTickStopwatch = context.local.stopwatch;
        (context.shared.lockstep, context.shared.block).lock(|slot, block| {
            let Some(lockstep) = slot else {
                return;
            };
            let began = stopwatch.now();
            block.outputs.clear();
            // As many as there are frames, which fit.
            let _ = block.outputs.resize(block.frames.len(), Output::SAFE);
            let exchanged = if block.blind {
                lockstep.blind_block(&mut block.outputs)
            } else {
                lockstep.block(&block.frames, &mut block.outputs)
            };
            block.delivered = exchanged.delivered;
            block.counts = stopwatch.since(began);
        });
    }
}
