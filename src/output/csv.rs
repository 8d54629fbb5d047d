//! Writes JSON objects as a table of comma-separated values.

use serde_json::Value;

/// The header, which names the columns, and a line for each object. A cell is empty if the object lacks the column or
/// its value is null.
pub fn csv(header: &str, rows: &[Value]) -> String {
    let cell = |value: &Value| match value {
        Value::Null => String::new(),
        Value::String(text) if text.contains([',', '"', '\n']) => format!("\"{}\"", text.replace('"', "\"\"")),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    let line = |row: &Value| header.split(',').map(|column| cell(&row[column])).collect::<Vec<_>>().join(",");
    let lines: Vec<String> = rows.iter().map(|row| line(row) + "\n").collect();
    format!("{header}\n{}", lines.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        let row = serde_json::json!({"a": "1, \"2\"", "b": null, "c": 0.5, "d": "plain", "unused": 7});
        assert_eq!(csv("a,b,c,d,e", &[row]), "a,b,c,d,e\n\"1, \"\"2\"\"\",,0.5,plain,\n");
    }
}
