//! The page: its module compiled to WebAssembly, and everything put into one file that needs no network and no server.

mod browser;
mod bundle;

pub use browser::{environment, test};

use std::{fs, io::Write, path::PathBuf};

use base64::{Engine, prelude::BASE64_STANDARD};
use flate2::{Compression, write::GzEncoder};

use crate::{
    JobResult,
    command::{self, root},
    tools,
};

/// Most bytes of the page.
const MOST_BYTES: usize = 3_000_000;

/// Builds the page; where it is.
pub fn build() -> JobResult<PathBuf> {
    let module = module()?;
    let packed = packed(&module)?;
    let page = bundle::page(&root().join("web/page"), &BASE64_STANDARD.encode(&packed))?;
    let place = root().join("target/web");
    fs::create_dir_all(&place)?;
    let whole = place.join("index.html");
    let part = place.join("index.html.part");
    fs::write(&part, &page)?;
    fs::rename(&part, &whole)?;
    println!(
        "the page: {:.2} MB, of which the module is {:.2} MB ({:.2} MB before it was compressed and became text)",
        page.len() as f64 / 1e6,
        packed.len().div_ceil(3) as f64 * 4.0 / 1e6,
        module.len() as f64 / 1e6
    );
    if page.len() > MOST_BYTES {
        return Err(format!("the page has {} bytes, more than {MOST_BYTES}", page.len()).into());
    }
    Ok(whole)
}

/// Builds the page where there is a Rust for it; else a line says that it is left out.
pub fn build_if_possible() -> JobResult<Option<PathBuf>> {
    match tools::wasm_toolchain() {
        Ok(_) => build().map(Some),
        Err(error) => {
            println!("the page is left out: {error}");
            Ok(None)
        }
    }
}

/// The module as gzip, which every browser unpacks.
fn packed(module: &[u8]) -> JobResult<Vec<u8>> {
    let mut packer = GzEncoder::new(Vec::new(), Compression::best());
    packer.write_all(module)?;
    Ok(packer.finish()?)
}

/// Compiles the module; its bytes.
fn module() -> JobResult<Vec<u8>> {
    let toolchain = tools::wasm_toolchain()?;
    let mut cargo = toolchain.wasm_cargo("build");
    cargo.args(["--locked", "--package", "web", "--lib", "--profile", "web"]);
    command::run(&mut cargo)?;
    let place = "target/wasm/wasm32-unknown-unknown/web/web.wasm";
    Ok(fs::read(root().join(place))?)
}

/// Builds the page and the program with it, and runs that: the page alone, or with the board at a port.
pub fn lab(board: Option<String>, options: &[String]) -> JobResult {
    build()?;
    let mut cargo = command::cargo();
    cargo.args(["run", "--release", "--package", "host-sim"]);
    cargo.args(["--features", "page", "--"]);
    match board {
        Some(port) => cargo.args(["link", &port, "--page"]),
        None => cargo.arg("lab"),
    };
    command::run_attended(cargo.args(options))
}
