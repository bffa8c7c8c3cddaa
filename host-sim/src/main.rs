//! `host-sim`: the hammer on the desktop.

fn main() {
    std::process::exit(host_sim::cli::run(std::env::args_os()));
}
