use super::*;

fn understood(text: &str) -> (String, String) {
    let plain = plain("scope.csv", text.to_owned()).unwrap();
    (plain.text, plain.said.unwrap_or_default())
}

fn complaint(text: &str) -> String {
    let error = plain("scope.csv", text.to_owned()).unwrap_err().to_string();
    assert_eq!(error.lines().count(), 1, "{error}");
    error
}

#[test]
fn a_plain_table_is_left_as_it_is() {
    for text in [
        "time_s,force_n\n0,1\n1e-5,2\n",
        "note, force_n ,time_s,force\n\n a,1,0,9\n",
        "gap_mm,frequency_hz,regime\n0,1.8,1/1\n",
        "a;b\n1;2\n",
        "time_s,x\n1,2\n",
        "",
    ] {
        assert_eq!(understood(text), (text.to_owned(), String::new()), "{text}");
    }
}

#[test]
fn semicolons_decimal_commas_and_a_row_of_units_are_understood() {
    let text = "Time;Force;Displacement\n(ms);(kN);(m)\n0,0;0,0575;1,5E-3\n\n0,05;-1e-3;-0,25\n";
    let (plain, said) = understood(text);
    assert_eq!(
        plain,
        "time_s,force_n,displacement_mm\n\n0.0,57.5,1.5\n\n5e-5,-1.0,-250.0\n"
    );
    assert_eq!(
        said,
        "scope.csv: read with semicolons between the columns, decimal commas, units on line 2; 'Time' in ms, 'Force' in kN, 'Displacement' in m"
    );
}

#[test]
fn lines_above_the_names_are_passed_over_and_lines_keep_their_numbers() {
    let text = "\u{feff}Model,TDS\nRecord Length,3,Points\n\nTIME [s],FORCE [N],CH3\n0.00,1.0,x\n\n0.01,2.5,y\n";
    let (plain, said) = understood(text);
    assert_eq!(plain, "time_s,force_n\n\n\n\n0.00,1.0\n\n0.01,2.5\n");
    assert!(said.contains("names on line 4"), "{said}");
    assert_eq!(plain.lines().nth(6), Some("0.01,2.5"));
}

#[test]
fn units_stand_in_names_or_below_them_and_a_column_may_go_without_one_in_the_row() {
    let (plain, _) = understood("frequency_khz\tforce_N\n0.0018\t57.5\n");
    assert_eq!(plain, "frequency_hz,force_n\n1.8,57.5\n");
    let (plain, _) = understood("gap (um);frequency (Hz);regime\n500;1,8;1/1\n");
    assert_eq!(plain, "gap_mm,frequency_hz,regime\n0.5,1.8,\"1/1\"\n");
    let (plain, said) = understood("time_s,force_n\ns,N\n0,1\n");
    assert_eq!(plain, "time_s,force_n\n\n0,1\n");
    assert!(said.contains("units on line 2"), "{said}");
    let (plain, _) = understood("\"Time\";\"Force\";\n\"µs\";\"N\";\n\"1,5\";\"2\";\n");
    assert_eq!(plain, "time_s,force_n\n\n1.5e-6,2\n");
}

#[test]
fn what_is_ambiguous_or_wrong_is_one_line_with_its_number() {
    for (text, says) in [
        (
            "time_s,force_n\n0,001,2,5\n",
            "line 2: there are twice as many numbers as names",
        ),
        (
            "time;force\ns;V\n0,1;2\n",
            "line 2: the unit of 'force' is 'V', must be one of N, mN, kN",
        ),
        (
            "time;force\n0,1;2\n",
            "line 1: the column 'time' has no unit; call it time_s",
        ),
        (
            "time_s;force_n\nms;N\n0;1\n",
            "line 2: the unit of 'time_s' is 'ms' here and another in its name",
        ),
        (
            "time_s;force_n\n0,1;2,5\n0.2;3\n",
            "line 3: '0.2' has a decimal point, and line 2 a decimal comma",
        ),
        (
            "time_s;force_n\n0,1;1.234,5\n",
            "line 2: '1.234,5' has a comma and a point",
        ),
        (
            "time_s;force_n\n0;1\n1\n",
            "line 3: 1 fields where line 1 has 2",
        ),
        (
            "time_s;force_n\n0;1\n1;2;3\n",
            "line 3: 3 fields where line 1 has 2",
        ),
        (
            "frequency_hz\tforce_n\n1,820\t57,500\n",
            "line 2: '1,820' may have a decimal comma or one between thousands",
        ),
        (
            "Time (s);time [ms];force_n\n0;0;1\n",
            "line 1: two columns are 'time_s'",
        ),
        ("time;force\ns;MN\n0,1;2\n", "the unit of 'force' is 'MN'"),
    ] {
        let said = complaint(text);
        assert!(
            said.starts_with("scope.csv, ") && said.contains(says),
            "{said}"
        );
    }
}

#[test]
fn with_semicolons_three_decimals_are_decimals() {
    let (plain, _) = understood("frequency_hz;force_n\n1,820;57,500\n");
    assert_eq!(plain, "frequency_hz,force_n\n1.820,57.500\n");
}

#[test]
fn what_is_no_number_is_left_to_the_reader() {
    let (plain, _) = understood("time_s;force_n\n0;abc\n1;nan\n2;\"a\"\"b\"\n");
    assert_eq!(plain.lines().nth(1), Some("0,\"abc\""));
    assert_eq!(plain.lines().nth(2), Some("1,\"nan\""));
}
