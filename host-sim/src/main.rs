//! `host-sim`: the hammer on the desktop.

mod limits;

fn main() {
    limits::report_file_size_limit();
    let arguments = std::env::args_os().map(|a| a.to_string_lossy().into_owned());
    std::process::exit(host_sim::cli::run(arguments));
}
