#!/usr/bin/env bash
# gnu_parallel.sh N DIR STUDY [options]: a study in N parts, several at a time, merged in DIR. As in
#   gnu_parallel.sh 8 out/atlas stability atlas --quick
# GNU parallel runs one part a core; with PARALLEL="--sshloginfile hosts --workdir ." parts go to other machines too, which
# must see DIR and have the same mss. Run again after an interruption, it continues. MSS is the program, mss unless set.
set -euo pipefail

parts=$1 directory=$2
shift 2
mss=${MSS:-mss}
parallel --halt soon,fail=1 "$mss" "$@" --processes 1 --part "{}/$parts" --out "$directory/part{}" ::: $(seq "$parts")
"$mss" merge "$directory"/part* --out "$directory"
