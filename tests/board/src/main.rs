//! Runs the board's image in the model.

fn main() {
    let path = std::env::args().nth(1).expect("path");
    let image = board::image::Image::read(std::path::Path::new(&path)).unwrap();
    let mut pins = [[board::parts::gpio::Outside::Open; 16]; 8];
    pins[2][13] = board::parts::gpio::Outside::High;
    pins[1][5] = board::parts::gpio::Outside::Low;
    let around = board::machine::Around {
        hse: board::parts::rcc::External::Running,
        pins,
        supply_v: 3.3,
        lsi_hz: 32_000,
        options: 0x0fff_aaed,
        baud: 2_250_000,
    };
    let mut m = board::machine::Machine::power_up(image, around, 1);
    m.codes = [2048; 19];
    m.codes[17] = board::memory::VREFINT_CODE;
    let t = std::time::Instant::now();
    let end = board::parts::UNITS_PER_S;
    while m.now < end {
        if let Err(stop) = m.run_until(end) {
            println!("{stop}");
            break;
        }
    }
    let e = t.elapsed().as_secs_f64();
    println!(
        "{} ms, {} instr, {:.1} M/s, {} ticks",
        m.now / 720_000,
        m.instructions,
        m.instructions as f64 / e / 1e6,
        m.ticks
    );
    for c in m.changes.iter().take(30) {
        println!("{:.3} ms {:?}", c.0 as f64 / 720e3, c.1);
    }
    for (i, n) in m.entered.iter().enumerate().filter(|x| *x.1 > 0) {
        println!("exception {i}: {n}");
    }
}
