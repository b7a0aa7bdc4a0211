#!/usr/bin/env bash
# Packs what check.sh needs on a machine with a card and without Debian's packages: the programs as they are installed, with every
# library they use, and this system's loader and C library, for a machine whose own are older. Drivers stay out: the card brings its own.
set -euo pipefail

here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
largest_mib=20

# What the programs load only once they look for a device, and what NVIDIA's driver then may.
loaded_later=(libEGL.so.1 libGLdispatch.so.0 libOpenGL.so.0 libGL.so.1 libGLX.so.0 libX11.so.6 libXext.so.6)

# What every library in a process must share, the driver's too: start.sh takes the newer of the machine's and these.
c_library=(ld-linux-x86-64.so.2 libc.so.6 libm.so.6 libmvec.so.1 libdl.so.2 libpthread.so.0 librt.so.1 libresolv.so.2 libutil.so.1)
compiler_library=(libstdc++.so.6 libgcc_s.so.1)

usage() {
  echo "usage: tests/device/pack.sh BUILD OUT.tar.xz    (BUILD: a finished build folder, as build/release)" >&2
  exit 2
}

say() { printf 'pack.sh: %s\n' "$*" >&2; }

refuse() {
  say "$*"
  exit 2
}

# The file of a library that this system finds by its name.
library_file() {
  local file
  file=$(/sbin/ldconfig -p | awk -v name="$1" '$1 == name && /x86-64/ && !found { print $NF; found = 1 }')
  [[ -n $file ]] || refuse "$1 is not installed here; its package is among libegl1, libglvnd0, libopengl0, libgl1, libx11-6, libxext6, libc6"
  echo "$file"
}

# Copies the program as `cmake --install` lays it out, whereby it finds its scenes wherever it is moved, without those that only it
# runs (debug builds and Bullet, whose rows then say so); and the tests beside it.
stage_programs() {
  local build=$1 stage=$2
  cmake --install "$build" --prefix "$stage" --component program --strip >/dev/null
  rm -rf -- "$stage/libexec"
  if [[ -x $build/mss_device_tests ]]; then
    strip -o "$stage/bin/mss_device_tests" "$build/mss_device_tests"
    say "with the tests of devices"
  else
    say "without the tests of devices: there is no mss_device_tests in $build"
  fi
}

# Every library that programs and others need, by path; a name that is not found ends the script.
needed_libraries() {
  local listing
  listing=$(ldd "$@")
  ! grep "not found" <<<"$listing" >&2 || refuse "these libraries are not installed here"
  awk '$2 == "=>" { print $3 }' <<<"$listing" | sort -u
}

# BLAS and LAPACK are in OpenBLAS, so that CHOLMOD needs no second copy of them.
share_openblas() {
  local name
  [[ -f $1/libopenblas.so.0 ]] || return 0
  for name in libblas.so.3 liblapack.so.3; do
    [[ ! -f $1/$name ]] || ln -sf libopenblas.so.0 "$1/$name"
  done
}

# HDF5 reads files from the web with curl, which brings 20 libraries. The program never does, so an empty one of that name serves.
leave_out_curl() {
  local file=$1/libcurl.so.4 version
  [[ -f $file ]] || return 0
  version=$(objdump --private-headers "$file" | awk '$1 > 1 && $4 ~ /^CURL_/ { print $4 }')
  echo "$version { };" > "$work/curl.version"
  cc -shared -nostdlib -Wl,--soname=libcurl.so.4 -Wl,--version-script="$work/curl.version" -x c /dev/null -o "$file"
}

# All that the packed programs and libraries need is needed still; what is not goes.
drop_unneeded() {
  local needed file
  needed=$(LD_LIBRARY_PATH=$1 ldd "${@:2}" | awk '{ sub(/:$/, "", $1); sub(/.*\//, "", $1); print $1 }' | sort -u)
  for file in "$1"/*.so*; do
    [[ -L $file ]] || grep -qxF "$(basename -- "$file")" <<<"$needed" || rm -f -- "$file"
  done
}

# The C library and the compiler's, in folders of their own.
set_apart() {
  local libraries=$1 name file
  mkdir -p "$libraries/c" "$libraries/compiler"
  for name in "${c_library[@]}"; do
    file=$(library_file "$name")
    cp --dereference -- "$file" "$libraries/c/"
    rm -f -- "$libraries/$name"
  done
  for name in "${compiler_library[@]}"; do
    file=$(readlink -f -- "$(library_file "$name")")
    cp -- "$file" "$libraries/compiler/"
    [[ $(basename -- "$file") == "$name" ]] || ln -s -- "$(basename -- "$file")" "$libraries/compiler/$name"
    rm -f -- "$libraries/$name"
  done
  getconf GNU_LIBC_VERSION | sed 's/.* //' > "$libraries/c/version"
}

stage_libraries() {
  local stage=$1 name file later=() needed
  mkdir -p "$stage/lib"
  for name in "${loaded_later[@]}"; do
    file=$(library_file "$name")
    later+=("$file")
  done
  needed=$(needed_libraries "$stage"/bin/* "${later[@]}")
  mapfile -t needed <<<"$needed"
  cp --dereference -- "${needed[@]}" "$stage/lib/"
  cp --dereference -- "${later[@]}" "$stage/lib/"
  share_openblas "$stage/lib"
  leave_out_curl "$stage/lib"
  drop_unneeded "$stage/lib" "$stage"/bin/* "${later[@]/#*\//$stage/lib/}"
  set_apart "$stage/lib"
}

[[ $# -eq 2 ]] || usage
build=$1 archive=$2
[[ $archive == *.tar.xz ]] || refuse "the archive is called $archive, and its name must end with .tar.xz"
[[ -d $(dirname -- "$archive") ]] || refuse "there is no folder $(dirname -- "$archive") for the archive"
[[ -x $build/mss ]] || refuse "there is no program $build/mss; build it first: ./run.sh build"

work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
stage=$work/mss_check
stage_programs "$build" "$stage"
stage_libraries "$stage"
cp -- "$here/start.sh" "$stage/start.sh"
tar --create --directory "$work" --sort=name --owner=0 --group=0 --numeric-owner mss_check | xz --x86 --lzma2=preset=9e > "$work/archive"
bytes=$(stat --format=%s "$work/archive")
mib=$(awk -v bytes="$bytes" 'BEGIN { printf "%.1f", bytes / 1048576 }')
if ((bytes > largest_mib * 1048576)); then
  say "the archive has $mib MiB, and $largest_mib are allowed"
  exit 1
fi
mv -- "$work/archive" "$archive"
say "wrote $archive: $mib MiB, $(find "$stage/lib" -type f -name '*.so*' | wc -l) libraries, C library $(cat "$stage/lib/c/version")"
