//! `host-sim`: the hammer on the desktop.

mod limits;

fn main() {
    limits::report_file_size_limit();
    std::process::exit(host_sim::cli::run(std::env::args_os()));
}
