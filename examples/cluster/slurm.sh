#!/usr/bin/env bash
#SBATCH --job-name=goldtof
#SBATCH --cpus-per-task=1
#SBATCH --output=goldtof-%A-%a.log
# A command of goldtof's in shards, one for each task of an array. Tasks are numbered from 1:
#
#   sbatch --array=1-20 --wait examples/cluster/slurm.sh sweep SCENE --over ... --out out/sweep
#   goldtof merge out/sweep
#
# What was lost on the way (a node, a time limit) once more, with the number of all shards
# in SHARDS:
#
#   SHARDS=20 sbatch --array="$(goldtof merge --missing out/sweep)" --wait \
#       examples/cluster/slurm.sh sweep SCENE --over ... --out out/sweep
set -euo pipefail

# As many threads as the task has cores.
export RAYON_NUM_THREADS=${SLURM_CPUS_PER_TASK:-1}
exec goldtof "$@" --quiet --shard "task${SHARDS:+/$SHARDS}"
