//! Where each kind of file carries what it was made from.

use super::{KEY, MadeFrom, RigUsed};

/// The bytes of the file `name` with `made`, where its kind has a place for it: JSON, SVG and PNG. (Parquet takes it
/// when it is written, see [`pair`]; a CSV has no such place, and the JSON beside it carries it, but see [`into_csv`].)
pub fn stamped(name: &str, bytes: Vec<u8>, made: &MadeFrom) -> Vec<u8> {
    let into_text = |bytes, into: &dyn Fn(String) -> String| match String::from_utf8(bytes) {
        Ok(text) => into(text).into_bytes(),
        Err(error) => error.into_bytes(),
    };
    match name.rsplit_once('.').map(|(_, end)| end) {
        Some("json") => into_text(bytes, &|text| into_json(text, made)),
        Some("svg") => into_text(bytes, &|text| into_svg(&text, made)),
        Some("png") => into_png(bytes, made),
        Some("csv") => into_csv(bytes, made),
        _ => bytes,
    }
}

/// The key and value in the footer of a Parquet file.
pub fn pair(made: &MadeFrom) -> (String, String) {
    (KEY.to_owned(), compact(made))
}

fn compact(made: &MadeFrom) -> String {
    serde_json::to_string(made).expect("plain values always serialise")
}

/// JSON as this program writes it, with `made` as the last field of the answer; of a list, as the last field of its
/// first object. What has no object stays as it is, and so does what already has the field.
pub fn into_json(mut text: String, made: &MadeFrom) -> String {
    if text.contains(&format!("\"{KEY}\":")) {
        return text;
    }
    let pretty = text.contains('\n') && text.trim_end().contains('\n');
    // A text holds no line break, so these are where an object of that depth ends.
    let (end, indent) = if text.starts_with('[') {
        (text.find("\n  }"), "    ")
    } else if !text.starts_with('{') {
        (None, "")
    } else if pretty {
        (text.rfind("\n}"), "  ")
    } else {
        (text.rfind('}'), "")
    };
    let Some(end) = end else { return text };
    let comma = if text[..end].ends_with('{') { "" } else { "," };
    let field = if pretty {
        let value = serde_json::to_string_pretty(made).expect("plain values always serialise");
        let value = value.replace('\n', &format!("\n{indent}"));
        format!("{comma}\n{indent}\"{KEY}\": {value}")
    } else {
        format!("{comma}\"{KEY}\":{}", compact(made))
    };
    text.insert_str(end, &field);
    text
}

/// An SVG with a `<metadata>` element, the first in it, that holds `made` as JSON.
pub fn into_svg(text: &str, made: &MadeFrom) -> String {
    let start = text
        .find("<svg")
        .and_then(|at| text[at..].find('>').map(|end| at + end + 1));
    let Some(at) = start else {
        return text.to_owned();
    };
    let json = compact(made)
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;");
    let (head, tail) = text.split_at(at);
    format!("{head}<metadata id=\"{KEY}\">{json}</metadata>{tail}")
}

/// A table whose last column says how the cart is moved, where the command has `--cart` and the table does not say it
/// yet. A table over time is a record that other programs read, and stays as it is.
pub fn into_csv(table: Vec<u8>, made: &MadeFrom) -> Vec<u8> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .from_reader(table.as_slice());
    let mut rows = reader.records().map_while(Result::ok);
    let Some(header) = rows.next() else {
        return table;
    };
    let has = |name: &str| header.iter().position(|column| column == name);
    let says = has("cart").is_some() || has("time_s").is_some();
    if says || !made.has_cart || made.rigs.is_empty() {
        return table;
    }
    let named = has("rig");
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut write = |row: &csv::StringRecord, last: &str| {
        let row = row.iter().chain([last]);
        writer
            .write_record(row)
            .expect("writing to memory cannot fail");
    };
    write(&header, "cart");
    for row in rows {
        let of_row = |rig: &&RigUsed| named.and_then(|at| row.get(at)) == Some(&rig.name);
        let rig = made.rigs.iter().find(of_row).unwrap_or(&made.rigs[0]);
        write(&row, &rig.cart);
    }
    writer.into_inner().expect("writing to memory cannot fail")
}

/// Bytes before the first chunk after the header: the signature (8) and IHDR (12 + 13).
const PNG_HEAD: usize = 33;

/// A PNG with a text chunk `Software` and an international text chunk of the keyword [`KEY`], behind its header.
pub fn into_png(bytes: Vec<u8>, made: &MadeFrom) -> Vec<u8> {
    if bytes.len() < PNG_HEAD || &bytes[1..4] != b"PNG" {
        return bytes;
    }
    let software = format!("Software\0{} {}", made.program, made.version);
    // Not compressed, no language, no translated keyword.
    let made = format!("{KEY}\0\0\0\0\0{}", compact(made));
    let mut with = bytes[..PNG_HEAD].to_vec();
    chunk(&mut with, *b"tEXt", software.as_bytes());
    chunk(&mut with, *b"iTXt", made.as_bytes());
    with.extend_from_slice(&bytes[PNG_HEAD..]);
    with
}

fn chunk(out: &mut Vec<u8>, kind: [u8; 4], data: &[u8]) {
    let length = u32::try_from(data.len()).expect("a text shorter than 4 GiB");
    out.extend(length.to_be_bytes());
    let begin = out.len();
    out.extend(kind);
    out.extend(data);
    let sum = crc32fast::hash(&out[begin..]);
    out.extend(sum.to_be_bytes());
}
