#!/usr/bin/env bash
# slurm_array.sh N DIR STUDY [options]: a study in N parts as an array of Slurm jobs of one core each, and a job after them that
# merges in DIR, which all nodes must see. As in
#   slurm_array.sh 64 /shared/atlas stability atlas
# Options of sbatch come from its environment, as in SBATCH_PARTITION=long SBATCH_TIMELIMIT=4:00:00. If jobs fail the merge
# does not start; run it again and finished cases are not repeated. MSS is the program, mss unless set.
set -euo pipefail

parts=$1 directory=$2
shift 2
mss=${MSS:-mss}
mkdir -p "$directory"
study=$(printf ' %q' "$mss" "$@")
array=$(sbatch --parsable --array="1-$parts" --cpus-per-task=1 --output="$directory/part%a.log" \
  --wrap="$study --processes 1 --part \$SLURM_ARRAY_TASK_ID/$parts --out $(printf %q "$directory")/part\$SLURM_ARRAY_TASK_ID")
merge=$(printf ' %q' "$mss" merge $(seq --format="$directory/part%.0f" "$parts") --out "$directory")
sbatch --dependency="afterok:$array" --kill-on-invalid-dep=yes --output="$directory/merge.log" --wrap="$merge"
