//! Recordings and measured tables as oscilloscopes and spreadsheets write them.

use crate::support::{Folder, Ran, assert_refused, csv_rows, number};

const COMPARE: &str =
    "compare record.csv --gap 1 --ratio 1.5 --cycles 160 --transient 140 --format json";

/// A record that `simulate` wrote, one line for a sample, by a format of its own.
fn record(head: &str, line: impl Fn(String, String) -> String) -> String {
    let folder = Folder::new();
    folder
        .run("simulate --gap 1 --ratio 1.5 --cycles 160 --transient 140 --out s --quiet")
        .well();
    let rows = csv_rows(&folder.read_made("s/simulate", "-history.csv"));
    let lines = rows.iter().map(|row| {
        let text = |name| format!("{:?}", number(row, name));
        line(text("time_s"), text("displacement_mm"))
    });
    head.to_owned() + &lines.collect::<String>()
}

#[test]
fn the_same_record_in_another_form_gives_the_same_answer() {
    let plain = record("time_s,displacement_mm\n", |t, x| format!("{t},{x}\n"));
    let plain = Folder::new().with("record.csv", plain);
    let expected = plain.run(COMPARE).well();
    assert!(!expected.err.contains("read with"), "{expected:?}");
    let head = "Model;XY-1\n\nTime;Channel 3;Displacement\n(s);V;(mm)\n";
    let other = record(head, |t, x| format!("{t};0,5;{x}\n").replace('.', ","));
    let other = Folder::new().with("record.csv", other);
    let ran = other.run(COMPARE).well();
    let answer = |ran: &Ran| {
        let mut json = ran.json();
        // It names the file's check sum.
        json.as_object_mut().expect("an object").remove("made_from");
        json
    };
    assert_eq!(answer(&ran), answer(&expected));
    let said = "record.csv: read with semicolons between the columns, decimal commas, names on line 3, units on line 4; 'Time' in s, 'Displacement' in mm";
    assert!(ran.err.contains(said), "{ran:?}");
    assert!(
        !other
            .run(&format!("{COMPARE} --quiet"))
            .well()
            .err
            .contains(said)
    );
}

#[test]
fn measured_points_in_other_units_are_compared() {
    let points = "FREQUENCY;FORCE\n(Hz);(kN)\n2,548;0,045\n2,73;0,05\n";
    let folder = Folder::new().with("m.csv", points);
    let line = "sweep --ratio 1.4:1.5:0.1 --cycles 60 --transient 40 --measured m.csv";
    let ran = folder.run(line).well();
    assert!(ran.out.contains("measured: 2 points compared"), "{ran:?}");
    assert!(ran.err.contains("'FORCE' in kN"), "{ran:?}");
}

#[test]
fn what_cannot_be_understood_is_one_line() {
    let hdf5: &[u8] = b"\x89HDF\r\n\x1a\n\0\0";
    let files: [(&str, &[u8], &str); 10] = [
        (
            "a.mat",
            b"MATLAB 5.0 MAT-file, made up",
            "it is a MAT file; write it as CSV",
        ),
        ("a.h5", hdf5, "it is an HDF5 file"),
        ("a.tdms", b"TDSm\x0e\0\0\0", "it is a TDMS file"),
        ("a.wfm", b"\x0f\x0f:WFM#003", "it is a WFM file"),
        ("a.xlsx", b"PK\x03\x04", "it is a workbook"),
        (
            "a.csv",
            b"time_s,force_n\n0,001,0,5\n",
            "line 2: there are twice as many numbers as names",
        ),
        (
            "b.csv",
            b"time;force\ns;V\n0;1\n",
            "line 2: the unit of 'force' is 'V'",
        ),
        (
            "c.csv",
            b"time_s;force_n\n0,1;2,5\n0.2;3\n",
            "line 3: '0.2' has a decimal point",
        ),
        (
            "d.csv",
            b"time_s;force_n\n0,1;2,5\n0,2",
            "line 3: 1 fields where line 1 has 2",
        ),
        (
            "e.csv",
            b"time_s;force_n\n0,1;nan\n",
            "line 2: force_n is 'nan'",
        ),
    ];
    for (name, bytes, says) in files {
        let folder = Folder::new().with(name, bytes);
        assert_refused(
            &folder,
            [
                (format!("compare {name}"), says),
                (format!("identify {name}"), says),
            ],
        );
    }
    let folder = Folder::new().with("m.csv", "frequency;force_n\n1,8;5\n");
    let says = "line 1: the column 'frequency' has no unit; call it frequency_hz";
    assert_refused(&folder, [("sweep --ratio 2 --measured m.csv", says)]);
}
