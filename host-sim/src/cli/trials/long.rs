//! `host-sim trials --long`.

use emulator::trials::LongTrials;
use emulator::trials::long::drift;
use files::words::count;

pub(super) fn text(answer: &LongTrials) -> String {
    let (seed, seconds) = (answer.seed, answer.seconds_s);
    let (all, rows) = (&answer.campaign, &answer.trials);
    let number = |value: Option<f64>, digits: usize| {
        value.map_or("never".to_owned(), |value| format!("{value:.digits$}"))
    };
    let rig = all.share_worst_rig.as_deref().unwrap_or_default();
    let mut text = format!(
        "{} of {} ran for {seconds} s after the start without a trip; the weakest has {} of its optimum's force (trial {}, {rig})\n\n\
         Seed {seed}. From start to end the natural frequency drifts by {} %, the hammer's or the cart's sensor or both come to\n\
         be {} ms late, and each sensor's gain drifts by {} % per minute, up or down.\n\n\
         false trips         {}\n\
         trips by the drift  {} (sensors that contradict each other by more than the checks allow)\n\
         in Hold at the end  {}\n\
         1/1 lost            {}\n\
         Hold after the start, s: {} (median), {} (last); share of the time in Hold from then on: at least {}\n\
         force over the optimum's at the amplitude that the cart's sensor makes of A0: {} (median), {} (worst); at A0: {} (worst)\n\
         largest blow: {:.2} of the force limit\n",
        all.without_trip,
        count(all.trials, "rig"),
        number(all.share_worst, 4),
        all.share_worst_trial.unwrap_or_default(),
        drift::NATURAL_PERCENT,
        drift::LAG_MS,
        drift::GAIN_PERCENT_PER_MIN,
        all.false_trips,
        all.trips_by_drift,
        all.held,
        all.lost,
        number(all.hold_median_s, 1),
        number(all.hold_last_s, 1),
        number(all.hold_share_worst, 4),
        number(all.share_median, 4),
        number(all.share_worst, 4),
        number(all.share_at_a0_worst, 4),
        all.largest_force_over_limit,
    );
    let tripped = rows.iter().filter(|row| row.trip.is_some());
    for (k, row) in tripped.enumerate() {
        if k == 0 {
            text += &format!(
                "\n{:<6} {:<9} {:<22} {:<7} {:>8} {:>16} {:>16}  {}\n",
                "trial",
                "rig",
                "trip",
                "sensor",
                "after, s",
                "hammer/cart gain",
                "force/hammer",
                "by the drift"
            );
        }
        text += &format!(
            "{:<6} {:<9} {:<22} {:<7} {:>8} {:>16.3} {:>16.3}  {}\n",
            row.trial,
            row.rig,
            row.trip.unwrap_or_default(),
            row.trip_sensor.unwrap_or("-"),
            number(row.trip_s, 1),
            row.hammer_over_cart_gain,
            row.force_over_hammer_gain,
            if row.trip_by_drift == Some(true) {
                "yes"
            } else {
                "no"
            },
        );
    }
    text
}
