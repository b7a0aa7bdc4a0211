#!/usr/bin/env bash
# Starts a program that pack.sh packed, from the folder it was unpacked to: start.sh PROGRAM [arguments]; without a program, says with
# which C library it would. A process has one C library, and one of the compiler, for the program and the card's driver: both run with
# a newer one than they were built with, neither with an older. So it is the machine's unless the carried one is newer.
set -euo pipefail

root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)

# Whether version $1 is at least $2.
at_least() { [[ -n $1 && $(printf '%s\n' "$1" "$2" | sort --version-sort | tail -n 1) == "$1" ]]; }

# Empty where the machine's C library is another than GNU's.
c_library_here() { getconf GNU_LIBC_VERSION 2>/dev/null | sed 's/.* //'; }

# The number behind libstdc++.so of a file or link to it, as 6.0.30; empty if there is none.
compiler_library_version() {
  local file
  file=$(readlink -f -- "$1") && [[ -f $file ]] || return 0
  file=${file##*/libstdc++.so.}
  echo "$file"
}
compiler_library_here() {
  local file
  file=$(PATH=$PATH:/sbin:/usr/sbin ldconfig -p 2>/dev/null | awk '$1 == "libstdc++.so.6" && /x86-64/ && !found { print $NF; found = 1 }') || true
  compiler_library_version "${file:-/none}"
}

carried_c=$(cat -- "$root/lib/c/version")
c_here=$(c_library_here) || true
libraries=$root/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
if at_least "$c_here" "$carried_c"; then
  how="this machine's C library $c_here; $carried_c is carried"
  at_least "$(compiler_library_here)" "$(compiler_library_version "$root/lib/compiler/libstdc++.so.6")" ||
    libraries=$root/lib/compiler:$libraries
  start=(env "LD_LIBRARY_PATH=$libraries" "$root/bin/${1:-}")
else
  how="the carried C library $carried_c; this machine's is ${c_here:-unknown}"
  start=("$root/lib/c/ld-linux-x86-64.so.2" --library-path "$root/lib/c:$root/lib/compiler:$libraries" "$root/bin/${1:-}")
fi
[[ $# -gt 0 ]] || { echo "$how"; exit 0; }
exec "${start[@]}" "${@:2}"
