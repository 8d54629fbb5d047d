//! Finds the declarations of a joined shader that its entry point reaches, directly or through others. The linker
//! removes the rest, and comments, so that a kernel contains only code that it can run.

use std::collections::{BTreeSet, HashMap};

/// For each line, whether it belongs to a declaration that an entry point reaches. In a text without an entry point all
/// lines count.
///
/// A declaration begins at the start of a line and ends with the `;` or `}` that leaves no bracket open. Names are
/// compared as words. If a local variable has the name of a declaration, the declaration may be kept unnecessarily, but
/// none is ever missing.
pub fn reached(lines: &[&str]) -> Vec<bool> {
    let declarations = declarations(lines);
    let by_name: HashMap<&str, Vec<usize>> = declarations.iter().enumerate().fold(HashMap::new(), |mut all, (i, d)| {
        d.name.iter().for_each(|name| all.entry(*name).or_insert_with(Vec::new).push(i));
        all
    });
    let is_entry = |d: &Declaration<'_>| d.words.contains("@compute");
    let all = !declarations.iter().any(is_entry);
    // Text without a name, such as a stray word, is kept, so that the parser reports it.
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
        own.filter(|line| !code(lines[*line]).trim().is_empty()).for_each(|line| reached[line] = true);
    }
    reached
}

/// The names that these lines declare.
pub fn names<'a>(lines: &[&'a str]) -> Vec<&'a str> {
    declarations(lines).into_iter().filter_map(|declaration| declaration.name).collect()
}

/// A line without its comment.
pub fn code(line: &str) -> &str {
    line.split_once("//").map_or(line, |(code, _)| code).trim_end()
}

struct Declaration<'a> {
    name: Option<&'a str>,
    lines: std::ops::Range<usize>,
    /// Words that may be names of other declarations, and `@compute` for an entry point.
    words: BTreeSet<&'a str>,
}

fn declarations<'a>(lines: &[&'a str]) -> Vec<Declaration<'a>> {
    let mut found = Vec::new();
    let mut open: Option<Declaration<'a>> = None;
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

/// Collects the words of a line, except those that only name a member, a parameter or a variable of this declaration.
/// The first word after the keyword, and after the angle brackets of `var`, is the declaration's name.
fn take_words<'a>(code: &'a str, declaration: &mut Declaration<'a>) {
    const KEYWORDS: [&str; 6] = ["fn", "const", "override", "struct", "alias", "var"];
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    // `var<storage, read_write> name`: the words between the brackets are not names.
    let name_from = match code.split_once("var<").and_then(|(_, rest)| rest.split_once('>')) {
        Some((_, rest)) => code.len() - rest.len(),
        None => 0,
    };
    let is_case = code.trim_start().starts_with("case ");
    let mut behind_keyword = false;
    let mut at = 0;
    while let Some(start) = code[at..].find(is_word).map(|start| at + start) {
        let end = code[start..].find(|c| !is_word(c)).map_or(code.len(), |length| start + length);
        let word = &code[start..end];
        let before = code[..start].chars().next_back();
        at = end;
        if declaration.name.is_none() && behind_keyword && start >= name_from {
            declaration.name = Some(word);
        } else if declaration.name.is_none() && KEYWORDS.contains(&word) {
            behind_keyword = true;
        } else if word == "compute" && before == Some('@') {
            declaration.words.insert("@compute");
        } else if before != Some('.') && (is_case || !code[end..].starts_with(':')) {
            declaration.words.insert(word);
        }
    }
}
