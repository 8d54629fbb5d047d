
# A task of a render that many share. Its number is Slurm's index in the array, or the first argument. The tasks take the lines of
# parts.txt in turn: number T renders the lines T + 1, T + 1 + the number of tasks, and so on.
# GPU_RT names another program. What is changed here is lost when `gpu-rt submit` writes the folder again.

child=
signalled=
# The program writes what it has when the time is nearly up. The shell starts it so that it ignores SIGINT.
pass_on() {
    signalled=yes
    [ -z "$child" ] || kill -TERM "$child" 2>/dev/null
}
trap pass_on TERM INT HUP

case $task in
'' | *[!0-9]*) task=$tasks ;;
esac
if [ "$task" -ge "$tasks" ]; then
    echo "error: give the number of the task, from 0 to $((tasks - 1))" >&2
    exit 2
fi
# Slurm runs a copy of this file, which lies elsewhere.
here=$(dirname "$0")
[ -f "$here/job.json" ] || here=$folder
cd "$here" || exit 2

# A GPU for each task. CUDA_VISIBLE_DEVICES means nothing to Vulkan, which shows all GPUs of a node unless Slurm hides them
# (ConstrainDevices): there nvidia-smi finds the one of this task or none, and the default is right.
gpu=${SLURM_JOB_GPUS:-${CUDA_VISIBLE_DEVICES:-}}
if [ "$device" = auto ] && [ -n "$gpu" ]; then
    if bus=$(nvidia-smi --id="${gpu%%,*}" --query-gpu=pci.bus_id --format=csv,noheader 2>/dev/null) && [ -n "$bus" ]; then
        # 00000000:3B:00.0 is 0000:3b:00.0 elsewhere.
        set -- "$@" --device "$(echo "$bus" | tr 'A-F' 'a-f' | sed 's/^0000\(....:\)/\1/')"
    fi
fi

# The exit status of the program, which a signal to this script does not end at once.
finish() {
    wait "$child"
    status=$?
    while [ -n "$signalled" ]; do
        signalled=
        stopped=yes
        wait "$child"
        again=$?
        # 127: it had ended before.
        [ "$again" -eq 127 ] || status=$again
    done
    child=
}

# Slurm itself starts a task again after the failure of a node or for another job, and not after a limit of time or memory. What a user
# has cancelled stays so: Slurm is then completing the job, and would start it again if it were asked to.
try_again() {
    tries=log/$task.tries
    tried=$(cat "$tries" 2>/dev/null) || tried=0
    [ -n "${SLURM_ARRAY_JOB_ID:-}" ] && [ "$tried" -lt 5 ] || exit "$1"
    job=${SLURM_ARRAY_JOB_ID}_$task
    case $(scontrol show job "$job" 2>/dev/null) in *JobState=COMPLETING* | *JobState=CANCELLED*) exit "$1" ;; esac
    echo $((tried + 1)) >"$tries"
    scontrol requeue "$job"
    exit "$1"
}

line=0
stopped=
while read -r part <&3; do
    mine=$((line % tasks))
    line=$((line + 1))
    [ "$mine" -eq "$task" ] || continue
    [ -z "$stopped" ] || try_again 143
    # shellcheck disable=SC2059
    image=$(printf "$name" "${part%..*}" "${part#*..}")
    "$gpu_rt" render "$scene" --samples "$part" -o "$image" --resume=auto --quiet "$@" 3<&- &
    child=$!
    [ -z "$signalled" ] || pass_on
    finish
    if [ "$status" -ge 128 ]; then
        try_again "$status"
    elif [ "$status" -ne 0 ]; then
        echo "error: the samples $part ended with status $status" >&2
        exit "$status"
    fi
done 3<parts.txt || exit 2
rm -f "log/$task.tries"
