#!/usr/bin/env bash
# check_test.sh DIR: check.sh on archives of stand-ins for the programs, in DIR: a part that fails stops no other and none is forgotten,
# missing charts are no failure where there is no gnuplot, and start.sh takes the newer C library.
set -euo pipefail

here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
directory=$(realpath -m -- "$1")
rm -rf "$directory"
mkdir -p "$directory/without_gnuplot"
cd "$directory"
ln -s /usr/bin/* without_gnuplot/
rm -f without_gnuplot/gnuplot

fail() {
  echo "check_test.sh: $*" >&2
  exit 1
}

# An archive whose tests and timing end so: archive NAME STATUS_OF_TESTS STATUS_OF_TIMING STATUS_IN_META.
archive() {
  local root=$1/mss_check
  mkdir -p "$root/bin" "$root/lib/c" "$root/lib/compiler"
  cp "$here/start.sh" "$root/"
  echo 0.1 >"$root/lib/c/version"
  printf '#!/bin/sh\nexit %s\n' "$2" >"$root/bin/mss_device_tests"
  cat >"$root/bin/mss" <<SCRIPT
#!/bin/sh
[ "\$1" = list ] && echo "gpu:0  Card, OpenGL 4.6, a card, single and double" && exit 0
mkdir -p "\$4" && printf '{\n  "status": "%s",\n}\n' "$4" >"\$4/meta.json"
echo "timing was given \$*"
exit $3
SCRIPT
  chmod +x "$root"/bin/*
  tar cJf "$1.tar.xz" -C "$1" mss_check
}

# check NAME STATUS VERDICT_OF_TESTS VERDICT_OF_TIMING
check() {
  local status=0 verdicts
  PATH=$directory/without_gnuplot "$here/check.sh" "$1.tar.xz" "$1.out" --seconds 60 --cells 7 >"$1.txt" 2>&1 || status=$?
  [[ $status -eq $2 ]] || fail "$1 ended with $status in place of $2"
  verdicts=$(cut -d, -f 1,4 "$1.out/parts.csv")
  [[ $verdicts == "devices,ok"$'\n'"tests,$3"$'\n'"timing,$4" ]] || fail "$1 has the verdicts $verdicts"
  grep -q "timing was given timing --devices --out .*/$1.out/timing --cells 7" "$1.txt" || fail "$1: the summary shows no timing"
}

archive good 0 0 ok
check good 0 ok ok
archive no_charts 0 2 ok
check no_charts 0 ok "ok (charts are to be drawn: mss redraw)"
archive no_rows 1 2 interrupted
check no_rows 1 "failed with status 1" "failed with status 2"
archive no_device 77 0 ok
check no_device 1 "skipped: there is no device" ok

here_is=$(getconf GNU_LIBC_VERSION | sed 's/.* //')
for carried in 0.1 "$here_is" 999.0; do
  echo "$carried" >good/mss_check/lib/c/version
  how=$(good/mss_check/start.sh)
  case $carried in
    999.0) [[ $how == "the carried C library 999.0"* ]] || fail "999.0 is not taken: $how" ;;
    *) [[ $how == "this machine's C library $here_is"* ]] || fail "$carried is taken: $how" ;;
  esac
done
