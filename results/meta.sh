# shellcheck shell=bash
# Sourced by run.sh and advise/run.sh: what meta.json of a folder says, and the meta.json of a script.

# What it has under a key on a line of its own, the last if there are several.
from_meta() { sed -n "s/^ *\"$2\": \"\{0,1\}\([^,\"]*\)\"\{0,1\},\{0,1\}$/\1/p" "$1/meta.json" | tail -1; }

# Of a script, with the provenance of a folder it filled.
meta_of_script() {
  printf '{\n  "script": "%s",\n' "$1"
  sed -n '/^  "provenance"/,$p' "$2/meta.json"
}
