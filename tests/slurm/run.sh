#!/usr/bin/env bash
# A render over a real Slurm: two nodes on this machine, a killed program, a task that is told to end, and a node that fails. The image must
# have the bytes of one process. It needs slurm-wlm and munge (`make test-slurm` installs them), and root.
#
# GPU_RT_BIN names the program. Everything lies in a temporary folder, and it ends only the processes that it started.
set -euo pipefail

root=$(cd "$(dirname "$0")/../.." && pwd)
gpu_rt=$(realpath "${GPU_RT_BIN:-$root/target/release/gpu-rt}")
size=${GPU_RT_SLURM_SIZE:-320x180}
place=$(mktemp -d /tmp/gpu-rt-slurm.XXXXXX)
export PATH=$PATH:/usr/sbin:/sbin NODEVICE_SELECT=1
export SLURM_CONF=$place/slurm.conf

# The daemons that this script has started, by their names.
declare -A daemons=()
stop() {
    local status=$? name
    trap - EXIT
    if [ "$status" -ne 0 ]; then
        echo "FAILED. What the daemons and the tasks said last:" >&2
        tail -n 15 "$place"/*.log "$place"/job/log/* >&2 || true
    fi
    # Jobs first: their processes are children of daemons.
    [ -z "${daemons[slurmctld]:-}" ] || timeout 5 scancel --user=root || true
    sleep 1
    for name in "${!daemons[@]}"; do kill -TERM "${daemons[$name]}" 2>/dev/null || true; done
    for name in "${!daemons[@]}"; do
        for _ in $(seq 50); do kill -0 "${daemons[$name]}" 2>/dev/null || break; sleep 0.1; done
        kill -KILL "${daemons[$name]}" 2>/dev/null || true
    done
    # A daemon that was killed leaves those that watch over its tasks.
    our_processes slurmstepd | while read -r process; do kill -KILL "$process" 2>/dev/null || true; done
    our_processes gpu-rt | while read -r process; do kill -KILL "$process" 2>/dev/null || true; done
    rm -rf "$place"
    exit "$status"
}
trap stop EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

# A variable of a process.
variable() { { tr '\0' '\n' <"/proc/$1/environ"; } 2>/dev/null | sed -n "s|^$2=||p"; }

# The processes of this name that have the configuration of this test in their environment.
our_processes() {
    local folder name
    for folder in /proc/[0-9]*; do
        { read -r name <"$folder/comm"; } 2>/dev/null || continue
        [ "$name" = "$1" ] || continue
        [ "$(variable "${folder#/proc/}" SLURM_CONF)" != "$SLURM_CONF" ] || echo "${folder#/proc/}"
    done
}

# Waits until a command succeeds.
until_so() {
    local what=$1
    shift
    for _ in $(seq 600); do
        if "$@"; then return 0; fi
        sleep 0.2
    done
    echo "never: $what" >&2
    return 1
}

free_port() {
    local port
    while :; do
        port=$((20000 + RANDOM % 20000))
        (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null || { echo "$port"; return; }
    done
}

daemon() {
    local name=$1
    shift
    "$@" >"$place/$name.out.log" 2>&1 &
    daemons[$name]=$!
}

# Munge: a key and a socket of its own.
mkdir -m 755 "$place/munge" "$place/state" "$place/a" "$place/b"
dd if=/dev/urandom of="$place/munge/key" bs=1024 count=1 status=none
chmod 755 "$place"
chmod 400 "$place/munge/key"
daemon munged munged --foreground --force --key-file="$place/munge/key" --socket="$place/munge/socket" \
    --pid-file="$place/munge/pid" --log-file="$place/munge.log" --seed-file="$place/munge/seed"
until_so "munged answers" test -S "$place/munge/socket"

# Slurm: two nodes of one processor each on this host, and no accounting.
read -r control node_a node_b <<<"$(free_port) $(free_port) $(free_port)"
cat >"$SLURM_CONF" <<END
ClusterName=here
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$place/munge/socket
CredType=cred/munge
SlurmctldPort=$control
StateSaveLocation=$place/state
SlurmctldPidFile=$place/slurmctld.pid
SlurmdPidFile=$place/%n.pid
SlurmdSpoolDir=$place/%n
SlurmctldLogFile=$place/slurmctld.log
SlurmdLogFile=$place/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=1,sched_interval=2,bf_interval=2
MpiDefault=none
SwitchType=switch/none
ReturnToService=2
SlurmdTimeout=10
SlurmctldTimeout=60
InactiveLimit=0
KillWait=5
MinJobAge=60
JobRequeue=1
MaxArraySize=65
SlurmdParameters=config_overrides
NodeName=a NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=$node_a CPUs=1 RealMemory=1000
NodeName=b NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=$node_b CPUs=1 RealMemory=1000
PartitionName=all Nodes=a,b Default=YES MaxTime=INFINITE State=UP
END
# Nothing here uses cgroups; this plugin needs no service to start.
echo CgroupPlugin=cgroup/v1 >"$place/cgroup.conf"
daemon slurmctld slurmctld -D
daemon slurmd-a slurmd -D -N a
daemon slurmd-b slurmd -D -N b
nodes_are_idle() { [ "$(sinfo --noheader --Node --format=%t 2>/dev/null | grep -c -x idle)" = 2 ]; }
until_so "two nodes are idle" nodes_are_idle
echo "slurm: $(sinfo --version), two nodes"

# One process, in a folder like that of the job, so that the header has the same name of the scene.
started=$SECONDS
cd "$place"
said=$("$gpu_rt" submit slurm "$root/scenes/weekend.ron" --size "$size" --spp 256 --parts 8 --checkpoint 1s -o job \
    -- --time=10 --ntasks=1)
echo "$said"
array=$(sed -n 's/^array: //p' <<<"$said")
merge=$(sed -n 's/^merge: //p' <<<"$said")

# A task has been started again if its count of tries says so. Slurm has it wait for two minutes, which nobody here does.
again() { [ "$(cat job/log/*.tries 2>/dev/null | wc -l)" -ge "$1" ]; }
at_once() {
    local task
    for task in $(squeue --noheader --jobs="$array" --states=pending --format='%i %r' | sed -n 's/ BeginTime$//p'); do
        scontrol update JobId="$task" StartTime=now || true
    done
}

kill_one() {
    local victim
    victim=$(our_processes gpu-rt | head -n 1)
    [ -z "$victim" ] || kill -KILL "$victim" || true
    sleep 0.2
    again 1
}
until_so "a task whose program is killed tries again" kill_one
echo "$((SECONDS - started)) s: killed a program"

# As Slurm does before the time of a task is over: the script alone is told.
tell_one() {
    local process task
    process=$(our_processes gpu-rt | head -n 1)
    task=$(variable "${process:-0}" SLURM_ARRAY_TASK_ID)
    # It delivers the signal, and then may wait for a minute because the task is not what it was.
    [ -z "$task" ] || timeout 1 scancel --quiet --batch --signal=TERM "${array}_$task" 2>/dev/null || true
    for _ in $(seq 20); do sleep 0.1; if again 2; then return 0; fi; done
    return 1
}
until_so "a task that is told to end tries again" tell_one
echo "$((SECONDS - started)) s: told a task to end"

# A node is lost: its daemon, and what ran the task there. The program itself goes on, as it may. Slurm calls the node down, and starts the
# task on the other one: two write one part.
lose_b() {
    local process lost=
    at_once
    for process in $(our_processes gpu-rt); do
        [ "$(variable "$process" SLURMD_NODENAME)" = b ] || continue
        lost=$(sed -n 's/^PPid:[^0-9]*//p' "/proc/$process/status") || continue
        kill -KILL "${daemons[slurmd-b]}" "$(sed -n 's/^PPid:[^0-9]*//p' "/proc/$lost/status")" "$lost" || true
        wait "${daemons[slurmd-b]}" 2>/dev/null || true
        unset "daemons[slurmd-b]"
        return 0
    done
    return 1
}
until_so "a task renders on the node b" lose_b
echo "$((SECONDS - started)) s: lost the node b"
is_down() { sinfo --noheader --nodes=b --format=%t | grep -q '^down'; }
until_so "the node b is down" is_down
echo "$((SECONDS - started)) s: the node b is down"

state() { scontrol show job "$merge" | sed -n 's/^ *JobState=\([A-Z]*\).*/\1/p'; }
joined() {
    at_once
    case $(state) in COMPLETED | FAILED | CANCELLED | TIMEOUT) true ;; *) false ;; esac
}
until_so "the parts are joined" joined
echo "$((SECONDS - started)) s: the join is $(state)"
[ "$(state)" = COMPLETED ]
grep -q "requeue.*due to failure of node b" "$place/slurmctld.log"
cat job/log/merge_*

(cd job && "$gpu_rt" render scene/weekend.ron --size "$size" --spp 256 --quiet -o ../one.exr)
# `merge` leaves the times out of the header, and puts its own command line there. All else is to be equal.
for image in one.exr job/weekend.exr; do
    folder=$(basename "$image" .exr)-without-times
    mkdir "$folder"
    cp "$image" "$folder/image.exr"
    (cd "$folder" && "$gpu_rt" merge --quiet image.exr -o merged.exr)
done
cmp one-without-times/merged.exr weekend-without-times/merged.exr
echo "$((SECONDS - started)) s: the bytes are those of one process"
