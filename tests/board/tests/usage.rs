//! The program's words, and its exit codes.

use std::process::Command;

fn run(words: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_board"))
        .args(words)
        .output()
        .expect("the program starts");
    let text = [output.stdout, output.stderr].concat();
    (
        output.status.code(),
        String::from_utf8_lossy(&text).into_owned(),
    )
}

#[test]
fn what_is_not_understood_is_named() {
    let (code, text) = run(&["elf", "--fast"]);
    assert!(code == Some(2) && text.contains("--fast"), "{text}");
    let (code, text) = run(&["elf", "--seconds", "0"]);
    assert!(code == Some(2) && text.contains("0.1 to 3600"), "{text}");
}

#[test]
fn an_image_that_is_not_there_fails_its_check() {
    let (code, text) = run(&["no-such-image", "--mutants"]);
    assert!(
        code == Some(1) && text.contains("cannot read no-such-image"),
        "{text}"
    );
    let (code, text) = run(&["no-such-image", "cold boot"]);
    assert!(
        code == Some(1) && text.contains("FAILED  cold boot: cannot read no-such-image"),
        "{text}"
    );
}
