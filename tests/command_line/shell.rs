//! `host-sim completions` and `host-sim man`.

use crate::support::Folder;

/// The commands that `--help` lists.
fn commands() -> Vec<String> {
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
