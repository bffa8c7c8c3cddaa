//! Numbers of a rig that are varied are those that rig files name: both give the same rig.

use files::rigfile;
use numerics::knob::Knob;
use shared::model::contact::LAWS;

#[test]
fn a_knob_does_what_the_key_of_a_rig_file_does() {
    let values = |name: &str| match name {
        "contact_exponent" => 1.7,
        "contact_restitution"
        | "damping_ratio"
        | "shaker_damping_ratio"
        | "shaker_feed_forward" => 0.3,
        "natural_frequency_hz" => 2.5,
        "gap_mm" => 1.25,
        _ => 11.5,
    };
    let mut set = 0;
    for rig in ["wires", "beam-170"] {
        for (law, _) in LAWS {
            let law = [format!("contact_law={law}")];
            let base = rigfile::load(rig, &law).unwrap();
            let base = base.recoiling().unwrap();
            for knob in Knob::all() {
                let name = knob.name();
                let value = values(name);
                let by_knob = knob.set(&base.params, value);
                let settings = [law[0].clone(), format!("{name}={value}")];
                let by_file = rigfile::load(rig, &settings).ok();
                let by_file = by_file.map(|r| r.recoiling().unwrap().params);
                set += usize::from(by_knob.is_some());
                assert_eq!(by_knob, by_file, "{rig} {} {name}", law[0]);
            }
        }
    }
    assert!(set > 100, "{set}");
    assert_eq!(Knob::named("torque"), None);
    // A prescribed cart has no loop.
    let wires = rigfile::load("wires", &[]).unwrap().prescribed();
    let knob = Knob::named("shaker_loop_hz").unwrap();
    assert_eq!(knob.set(&wires.params, 20.0), None);
}
