//! Whether the watchdog may be fed: only if every task has run since the last time.

/// The idle loop must have run within this many steps of 10 ms: link and control may delay it, but not for
/// longer.
const IDLE_STEPS: u8 = 50;

/// The conditions for feeding the watchdog. The supervisor runs if it calls [`Liveness::step`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Liveness {
    blocks: u32,
    links: u32,
    looks: u32,
    idles: u32,
    without_idle: u8,
}

/// Counts since the start (they wrap).
#[derive(Clone, Copy, Debug, Default)]
pub struct TurnCounts {
    /// Blocks served by the control task.
    pub blocks: u32,
    /// Turns of the link task.
    pub links: u32,
    /// Looks of the blocks' guard.
    pub looks: u32,
    /// Turns of the idle loop.
    pub idles: u32,
}

impl Liveness {
    /// Call every 10 ms. Whether control, link and guard have run since the last step, and idle within the last half
    /// second.
    pub fn step(&mut self, done: TurnCounts) -> bool {
        let control = done.blocks != self.blocks;
        let link = done.links != self.links;
        let guard = done.looks != self.looks;
        self.without_idle = if done.idles == self.idles {
            self.without_idle.saturating_add(1)
        } else {
            0
        };
        (self.blocks, self.links) = (done.blocks, done.links);
        (self.looks, self.idles) = (done.looks, done.idles);
        control && link && guard && self.without_idle < IDLE_STEPS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn going(step: u32) -> TurnCounts {
        TurnCounts {
            blocks: 20 * step,
            links: 10 * step,
            looks: 10 * step,
            idles: step,
        }
    }

    #[test]
    fn fed_while_every_task_runs() {
        let mut liveness = Liveness::default();
        assert!((1..100).all(|step| liveness.step(going(step))));
    }

    #[test]
    fn any_stopped_task_starves_it() {
        let stopped: [fn(TurnCounts) -> TurnCounts; 3] = [
            |done| TurnCounts { blocks: 0, ..done },
            |done| TurnCounts { links: 0, ..done },
            |done| TurnCounts { looks: 0, ..done },
        ];
        for stop in stopped {
            let mut liveness = Liveness::default();
            assert!((1..5).all(|step| !liveness.step(stop(going(step)))));
        }
        let mut liveness = Liveness::default();
        let fed = (1..100)
            .take_while(|step| {
                liveness.step(TurnCounts {
                    idles: 0,
                    ..going(*step)
                })
            })
            .count();
        assert_eq!(fed, usize::from(IDLE_STEPS) - 1);
    }
}
