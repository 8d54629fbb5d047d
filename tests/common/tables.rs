//! The tables of docs/files.md, compared with what the program writes.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;

/// What the tables below a heading have in backticks in their first column.
pub fn rows(heading: &str) -> BTreeSet<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/files.md");
    let text = std::fs::read_to_string(path).expect("the document is there");
    let below = text.lines().skip_while(|line| *line != heading).skip(1);
    let table = below.take_while(|line| !line.starts_with('#')).filter(|line| line.starts_with("| `"));
    let first = table.filter_map(|line| line.split(" | ").next());
    first.flat_map(|cell| cell.split('`').skip(1).step_by(2)).map(str::to_owned).collect()
}

/// The paths of all values of a JSON object: `a.b`, `a[].b`.
fn paths(value: &Value) -> Vec<String> {
    let below = |step: &str, value: &Value| paths(value).into_iter().map(move |rest| format!("{step}{rest}")).collect();
    match value {
        Value::Object(fields) if !fields.is_empty() => {
            let all = fields.iter().flat_map(|(name, value)| -> Vec<String> { below(&format!(".{name}"), value) });
            all.collect()
        }
        Value::Array(items) if items.iter().any(Value::is_object) => {
            items.iter().flat_map(|item| -> Vec<String> { below("[]", item) }).collect()
        }
        _ => vec![String::new()],
    }
}

/// The row of a path: its own, or that of what is around it, where that has no rows below it.
fn row_of<'a>(rows: &'a BTreeSet<String>, path: &str) -> Option<&'a String> {
    let is_inside =
        |inner: &str, outer: &str| inner.strip_prefix(outer).is_some_and(|rest| rest.starts_with(['.', '[']));
    rows.get(path).or_else(|| {
        let leaf = |row: &&String| !rows.iter().any(|other| is_inside(other, row));
        rows.iter().filter(|row| is_inside(path, row)).find(leaf)
    })
}

/// What is wrong with the rows for these objects.
fn differences(rows: &BTreeSet<String>, objects: &[Value]) -> Vec<String> {
    let found: BTreeSet<String> = objects.iter().flat_map(paths).map(|path| path[1..].to_owned()).collect();
    let missing = found.iter().filter(|path| row_of(rows, path).is_none());
    let missing = missing.map(|path| format!("no row has {path}"));
    let listed: BTreeSet<_> = found.iter().filter_map(|path| row_of(rows, path)).collect();
    let idle = rows.iter().filter(|row| !listed.contains(row)).map(|row| format!("nothing has {row}"));
    missing.chain(idle).collect()
}

/// Compares the table below a heading of docs/files.md with JSON objects: it has the keys of all of them, and no others.
#[track_caller]
pub fn compare(heading: &str, objects: &[Value]) {
    let rows = rows(heading);
    assert!(rows.len() > 3, "{heading} has no table");
    assert_eq!(differences(&rows, objects), Vec::<String>::new(), "docs/files.md, {heading}");
    // Negative control: a row too many, and one too few.
    let mut other = rows.clone();
    other.insert("nothing".to_owned());
    assert_eq!(differences(&other, objects), ["nothing has nothing"]);
    let first = rows.first().expect("there is a row");
    other = rows.iter().filter(|row| *row != first).cloned().collect();
    assert_ne!(differences(&other, objects), Vec::<String>::new());
}
