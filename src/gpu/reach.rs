//! What of a joined shader its entry point reaches: the declarations that it names, and those that they name. The rest is left out,
//! comments with it, so that a kernel has nothing but what it runs.

use std::collections::{BTreeSet, HashMap};

/// Which lines belong to a declaration that the entry points reach. A joined text without an entry point reaches all.
///
/// A declaration begins at the start of a line and ends with the `;` or `}` that leaves no bracket open. Names are compared as words: one
/// that also names something local may keep a declaration too many, never one too few.
pub fn reached(lines: &[String]) -> Vec<bool> {
    let declarations = declarations(lines);
    let by_name: HashMap<&str, Vec<usize>> = declarations.iter().enumerate().fold(HashMap::new(), |mut all, (i, d)| {
        d.name.iter().for_each(|name| all.entry(*name).or_insert_with(Vec::new).push(i));
        all
    });
    let is_entry = |d: &Declaration<'_>| d.words.contains("@compute");
    let all = !declarations.iter().any(is_entry);
    // What has no name of its own, such as a stray word, is kept for the parser to find.
    let starts = |d: &Declaration<'_>| all || is_entry(d) || d.name.is_none();
    let mut waiting: Vec<usize> = (0..declarations.len()).filter(|i| starts(&declarations[*i])).collect();
    let mut kept: BTreeSet<usize> = waiting.iter().copied().collect();
    while let Some(i) = waiting.pop() {
        for j in declarations[i].words.iter().filter_map(|word| by_name.get(word)).flatten() {
            if kept.insert(*j) {
                waiting.push(*j);
            }
        }
    }
    let mut reached = vec![false; lines.len()];
    for declaration in kept.iter().map(|i| &declarations[*i]) {
        let own = declaration.lines.clone();
        own.filter(|line| !code(&lines[*line]).trim().is_empty()).for_each(|line| reached[line] = true);
    }
    reached
}

/// A line without its comment.
pub fn code(line: &str) -> &str {
    line.split_once("//").map_or(line, |(code, _)| code).trim_end()
}

struct Declaration<'a> {
    name: Option<&'a str>,
    lines: std::ops::Range<usize>,
    /// Words that may name other declarations, and `@compute` of an entry point.
    words: BTreeSet<&'a str>,
}

fn declarations(lines: &[String]) -> Vec<Declaration<'_>> {
    let mut found = Vec::new();
    let mut open: Option<Declaration<'_>> = None;
    let mut depth = 0i64;
    for (number, line) in lines.iter().enumerate() {
        let code = code(line);
        if open.is_none() && code.trim().is_empty() {
            continue;
        }
        let declaration =
            open.get_or_insert_with(|| Declaration { name: None, lines: number..number, words: BTreeSet::new() });
        declaration.lines.end = number + 1;
        take_words(code, declaration);
        for c in code.chars() {
            depth += i64::from(matches!(c, '{' | '(' | '[')) - i64::from(matches!(c, '}' | ')' | ']'));
        }
        if depth <= 0 && (code.ends_with(';') || code.ends_with('}')) {
            found.extend(open.take());
            depth = 0;
        }
    }
    found.extend(open);
    found
}

/// The words of a line, but for members; the first one behind what begins a declaration is its name.
fn take_words<'a>(code: &'a str, declaration: &mut Declaration<'a>) {
    const KEYWORDS: [&str; 6] = ["fn", "const", "override", "struct", "alias", "var"];
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut behind_keyword = false;
    let mut angles = 0;
    let mut rest = code;
    while let Some(start) = rest.find(|c: char| is_word(c) || c == '<' || c == '>') {
        let before = rest[..start].chars().next_back();
        let at = &rest[start..];
        let end = at.find(|c| !is_word(c)).unwrap_or(at.len()).max(1);
        let word = &at[..end];
        rest = &at[end..];
        match word {
            // `var<uniform> name`: what stands between is no name.
            "<" => angles += i32::from(behind_keyword),
            ">" => angles -= i32::from(behind_keyword),
            _ if declaration.name.is_none() && behind_keyword && angles == 0 => {
                declaration.name = Some(word);
                behind_keyword = false;
            }
            "compute" if before == Some('@') => {
                declaration.words.insert("@compute");
            }
            _ if declaration.name.is_none() && KEYWORDS.contains(&word) => behind_keyword = true,
            _ if before == Some('.') => {}
            _ => {
                declaration.words.insert(word);
            }
        }
    }
}
