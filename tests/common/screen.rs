//! What a terminal gets of the program.

use std::fs::File;
use std::io::Read;
use std::os::fd::{FromRawFd, OwnedFd};
use std::process::{Command, Stdio};

use super::program::send;

/// Runs the program on a terminal of so many columns: all that it prints.
pub fn on_terminal(command: Command, columns: u16) -> String {
    interrupted_on_terminal(command, columns, libc::SIGINT, |_| false).1
}

/// Runs a command on a terminal, with a signal when what it has printed is enough. The result is the exit status, and all that it prints.
pub fn interrupted_on_terminal(
    mut command: Command,
    columns: u16,
    signal: i32,
    is_enough: impl Fn(&str) -> bool,
) -> (Option<i32>, String) {
    let size = libc::winsize { ws_row: 24, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
    let (mut ours, mut its) = (0, 0);
    // SAFETY: the numbers are written, and the size is read, during the call.
    let made = unsafe { libc::openpty(&mut ours, &mut its, std::ptr::null_mut(), std::ptr::null(), &size) };
    assert_eq!(made, 0, "a terminal is made");
    // SAFETY: both are open, and nobody else has them.
    let (ours, its) = unsafe { (OwnedFd::from_raw_fd(ours), OwnedFd::from_raw_fd(its)) };
    let copy = |file: &OwnedFd| Stdio::from(file.try_clone().expect("it can be copied"));
    command.stdin(copy(&its)).stdout(copy(&its)).stderr(copy(&its)).env("TERM", "xterm");
    let mut child = command.spawn().expect("the program starts");
    // The reading ends when nobody has the other end.
    drop((command, its));
    let (mut file, mut bytes, mut some, mut is_sent) = (File::from(ours), Vec::new(), [0; 4096], false);
    while let Ok(count @ 1..) = file.read(&mut some) {
        bytes.extend_from_slice(&some[..count]);
        if !is_sent && is_enough(&String::from_utf8_lossy(&bytes)) {
            send(&child, signal);
            is_sent = true;
        }
    }
    let status = child.wait().expect("the program ends");
    (status.code(), String::from_utf8(bytes).expect("UTF-8"))
}

/// What stands in the rows of a terminal in the end, from the first that was written to on. Colours are left out.
pub fn screen(text: &str) -> Vec<String> {
    let (mut rows, mut row, mut column) = (vec![Vec::new()], 0, 0);
    let mut rest = text.chars();
    while let Some(c) = rest.next() {
        match c {
            '\r' => column = 0,
            '\n' => row += 1,
            '\u{1b}' => {
                // ESC [ parameters letter
                let mut sequence = String::new();
                for c in rest.by_ref().skip(1) {
                    sequence.push(c);
                    if c.is_ascii_alphabetic() {
                        break;
                    }
                }
                let letter = sequence.pop();
                let number = sequence.parse();
                match letter {
                    Some('A') => row -= number.unwrap_or(1),
                    Some('B') => row += number.unwrap_or(1),
                    Some('K') => rows[row].clear(),
                    Some('m' | 'h' | 'l') => {}
                    _ => panic!("{sequence:?} {letter:?} is not known here"),
                }
            }
            c => {
                let cells = &mut rows[row];
                cells.resize(cells.len().max(column + 1), ' ');
                cells[column] = c;
                column += 1;
            }
        }
        rows.resize(rows.len().max(row + 1), Vec::new());
    }
    rows.iter().map(|row| row.iter().collect::<String>().trim_end().to_owned()).collect()
}

/// The pieces that stand on a line of their own: what is between ends of lines and returns, without the sequences that control the terminal.
pub fn rows(text: &str) -> Vec<String> {
    let mut plain = String::new();
    let mut rest = text.chars();
    while let Some(c) = rest.next() {
        match c {
            // ESC [ parameters letter
            '\u{1b}' => _ = rest.by_ref().skip(1).find(|c| c.is_ascii_alphabetic()),
            '\r' => plain.push('\n'),
            c => plain.push(c),
        }
    }
    plain.lines().filter(|line| !line.trim().is_empty()).map(|line| line.trim_end().to_owned()).collect()
}
