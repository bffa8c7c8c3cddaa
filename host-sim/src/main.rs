//! `host-sim`: the hammer on the desktop.

fn main() {
    let arguments = std::env::args_os().map(|a| a.to_string_lossy().into_owned());
    std::process::exit(host_sim::cli::run(arguments));
}
