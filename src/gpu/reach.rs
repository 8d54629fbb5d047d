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
    let mut by_name: HashMap<&str, Vec<usize>> = HashMap::new();
    for (i, declaration) in declarations.iter().enumerate() {
        declaration.name.iter().for_each(|name| by_name.entry(*name).or_default().push(i));
    }
    let code_of = |i: usize| declarations[i].lines.clone().map(|line| code(lines[line]));
    let is_entry = |i: &usize| code_of(*i).any(|code| code.contains("@compute"));
    let all = !(0..declarations.len()).any(|i| is_entry(&i));
    // Text without a name, such as a stray word, is kept, so that the parser reports it.
    let starts = |i: &usize| all || is_entry(i) || declarations[*i].name.is_none();
    let mut waiting: Vec<usize> = (0..declarations.len()).filter(starts).collect();
    let mut kept: BTreeSet<usize> = waiting.iter().copied().collect();
    while let Some(i) = waiting.pop() {
        for j in code_of(i).flat_map(mentioned).filter_map(|word| by_name.get(word)).flatten() {
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
        let declaration = open.get_or_insert(Declaration { name: None, lines: number..number });
        declaration.lines.end = number + 1;
        declaration.name = declaration.name.or_else(|| declared(code));
        for c in code.bytes() {
            depth += i64::from(matches!(c, b'{' | b'(' | b'[')) - i64::from(matches!(c, b'}' | b')' | b']'));
        }
        if depth <= 0 && (code.ends_with(';') || code.ends_with('}')) {
            found.extend(open.take());
            depth = 0;
        }
    }
    found.extend(open);
    found
}

/// The words of a line, each with its place.
pub fn words(code: &str) -> impl Iterator<Item = (usize, &str)> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut at = 0;
    std::iter::from_fn(move || {
        let start = at + code[at..].find(is_word)?;
        at = code[start..].find(|c| !is_word(c)).map_or(code.len(), |length| start + length);
        Some((start, &code[start..at]))
    })
}

/// The name that a line declares: the first word after the keyword, and after the angle brackets of `var`.
fn declared(code: &str) -> Option<&str> {
    const KEYWORDS: [&str; 6] = ["fn", "const", "override", "struct", "alias", "var"];
    // `var<storage, read_write> name`: the words between the brackets are not names.
    let name_from = match code.split_once("var<").and_then(|(_, rest)| rest.split_once('>')) {
        Some((_, rest)) => code.len() - rest.len(),
        None => 0,
    };
    let mut words = words(code).skip_while(|(_, word)| !KEYWORDS.contains(word)).skip(1);
    words.find(|(start, _)| *start >= name_from).map(|(_, word)| word)
}

/// The words of a line that may be names of declarations: not those that only name a member, a parameter or a variable.
fn mentioned(code: &str) -> impl Iterator<Item = &str> {
    let is_case = code.trim_start().starts_with("case ");
    let mentions = move |(start, word): &(usize, &str)| {
        !code[..*start].ends_with('.') && (is_case || !code[start + word.len()..].starts_with(':'))
    };
    words(code).filter(mentions).map(|(_, word)| word)
}
