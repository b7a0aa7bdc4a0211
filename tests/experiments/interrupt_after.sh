#!/usr/bin/env bash
# interrupt_after.sh SECONDS COMMAND [ARGUMENT...]: runs a command, and interrupts it as Ctrl-C does once it has computed for so
# long: of processor time, so that it has come as far on a busy machine. Ends with its exit status.
set -euo pipefail
set -m  # else commands in the background ignore interrupts

ticks=$(($1 * $(getconf CLK_TCK)))
shift
"$@" &
while read -r -a stat 2>/dev/null <"/proc/$!/stat" && ((stat[13] + stat[14] < ticks)); do sleep 0.02; done
kill -INT $! 2>/dev/null || true
wait $!
