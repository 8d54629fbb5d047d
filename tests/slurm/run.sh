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
export PATH=$PATH:/usr/sbin NODEVICE_SELECT=1
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

# The processes of this name that were started from here, as their environment or their folder says.
our_processes() {
    local folder
    for folder in /proc/[0-9]*; do
        [ "$(cat "$folder/comm" 2>/dev/null)" = "$1" ] || continue
        if tr '\0' '\n' 2>/dev/null <"$folder/environ" | grep -q -x -F "SLURM_CONF=$place/slurm.conf"; then basename "$folder"; fi
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
SchedulerParameters=batch_sched_delay=1,sched_interval=2,bf_interval=2,requeue_setup_env_fail
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

# The numbers of the processes of our program.
rendering() { our_processes gpu-rt | head -n 1; }
renders() { [ -n "$(rendering)" ]; }
parts_are_there() { [ "$(find job/parts -name '*.exr' | wc -l)" -ge "$1" ]; }
state_of() { scontrol show job "$1" 2>/dev/null | grep -o 'JobState=[A-Z]*' | head -n 1; }

until_so "a task renders" renders
victim=$(rendering)
kill -KILL "$victim"
echo "$((SECONDS - started)) s: killed the program $victim"
# A task that runs now is told to end, as before its time is over.
until_so "a part is there" parts_are_there 1
running() { squeue --noheader --jobs="$array" --states=running --format=%i | head -n 1; }
told=
tell_one_to_end() {
    told=$(running)
    [ -n "$told" ] && scancel --batch --signal=TERM "$told"
}
until_so "a task runs" tell_one_to_end
echo "$((SECONDS - started)) s: told the task $told to end"
# A node fails, and with it what watches over its tasks. A task itself may go on, as a lost daemon leaves it.
until_so "a second part is there" parts_are_there 2
on_b() { [ -n "$(squeue --noheader --nodelist=b --states=running --format=%i)" ]; }
until_so "a task runs on the node b" on_b
kill -KILL "${daemons[slurmd-b]}"
unset "daemons[slurmd-b]"
echo "$((SECONDS - started)) s: killed the daemon of the node b"
is_down() { sinfo --noheader --nodes=b --format=%t | grep -q '^down'; }
until_so "the node b is down" is_down
echo "$((SECONDS - started)) s: the node b is down"

done_merging() { case $(state_of "$merge") in JobState=COMPLETED | JobState=FAILED | JobState=CANCELLED | JobState=TIMEOUT) true ;; *) false ;; esac }
until_so "the parts are joined" done_merging
echo "$((SECONDS - started)) s: the join has ended, $(state_of "$merge")"
test "$(state_of "$merge")" = JobState=COMPLETED
grep -q -h requeue "$place/slurmctld.log"

(cd job && "$gpu_rt" render scene/weekend.ron --size "$size" --spp 256 --quiet -o ../one.exr)
# `merge` leaves the times out of the header. All else is to be equal.
for image in one.exr job/weekend.exr; do "$gpu_rt" merge --quiet "$image" -o "$(basename "$image" .exr)-without-times.exr"; done
cmp one-without-times.exr weekend-without-times.exr
echo "$((SECONDS - started)) s: the bytes are those of one process"
