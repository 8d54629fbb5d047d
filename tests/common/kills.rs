//! Kills the program at chosen system calls.

use std::fs;
use std::io;
use std::os::unix::fs::FileExt;
use std::os::unix::process::CommandExt;
use std::process::Command;

/// The calls that touch files, and so those at which a kill can leave a file in another state.
const OF_FILES: [libc::c_long; 15] = [
    libc::SYS_openat,
    libc::SYS_write,
    libc::SYS_pwrite64,
    libc::SYS_lseek,
    libc::SYS_fsync,
    libc::SYS_fdatasync,
    libc::SYS_ftruncate,
    libc::SYS_flock,
    libc::SYS_fchmod,
    libc::SYS_fchown,
    libc::SYS_renameat,
    libc::SYS_renameat2,
    libc::SYS_linkat,
    libc::SYS_unlinkat,
    RENAME,
];
#[cfg(target_arch = "x86_64")]
const RENAME: libc::c_long = libc::SYS_rename;
#[cfg(not(target_arch = "x86_64"))]
const RENAME: libc::c_long = libc::SYS_renameat;

/// Runs the program until just before its `call`-th call on files, counted from 1 since it first made a temporary file for an output, and
/// kills it there. The result is whether it was: the program may end before.
pub fn kill_before(mut command: Command, call: usize) -> bool {
    // SAFETY: the child calls one function of the system before it becomes the program.
    unsafe {
        command.pre_exec(|| match libc::ptrace(libc::PTRACE_TRACEME, 0, 0, 0) {
            0 => Ok(()),
            _ => Err(io::Error::last_os_error()),
        });
    }
    // The threads of the program are waited for by their group, so that no other child of this process is.
    let mut child = command.process_group(0).spawn().expect("the program starts, and can be traced");
    let pid = child.id() as libc::pid_t;
    let (mut status, mut calls, mut begun, mut killed) = (0, 0, false, false);
    // SAFETY: the process is a child that is traced by this thread; all pointers are to values that live.
    unsafe {
        assert_eq!(libc::waitpid(pid, &raw mut status, libc::__WALL), pid);
        let options = libc::PTRACE_O_TRACESYSGOOD | libc::PTRACE_O_TRACECLONE | libc::PTRACE_O_EXITKILL;
        assert_eq!(libc::ptrace(libc::PTRACE_SETOPTIONS, pid, 0, options), 0);
        libc::ptrace(libc::PTRACE_SYSCALL, pid, 0, 0);
        loop {
            let thread = libc::waitpid(-pid, &raw mut status, libc::__WALL);
            if thread <= 0 {
                break;
            }
            if !libc::WIFSTOPPED(status) {
                continue;
            }
            let mut signal = libc::WSTOPSIG(status);
            if signal == libc::SIGTRAP | 0x80 {
                signal = 0;
                let mut info: libc::ptrace_syscall_info = std::mem::zeroed();
                libc::ptrace(libc::PTRACE_GET_SYSCALL_INFO, thread, size_of_val(&info), &raw mut info);
                if info.op == libc::PTRACE_SYSCALL_INFO_ENTRY && !killed {
                    let number = info.u.entry.nr as libc::c_long;
                    let [_, path, flags, ..] = info.u.entry.args;
                    begun |= number == libc::SYS_openat && (has_no_name(flags) || is_temporary(pid, path));
                    calls += usize::from(begun && OF_FILES.contains(&number));
                    if calls == call {
                        killed = true;
                        libc::kill(pid, libc::SIGKILL);
                    }
                }
            } else if signal == libc::SIGTRAP || signal == libc::SIGSTOP {
                // A new thread stops.
                signal = 0;
            }
            libc::ptrace(libc::PTRACE_SYSCALL, thread, 0, signal);
        }
    }
    // It has been waited for above; this frees the handle.
    let _ = child.wait();
    killed
}

/// Whether these flags open a file without a name, as temporary files are where the system can.
fn has_no_name(flags: u64) -> bool {
    flags as libc::c_int & libc::O_TMPFILE == libc::O_TMPFILE
}

/// Whether the path at an address of the process names a temporary file of an output.
fn is_temporary(pid: libc::pid_t, address: u64) -> bool {
    let mut path = [0; 256];
    let memory = fs::File::open(format!("/proc/{pid}/mem"));
    let read = memory.and_then(|memory| memory.read_at(&mut path, address)).unwrap_or(0);
    let path = String::from_utf8_lossy(&path[..read]);
    path.split('\0').next().is_some_and(|path| path.contains("/.gpu-rt-") || path.starts_with(".gpu-rt-"))
}
