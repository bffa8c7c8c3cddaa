//! Which packages may not come in under the numerics: whatever draws, reads and writes files, talks to a person or to
//! a wire. `cargo tree` knows what comes in.

/// The packages that belong to the command line, the pictures, the files and the link.
const EDGE: &[&str] = &[
    "clap",
    "indicatif",
    "plotters",
    "resvg",
    "tiny-skia",
    "parquet",
    "mcap",
    "serialport",
    "csv",
    "toml",
    "signal-hook",
    "tempfile",
];

/// Those of [`EDGE`] in the output of `cargo tree --prefix none`, one line per package: `name v1.2.3 …`.
fn edge_packages(tree: &str) -> Vec<&'static str> {
    let present = |package: &&&str| {
        tree.lines()
            .any(|line| line.split(' ').next() == Some(**package))
    };
    EDGE.iter().filter(present).copied().collect()
}

#[test]
fn packages_are_found_by_their_whole_name() {
    let tree = "numerics v0.1.0 (/p/host-sim/numerics)\nnalgebra v0.34.2\ncsv-core v0.1.13\nshared v0.1.0 (/p/shared)";
    assert!(edge_packages(tree).is_empty());
    let tree =
        format!("{tree}\nplotters v0.3.7\nnalgebra v0.34.2 (*)\ntoml v0.9.12+spec-1.1.0 (*)");
    assert_eq!(edge_packages(&tree), ["plotters", "toml"]);
}

#[test]
fn nothing_of_the_edge_is_under_the_numerics() {
    use crate::command::{cargo, root};

    let manifest = root().join("host-sim/numerics/Cargo.toml");
    if !manifest.is_file() {
        return;
    }
    let mut tree = cargo();
    tree.args(["tree", "--locked", "--edges", "normal", "--prefix", "none"]);
    let output = tree.arg("--manifest-path").arg(manifest).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        output.status.success() && text.contains("shared v"),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert_eq!(edge_packages(&text), [""; 0]);
}
