use std::fs::File;
use std::io::Write;

use super::*;

fn field(name: &'static str, kind: ColumnKind, optional: bool, packing: Packing) -> ColumnField {
    ColumnField {
        name: name.into(),
        kind,
        optional,
        packing,
    }
}

fn fields() -> Vec<ColumnField> {
    use {ColumnKind as K, Packing as P};
    vec![
        field("flag", K::Flag, false, P::Dictionary),
        field("int", K::Int, false, P::Differences),
        field("long", K::Long, true, P::Differences),
        field("float", K::Float, true, P::Split),
        field("text", K::Text, true, P::Dictionary),
        field("bytes", K::Bytes, false, P::Dictionary),
    ]
}

/// Rows `from..to`: every third lacks what may be lacking.
fn group(from: i32, to: i32) -> Vec<Column> {
    let mut columns: Vec<_> = fields().iter().map(Column::new).collect();
    for i in from..to {
        let there = i % 3 != 0;
        let text = format!("row {}", i / 2);
        let values = [
            Some(ColumnValue::Flag(i % 2 == 0)),
            Some(ColumnValue::Int(-i)),
            there.then_some(ColumnValue::Long(i64::from(i) << 40)),
            there.then_some(ColumnValue::Float(i as f32 / 7.0)),
            there.then_some(ColumnValue::Text(&text)),
            Some(ColumnValue::Bytes(&[0, 255, i as u8])),
        ];
        for (column, value) in columns.iter_mut().zip(values) {
            column.push(value).unwrap();
        }
    }
    columns
}

fn file(groups: &[(i32, i32)]) -> Vec<u8> {
    let pairs = vec![("format".to_owned(), "a test".to_owned())];
    let mut writer = ParquetWriter::new(Vec::new(), "test", &fields(), pairs).unwrap();
    for (from, to) in groups {
        writer.group(&group(*from, *to)).unwrap();
    }
    writer.finish().unwrap()
}

fn open(bytes: &[u8]) -> Result<ParquetReader, Error> {
    let mut file: File = tempfile::tempfile().unwrap();
    file.write_all(bytes).unwrap();
    ParquetReader::open(file)
}

#[test]
fn what_is_written_is_read_again_group_by_group() {
    let groups = [(0, 50), (50, 51), (51, 400)];
    let reader = open(&file(&groups)).unwrap();
    assert_eq!(reader.pairs().collect::<Vec<_>>(), [("format", "a test")]);
    assert!(reader.is_checked());
    assert_eq!((reader.rows(), reader.groups()), (400, 3));
    assert!(reader.has(&fields()));
    for (i, (from, to)) in groups.into_iter().enumerate() {
        let read = reader.group(i, &fields()).unwrap();
        for (read, written) in read.iter().zip(group(from, to)) {
            assert_eq!(read.values(), written.values());
            assert_eq!(read.rows(), written.rows());
            assert!((0..=read.rows()).all(|row| read.has(row) == written.has(row)));
        }
    }
}

#[test]
fn other_columns_are_told_apart() {
    let reader = open(&file(&[(0, 3)])).unwrap();
    let changed = |change: fn(&mut Vec<ColumnField>)| {
        let mut fields = fields();
        change(&mut fields);
        reader.has(&fields)
    };
    assert!(!changed(|fields| drop(fields.pop())));
    assert!(!changed(|fields| fields[2].name = "length".into()));
    assert!(!changed(|fields| fields[2].kind = ColumnKind::Int));
    assert!(!changed(|fields| fields[2].optional = false));
}

#[test]
fn a_value_of_another_kind_or_none_where_there_must_be_one_is_refused() {
    let mut column = Column::new(&fields()[1]);
    assert_eq!(column.push(Some(ColumnValue::Long(1))), Err(WrongKind));
    assert_eq!(column.push(None), Err(WrongKind));
    assert_eq!(column.rows(), 0);
}

#[test]
fn every_damaged_byte_ends_in_an_error_or_in_values() {
    let whole = file(&[(0, 300)]);
    let mut refused = 0;
    for at in 0..whole.len() {
        for flip in [0x01, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] ^= flip;
            let read = open(&bytes)
                .and_then(|r| (0..r.groups()).try_for_each(|i| r.group(i, &fields()).map(drop)));
            refused += u32::from(read.is_err());
        }
    }
    assert!(refused > 100, "{refused} of {}", 3 * whole.len());
    for length in 0..whole.len() {
        assert!(open(&whole[..length]).is_err(), "cut to {length} bytes");
    }
}

#[test]
fn a_flipped_bit_anywhere_is_found_and_its_group_is_named() {
    let groups = [(0, 40), (40, 90), (90, 120)];
    let whole = file(&groups);
    let read = |bytes: &[u8]| -> Result<(), usize> {
        let Ok(reader) = open(bytes) else {
            return Err(usize::MAX);
        };
        // A footer that no longer says what is checked is refused by its reader.
        if !reader.is_checked() {
            return Err(usize::MAX);
        }
        (0..reader.groups()).try_for_each(|i| reader.group(i, &fields()).map(drop).map_err(|_| i))
    };
    assert_eq!(read(&whole), Ok(()));
    let checks = open(&whole).unwrap();
    let text = checks.checks().unwrap();
    let ends: Vec<usize> = text
        .split(' ')
        .filter_map(|part| usize::from_str_radix(part.split_once(':')?.0, 16).ok())
        .collect();
    assert_eq!(ends.len(), 3);
    for byte in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[byte] ^= 1 << (byte % 8);
        let place = ends.iter().position(|end| byte < *end);
        // The first four bytes are the file's name for itself.
        let want = if byte < 4 {
            Err(0)
        } else {
            Err(place.unwrap_or(usize::MAX))
        };
        let got = read(&bytes);
        assert!(
            got == want || byte < 4 && got.is_err(),
            "byte {byte}: {got:?}, not {want:?}"
        );
    }
    // Two rows swapped, pieces left out or put in.
    for cut in [1, 5, 100, whole.len() / 2] {
        let mut bytes = whole.clone();
        bytes.remove(bytes.len() - cut);
        assert!(read(&bytes).is_err());
        bytes = whole.clone();
        bytes.insert(cut, 7);
        assert!(read(&bytes).is_err());
    }
}
