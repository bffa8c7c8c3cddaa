//! Running the program, and reading what it leaves.

use std::collections::HashMap;
use std::fs::{self, File};
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, LazyLock, Mutex, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

/// A run that does nothing for this long hangs. A slow machine is no reason to end it: on Linux only the time counts
/// in which it uses hardly any processor time.
const PATIENCE: Duration = Duration::from_secs(180);

/// A second of processor time, in Linux's ticks. What only waits, and wakes up now and then, uses less.
const WORKING: u64 = 100;

/// The program, built by Cargo for these tests.
pub fn program() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_host-sim"))
}

/// What a run came to.
#[derive(Debug)]
pub struct Ran {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Ran {
    /// What it left, having made sure that it ended with code 0.
    pub fn well(self) -> Self {
        assert_eq!(self.code, Some(0), "{self:?}");
        self
    }

    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}: {self:?}"))
    }
}

/// A folder of its own to run the program in.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The one file whose name begins with `start` and goes on with a request (or nothing) and `end`: file names tell
    /// the options given.
    pub fn made(&self, start: &str, end: &str) -> PathBuf {
        let stem = self.stem(start);
        self.path(&format!("{stem}{end}"))
    }

    /// The text of the same.
    pub fn read_made(&self, start: &str, end: &str) -> String {
        let path = self.made(start, end);
        fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }

    /// How the names of an answer's files begin: the name of its JSON.
    fn stem(&self, start: &str) -> String {
        let names = self.names();
        let stems = names.iter().filter_map(|n| n.strip_suffix(".json"));
        let stems = stems.filter(|stem| stem.starts_with(start));
        let stem = stems.min_by_key(|stem| stem.len());
        stem.unwrap_or_else(|| panic!("no {start}*.json in {names:?}"))
            .to_owned()
    }

    /// What the names of an answer's files end with, in order; there must be no other file that begins with `start`.
    pub fn ends(&self, start: &str) -> Vec<String> {
        let stem = self.stem(start);
        let names = self.names().into_iter().filter(|n| n.starts_with(start));
        let mut ends: Vec<String> = names
            .map(|name| match name.strip_prefix(&stem) {
                Some(end) => end.to_owned(),
                None => panic!("{name} does not begin with {stem}"),
            })
            .collect();
        ends.sort();
        ends
    }

    pub fn with(self, name: &str, contents: impl AsRef<[u8]>) -> Self {
        fs::write(self.path(name), contents).expect("a file in a temporary folder");
        self
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Every file in it, however deep, in order.
    pub fn names(&self) -> Vec<String> {
        let mut names = Vec::new();
        collect(self.0.path(), "", &mut names);
        names.sort();
        names
    }

    /// A command that runs the program here.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(program());
        command
            .args(arguments)
            .current_dir(self.0.path())
            .stdin(Stdio::null())
            .env_remove("RAYON_NUM_THREADS");
        command
    }

    /// Runs the program here with the words of `line`.
    pub fn run(&self, line: &str) -> Ran {
        let words: Vec<_> = line.split_whitespace().collect();
        finish(self.command(&words))
    }
}

fn collect(dir: &Path, prefix: &str, names: &mut Vec<String>) {
    for entry in fs::read_dir(dir).expect("a readable folder") {
        let entry = entry.expect("a readable folder");
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            collect(&entry.path(), &format!("{name}/"), names);
        } else {
            names.push(name);
        }
    }
}

/// Runs `command` to its end and keeps what it wrote.
pub fn finish(mut command: Command) -> Ran {
    let scratch = || tempfile::tempfile().expect("a temporary file");
    let (mut out, mut err) = (scratch(), scratch());
    let same = |file: &File| Stdio::from(file.try_clone().expect("one more handle"));
    let child = command.stdout(same(&out)).stderr(same(&err)).spawn();
    let status = wait(child.expect("the program starts"));
    Ran {
        code: status.code(),
        out: contents(&mut out),
        err: contents(&mut err),
    }
}

/// Waits for the end, but not for ever.
pub fn wait(mut child: Child) -> ExitStatus {
    let mut idle_since = Instant::now();
    let mut used = 0;
    loop {
        if let Some(status) = child.try_wait().expect("a child to wait for") {
            return status;
        }
        if idle_since.elapsed() > PATIENCE {
            // Looked at only now: hardly any run takes that long.
            let now = processor_ticks(child.id()).unwrap_or(0);
            if now < used + WORKING {
                child.kill().expect("a child to stop");
                panic!("it did nothing for {PATIENCE:?}");
            }
            (idle_since, used) = (Instant::now(), now);
        }
        thread::sleep(Duration::from_millis(5));
    }
}

/// The processor time a process has used, in Linux's ticks; `None` elsewhere.
fn processor_ticks(process: u32) -> Option<u64> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name in brackets may hold blanks; user and system time are the 12th and 13th field behind it.
    let (_, fields) = stat.rsplit_once(") ")?;
    let times = fields.split(' ').skip(11).take(2);
    times.map(|ticks| ticks.parse::<u64>().ok()).sum()
}

