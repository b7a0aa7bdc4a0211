#!/usr/bin/env bash
# The whole check of a card, in one bounded call that waits for nobody: its devices, their tests, their times. Of an archive of pack.sh;
# the machine needs
# bash 5, coreutils, awk, sed, grep, find, ldd, tar, xz or Python 3, and the card's driver.
set -euo pipefail

usage() {
  cat >&2 <<'TEXT'
usage: tests/device/check.sh ARCHIVE OUT [--seconds N] [options of mss timing]

Writes to the folder OUT, which must be new or empty: devices.txt, tests.txt, timing.txt and the folder timing with the tables
(their charts are drawn later, where gnuplot is: mss redraw OUT/timing), machine.txt, card.csv, parts.csv and summary.txt. A part that fails or
takes too long is ended, and the next begins; the exit status is 1 if one did. --seconds: for everything, 480 unless it is given; the tests
get at most 0.4 of it. A driver elsewhere than usual is named by __EGL_VENDOR_LIBRARY_FILENAMES, its libraries by LD_LIBRARY_PATH.
TEXT
  exit 2
}

say() { printf 'check.sh: %s\n' "$*" >&2; }

refuse() {
  say "$*"
  exit 2
}

# An ended program gets this long to write what it has [s].
readonly grace=10

left() { echo $((seconds - SECONDS)); }

# Runs a part: part NAME LIMIT COMMAND ... puts its output into OUT/NAME.txt and a row into OUT/parts.csv. One that is over its limit [s], or
# over what is left, gets one SIGINT (timeout without --foreground sends two), upon which mss keeps its rows.
part() {
  local name=$1 limit=$2 status=0 verdict began=$EPOCHREALTIME
  ((limit <= $(left) - grace)) || limit=$(($(left) - grace))
  if ((limit < 1)); then
    verdict="no time was left"
    echo "$verdict" >"$out/$name.txt"
  else
    say "$name: at most $limit s"
    timeout --foreground --signal=INT --kill-after="$grace" "$limit" "${@:3}" >"$out/$name.txt" 2>&1 </dev/null || status=$?
    case $status in
      0) verdict=ok ;;
      77) verdict="skipped: there is no device" ;;
      124 | 137) verdict="ended after $limit s" ;;
      *) verdict="failed with status $status" ;;
    esac
  fi
  if [[ $name == timing && $status == 2 ]] && has_its_rows; then verdict="ok (charts are to be drawn: mss redraw)"; fi
  [[ $verdict == ok* ]] || failed=1
  echo "$name,$(awk -v began="$began" -v now="$EPOCHREALTIME" 'BEGIN { printf "%.1f", now - began }'),$limit,$verdict" >>"$out/parts.csv"
}

# Whether mss timing did everything but the charts, for which it ends with 2 where there is no gnuplot.
has_its_rows() { ! command -v gnuplot >/dev/null && grep -q '^ *"status": "ok",$' "$out/timing/meta.json" 2>/dev/null; }

unpack() {
  if command -v xz >/dev/null; then
    xz --decompress --stdout -- "$1"
  else
    python3 -c 'import lzma, shutil, sys; shutil.copyfileobj(lzma.open(sys.argv[1]), sys.stdout.buffer)' "$1"
  fi | tar --extract --directory "$2" --no-same-owner
}

# Of NVIDIA's driver, whether or not this system's own loader would find it.
driver_library() {
  local folder file folders
  IFS=: read -r -a folders <<<"${LD_LIBRARY_PATH:-}"
  folders+=(/usr/lib/x86_64-linux-gnu /usr/lib64 /usr/lib /usr/local/nvidia/lib64 /usr/local/lib)
  for folder in "${folders[@]}"; do
    for file in "$folder"/libEGL_nvidia.so.*; do
      [[ ! -s $file ]] || { echo "$file"; return; }
    done
  done
}

