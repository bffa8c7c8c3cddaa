//! `host-sim completions`, `host-sim man`, and the examples of every `--help`.

#[cfg(target_os = "linux")]
use crate::emulate::STOPPED;
use crate::support::Folder;

/// The commands that `--help` lists.
pub fn commands() -> Vec<String> {
    let help = Folder::new().run("--help").well().out;
    let list = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let words = list.take_while(|line| !line.is_empty());
    let names = words.filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    let names = names.filter(|name| !name.is_empty() && *name != "help");
    names.map(str::to_owned).collect()
}

#[test]
fn every_shell_completes_every_command() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = Folder::new().run(&format!("completions {shell}")).well();
        for command in commands() {
            assert!(script.out.contains(&command), "{shell}: {command}");
        }
        assert!(script.out.contains("max-force-n"), "{shell}");
    }
    let ran = Folder::new().run("completions csh");
    assert_eq!(ran.code, Some(2), "{ran:?}");
}

#[test]
fn every_command_has_a_page() {
    let folder = Folder::new();
    folder.run("man pages").well();
    let mut expected: Vec<String> = commands()
        .iter()
        .map(|name| format!("host-sim-{name}.1"))
        .collect();
    expected.push("host-sim.1".to_owned());
    expected.sort();
    let entries = std::fs::read_dir(folder.path("pages")).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, expected);
    let page = folder.read("pages/host-sim-pick.1");
    assert!(page.contains(".TH host-sim-pick 1"), "{page}");
    assert!(page.contains("max\\-force\\-n"), "{page}");
}

/// As a person types them, in a shell. Less than half a second is enough to tell a mistake; what takes longer is
/// ended, and counts as well. Left out: what needs a board, a browser or a terminal.
#[cfg(target_os = "linux")]
#[test]
fn the_examples_of_every_help_run() {
    use crate::support::{finish, program};
    let sine = |i: i32| (f64::from(i) * 1e-3, (f64::from(i) * 0.023).sin());
    let record = (0..12_000).map(sine);
    let record = record
        .map(|(t, x)| format!("{t},{x}\n"))
        .collect::<String>();
    let folder = Folder::new()
        .with("record.csv", format!("time_s,displacement_mm\n{record}"))
        .with("field.toml", STOPPED);
    folder.run("emulate field.toml --quiet").well();
    let drop = folder.run("drop --noise-n 0.2 --format csv --quiet").well();
    let completions = folder.path(".local/share/bash-completion/completions");
    std::fs::create_dir_all(completions).unwrap();
    let mut examples = 0;
    for command in commands() {
        let help = folder.run(&format!("{command} --help")).well().out;
        let lines = help.lines().filter(|line| line.starts_with("  host-sim "));
        for line in lines {
            let left_out = ["link", "lab"].contains(&command.as_str());
            if left_out || line.ends_with("rig new mine.toml") {
                continue;
            }
            match command.as_str() {
                "rig" => std::fs::remove_file(folder.path("mine.toml")).unwrap(),
                _ => std::fs::write(folder.path("mine.toml"), "preset = \"wires\"\n").unwrap(),
            }
            // The example that makes it may have been ended before it wrote it.
            std::fs::write(folder.path("drop.csv"), &drop.out).unwrap();
            let mut shell = std::process::Command::new("/usr/bin/timeout");
            shell
                .args(["0.4", "/bin/sh", "-c", line])
                .current_dir(folder.path(""))
                .env("PATH", program().parent().unwrap())
                .env("HOME", folder.path(""))
                .stdin(std::process::Stdio::null());
            let ran = finish(shell);
            assert!(!matches!(ran.code, Some(1 | 2)), "{line}: {ran:?}");
            examples += 1;
        }
    }
    assert!(examples > 40, "{examples}");
}