fn contents(file: &mut File) -> String {
    let mut text = String::new();
    file.rewind().expect("a temporary file");
    file.read_to_string(&mut text)
        .expect("the program writes UTF-8");
    text
}

/// Makes sure that every line is refused in `folder`: exit code 2, one line on standard error that contains the words
/// beside it, nothing on standard output, and no file.
pub fn assert_refused<'a, L: AsRef<str>>(
    folder: &Folder,
    lines: impl IntoIterator<Item = (L, &'a str)>,
) {
    let faults = lines.into_iter().filter_map(|(line, says)| {
        let words: Vec<_> = line.as_ref().split_whitespace().collect();
        fault(folder, &words, says)
    });
    let faults: Vec<_> = faults.collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// What is wrong with how `words` are refused.
pub fn fault(folder: &Folder, words: &[&str], says: &str) -> Option<String> {
    let before = folder.names();
    let ran = finish(folder.command(words));
    let one_line = ran.err.ends_with('\n') && ran.err.lines().count() == 1;
    let refused = ran.code == Some(2)
        && one_line
        && ran.err.starts_with("error: ")
        && ran.err.contains(says)
        && ran.out.is_empty()
        && folder.names() == before;
    (!refused).then(|| format!("{words:?} should say '{says}': {ran:?}"))
}

/// The JSON answer to `line`, asked in a folder that must stay empty, with nothing else said; what it was made from is
/// left out (tests of their own look at that). The same line is asked once: that a run repeats itself is tested elsewhere.
pub fn answer(line: &str) -> Value {
    static ASKED: LazyLock<Mutex<HashMap<String, Arc<OnceLock<Value>>>>> =
        LazyLock::new(Mutex::default);
    let place = {
        let mut asked = ASKED.lock().unwrap();
        Arc::clone(asked.entry(line.to_owned()).or_default())
    };
    place.get_or_init(|| asked_now(line)).clone()
}

fn asked_now(line: &str) -> Value {
    let folder = Folder::new();
    let ran = folder.run(&format!("{line} --format json --quiet")).well();
    assert_eq!((ran.err.as_str(), folder.names()), ("", vec![]), "{line}");
    without_origin(ran.json())
}

/// `answer` without what it was made from.
pub fn without_origin(mut answer: Value) -> Value {
    let carrier = match &mut answer {
        Value::Array(list) => list.first_mut(),
        one => Some(one),
    };
    if let Some(object) = carrier.and_then(Value::as_object_mut) {
        object.shift_remove("made_from");
    }
    answer
}

/// The number at `key`.
pub fn number(value: &Value, key: &str) -> f64 {
    value[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key} is no number in {value}"))
}

/// The two numbers at `key`.
pub fn pair(value: &Value, key: &str) -> [f64; 2] {
    [0, 1].map(|i| {
        let end = value[key][i].as_f64();
        end.unwrap_or_else(|| panic!("{key} is no pair in {value}"))
    })
}

/// The field names of an object, in order, without that of what it was made from.
pub fn keys(value: &Value) -> Vec<&str> {
    let object = value.as_object().expect("an object");
    let keys = object.keys().map(String::as_str);
    keys.filter(|key| *key != "made_from").collect()
}

/// The lines of a CSV text by column; every cell that reads as JSON is that value, others are text.
pub fn csv_rows(text: &str) -> Vec<Value> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let headers = reader.headers().expect("a header line").clone();
    let cell = |cell: &str| match cell {
        "" => Value::Null,
        text => serde_json::from_str(text).unwrap_or_else(|_| Value::from(text)),
    };
    let rows = reader.records().map(|record| {
        let record = record.expect("as many cells as headers");
        let cells = headers.iter().zip(&record);
        cells
            .map(|(key, text)| (key.to_owned(), cell(text)))
            .collect()
    });
    rows.collect()
}

/// Width and height of a PNG that decodes to its last row and is not all one colour.
pub fn png_size(bytes: &[u8]) -> (u32, u32) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
        .read_info()
        .expect("a PNG header");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size that fits")];
    let frame = reader.next_frame(&mut pixels).expect("whole pixel data");
    reader.finish().expect("a PNG to its end");
    assert!(pixels.iter().any(|p| *p != pixels[0]), "a blank picture");
    (frame.width, frame.height)
}

/// Makes sure that `text` is a whole SVG that shows `words`.
pub fn assert_svg_shows(text: &str, words: &[&str]) {
    let document = roxmltree::Document::parse(text).expect("well-formed XML");
    assert_eq!(document.root_element().tag_name().name(), "svg");
    let texts = document.descendants().filter_map(|node| node.text());
    let shown = texts.collect::<Vec<_>>().join(" ");
    for word in words {
        assert!(shown.contains(word), "{word} is not in: {shown}");
    }
}