# Tells EGL's loader to take NVIDIA's driver, by a vendor file with the library's path; where the library is not found, by the vendor
# file that came with it; without either, whatever this machine's folders name is taken.
choose_driver() {
  local folder file library
  [[ -z ${__EGL_VENDOR_LIBRARY_FILENAMES:-} ]] || return 0
  library=$(driver_library)
  if [[ -n $library ]]; then
    echo "{\"file_format_version\": \"1.0.0\", \"ICD\": {\"library_path\": \"$library\"}}" >"$work/nvidia.json"
    export LD_LIBRARY_PATH=${LD_LIBRARY_PATH:+$LD_LIBRARY_PATH:}${library%/*}
    export __EGL_VENDOR_LIBRARY_FILENAMES=$work/nvidia.json
    return
  fi
  for folder in {/usr/share,/etc,/usr/local/share,/usr/local/nvidia/share}/glvnd/egl_vendor.d; do
    for file in "$folder"/*nvidia*.json; do
      [[ ! -f $file ]] || { export __EGL_VENDOR_LIBRARY_FILENAMES=$file; return; }
    done
  done
}

card() {
  command -v nvidia-smi >/dev/null || { echo "there is no nvidia-smi"; return; }
  timeout --kill-after=1 20 nvidia-smi --format=csv \
    --query-gpu=name,driver_version,memory.total,clocks.sm,clocks.mem,clocks.max.sm,clocks.max.mem,power.draw,temperature.gpu ||
    echo "nvidia-smi failed"
}

# What a failure would have to be explained with.
machine() {
  uname -srm
  sed -n 's/^PRETTY_NAME=//p' /etc/os-release
  echo "$(nproc) cores,$(sed -n 's/^model name.*://p' /proc/cpuinfo | head -n 1)"
  echo "runs with $("$start")"
  echo "driver's file: ${__EGL_VENDOR_LIBRARY_FILENAMES:-none is named, so those of this machine count}"
  local library
  library=$(driver_library)
  echo "NVIDIA's library: ${library:-none}"
  if [[ -n $library ]]; then
    ldd "$library" || true
  else
    echo "NVIDIA's other libraries:"
    timeout 10 find /usr /opt /run -name 'lib*nvidia*.so.*' -o -name 'libcuda.so.*' 2>/dev/null | head -n 40 || true
  fi
  ls -l /dev/nvidia* /dev/dri || true
}

summary() {
  echo "part,seconds,limit,verdict"
  cat -- "$out/parts.csv"
  echo "everything took $SECONDS s of $seconds, on $(grep '^runs with' "$out/machine.txt" | sed 's/runs with //')"
  echo "the devices (devices.txt):"
  head -n 20 -- "$out/devices.txt"
  echo "the tests end with (tests.txt):"
  tail -n 12 -- "$out/tests.txt"
  echo "the timing ends with (timing.txt):"
  tail -n 40 -- "$out/timing.txt"
  echo "the card before and after (card.csv):"
  cat -- "$out/card.csv"
}

[[ $# -ge 2 ]] || usage
archive=$1 out=$2 seconds=480 failed=0
shift 2
if [[ ${1:-} == --seconds ]]; then
  [[ ${2:-} =~ ^[1-9][0-9]{1,4}$ && $2 -ge 30 ]] || refuse "--seconds is '${2:-}', and must be a whole number from 30 to 99999"
  seconds=$2
  shift 2
fi
[[ -f $archive ]] || refuse "there is no archive $archive; make it with tests/device/pack.sh"
[[ ! -e $out || -d $out && -z $(ls -A -- "$out") ]] || refuse "$out is there already, and must be new or empty"
command -v xz >/dev/null || command -v python3 >/dev/null || refuse "there is neither xz nor python3, with which the archive is unpacked"

SECONDS=0
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
unpack "$archive" "$work" 2>"$work/problem" || refuse "$archive cannot be unpacked: $(head -n 1 "$work/problem")"
start=$work/mss_check/start.sh
[[ -x $start ]] || refuse "$archive is no archive of tests/device/pack.sh"
mkdir -p -- "$out"
out=$(cd -- "$out" && pwd)

choose_driver
machine >"$out/machine.txt" 2>&1 || true  # what is missing says so there
card >"$out/card.csv"
part devices 60 "$start" mss list devices
if ! grep -q ', a card, ' "$out/devices.txt"; then
  echo "card,0.0,0,there is no card that can be used: what follows is of software" >>"$out/parts.csv"
  failed=1
fi
part tests $((seconds * 2 / 5)) "$start" mss_device_tests  # without --gtest_brief, so that one that is ended has said how far it came
part timing "$seconds" "$start" mss timing --devices --out "$out/timing" "$@"
card | tail -n 1 >>"$out/card.csv"
summary | tee "$out/summary.txt"
exit "$failed"
