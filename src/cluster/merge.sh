
# Joins the parts of a render that many have shared. If one lacks samples, this fails and says which.
# GPU_RT names another program. What is changed here is lost when `gpu-rt submit` writes the folder again.

# Slurm runs a copy of this file, which lies elsewhere.
here=$(dirname "$0")
[ -f "$here/job.json" ] || here=$folder
cd "$here" || exit 2
"$gpu_rt" merge parts --samples "$samples" --output="$output" "$@" || exit
[ -n "$noise" ] || exit 0
# A render until an error goes on with the next round, unless this one was enough.
if [ -n "${SLURM_JOB_ID:-}" ]; then
    "$gpu_rt" submit slurm --next .
else
    "$gpu_rt" submit slurm --next . --dry-run
fi
