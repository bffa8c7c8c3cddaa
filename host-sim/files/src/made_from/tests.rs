use serde_json::{Value, json};

use super::*;

fn made() -> MadeFrom {
    let mut made = MadeFrom::this_program();
    made.command = "host-sim sweep --rig 'a <b> & c'".into();
    made.with_rigs([&NamedRig::preset("wires").unwrap()])
}

#[test]
fn json_carries_it_last_and_reads_back() {
    let answers = [
        json!({"a": 1, "b": {"c": []}}),
        json!({}),
        json!([{"a": "}\n  }"}, {"a": 2}]),
    ];
    for answer in answers {
        for pretty in [true, false] {
            let text = match pretty {
                true => serde_json::to_string_pretty(&answer).unwrap() + "\n",
                false => serde_json::to_string(&answer).unwrap() + "\n",
            };
            if !pretty && answer.is_array() {
                continue;
            }
            let with = into_json(text.clone(), &made());
            let read: Value = serde_json::from_str(&with).unwrap_or_else(|e| panic!("{e}: {with}"));
            let carrier = match &read {
                Value::Array(list) => list[0].as_object().unwrap(),
                one => one.as_object().unwrap(),
            };
            let (key, value) = carrier.iter().next_back().unwrap();
            assert_eq!(key, KEY, "{with}");
            assert_eq!(
                serde_json::from_value::<MadeFrom>(value.clone()).unwrap(),
                made()
            );
            // A second time changes nothing.
            assert_eq!(into_json(with.clone(), &made()), with);
        }
    }
    assert_eq!(into_json("[]\n".into(), &made()), "[]\n");
}

#[test]
fn every_parameter_of_the_rig_is_in_it() {
    let rig = rigfile::load("beam-170", &["mass_kg=0.5".to_owned()]).unwrap();
    let used = RigUsed::from(&rig);
    assert_eq!(used.overridden, ["mass_kg=0.5"]);
    assert_eq!(used.cart, "prescribed");
    assert_eq!(used.parameters["mass_kg"], 0.5);
    let lines = rigfile::lines(&rig.params);
    for line in lines.lines() {
        let key = line.split(' ').next().unwrap();
        assert!(used.parameters.contains_key(key), "{key}");
    }
}

#[test]
fn names_tell_signs_and_stay_short() {
    assert_eq!(in_name("wires (mass_kg=0.5)"), "wires-mass_kg=0.5");
    assert_eq!(in_name("-0.1"), "minus-0.1");
    assert_eq!(in_name("-6:-1"), "minus-6-minus-1");
    assert_eq!(in_name("0.8:4.5:0.01"), "0.8-4.5-0.01");
    assert_eq!(in_name("beam-170"), "beam-170");
    assert_ne!(
        file_name(["sweep", "gap", "0.1"]),
        file_name(["sweep", "gap", "-0.1"])
    );
    let long = "x".repeat(300);
    let (a, b) = (
        file_name([long.as_str(), "a"]),
        file_name([long.as_str(), "b"]),
    );
    assert!(a.len() <= 120 && a != b);
}

#[test]
fn answers_may_be_replaced_and_nothing_else() {
    let dir = tempfile::tempdir().unwrap();
    let put = |name: &str, bytes: &[u8]| std::fs::write(dir.path().join(name), bytes).unwrap();
    let look = || refuse_others(dir.path(), ["a.svg", "a.json", "a.csv"]);
    let refused = || look().unwrap_err().to_string();
    assert_eq!(look(), Ok(()));
    put("a.csv", b"x");
    assert!(refused().contains("a.csv is no answer of this program"));
    put(
        "a.json",
        into_json("{\n  \"x\": 1\n}\n".into(), &made()).as_bytes(),
    );
    assert_eq!(look(), Ok(()), "the CSV beside it is ours");
    put("a.svg", b"<svg></svg>");
    assert!(refused().contains("a.svg is no answer of this program"));
    put("a.svg", into_svg("<svg></svg>", &made()).as_bytes());
    assert_eq!(look(), Ok(()));
    put("a.json", b"{}");
    assert!(refused().contains("a.json is no answer of this program"));
    std::fs::remove_file(dir.path().join("a.json")).unwrap();
    std::fs::create_dir(dir.path().join("a.json")).unwrap();
    let line = refused();
    assert!(line.contains("a.json is a folder; move it away"), "{line}");
    assert_eq!(line.lines().count(), 1);
    let png = [b"\x89PNG".as_slice(), &[0; 40]].concat();
    put("b.png", &into_png(png, &made()));
    assert!(says(&dir.path().join("b.png")));
}

#[test]
fn an_svg_stays_well_formed() {
    let with = into_svg("<svg xmlns=\"x\"><g/></svg>\n", &made());
    assert!(with.starts_with("<svg xmlns=\"x\"><metadata id=\"made_from\">{"));
    assert!(with.contains("'a &lt;b&gt; &amp; c'") && with.ends_with("</metadata><g/></svg>\n"));
}

#[test]
fn a_table_says_how_the_cart_is_moved_where_the_command_has_the_option() {
    let mut asked = made();
    let said = |table: &str, made: &MadeFrom| {
        String::from_utf8(into_csv(table.as_bytes().to_vec(), made)).unwrap()
    };
    let table = "rig,gap_mm\nwires,0.0\n";
    assert_eq!(said(table, &asked), table);
    asked.has_cart = true;
    assert_eq!(
        said(table, &asked),
        "rig,gap_mm,cart\nwires,0.0,prescribed\n"
    );
    for whole in ["", "cart,rig\nrecoil,wires\n", "time_s,force_n\n0.0,1.0\n"] {
        assert_eq!(said(whole, &asked), whole);
    }
    // Two rigs, each with its own.
    let mut other = asked.rigs[0].clone();
    (other.name, other.cart) = ("mine, the second".into(), "recoil".into());
    asked.rigs.push(other);
    let table = "rig,gap_mm\nwires,0.0\n\"mine, the second\",1.0\n";
    let with = "rig,gap_mm,cart\nwires,0.0,prescribed\n\"mine, the second\",1.0,recoil\n";
    assert_eq!(said(table, &asked), with);
}
