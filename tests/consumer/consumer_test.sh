#!/usr/bin/env bash
# consumer_test.sh WAY BUILD DIR: uses mss as another project does, in DIR. WAY is package, pkg_config or program, with what
# `cmake --install BUILD` puts there, or subdirectory, as a part of the project's own build. Exit status 77, which CTest
# takes for "skipped", where there is no pkg-config.
set -euo pipefail

way=$1 build=$2 directory=$3
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
root=$(cd -- "$here/../.." && pwd)
prefix=$directory/prefix
rm -rf "$directory"
mkdir -p "$directory"

fail() {
  echo "consumer_test.sh: $*" >&2
  exit 1
}

install_to_prefix() { cmake --install "$build" --prefix "$prefix" --component "$1"; }

# Runs the example, which prints what README.md says.
check_output() {
  local output
  output=$("$1")
  [[ $output == *"t = 0.100 s: 1.96"* ]] || fail "$1 printed: $output"
}

configure() { cmake -S "$here" -B "$directory/build" -G Ninja "$@"; }

build_and_run() {
  configure "$@"
  cmake --build "$directory/build" --target app
  check_output "$directory/build/app"
}

case $way in
  package)
    install_to_prefix development
    ! configure -DCMAKE_PREFIX_PATH="$prefix" -DCONSUMER_VERSION=99.0 || fail "a version that there is not was found"
    build_and_run -DCMAKE_PREFIX_PATH="$prefix" -DCONSUMER_VERSION=1.0
    cmake --build "$directory/build" --target written_for_1_0
    "$directory/build/written_for_1_0"
    ;;
  subdirectory)
    # To build the libraries again takes minutes: the example and two of their sources are, and BUILD's are linked.
    configure -DCONSUMER_ADDS_SOURCES=ON -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON
    cd "$directory/build"
    ninja CMakeFiles/app.dir/example.cpp.o "$root/core/body/material.cpp^" "$root/integrators/explicit/verlet.cpp^"
    for library in core integrators; do ln -s "$build/$library/libmss_$library.a" "mss/$library/"; done
    eval "$(ninja -t commands app | tail -1)"
    check_output ./app
    ;;
  pkg_config)
    command -v pkg-config >/dev/null || { echo "skipped: pkg-config is not installed" >&2; exit 77; }
    install_to_prefix development
    configure -DCMAKE_PREFIX_PATH="$prefix"  # extracts the example
    PKG_CONFIG_PATH=$(dirname -- "$(find "$prefix" -name mss.pc)")
    export PKG_CONFIG_PATH
    read -ra flags <<<"$(pkg-config --cflags --libs mss)"
    (cd "$prefix/include" && find . -name '*.hpp' -printf '#include <%P>\n' | sort) >"$directory/headers.cpp"
    (cd "$directory" && g++ -std=c++20 build/example.cpp headers.cpp "${flags[@]}" -o app)
    check_output "$directory/app"
    ;;
  program)
    install_to_prefix program
    mv "$prefix" "$directory/moved"
    scenes=$directory/moved/share/mss/experiments/scenes
    cp "$scenes/free_cube.toml" "$scenes/installed_only.toml"
    cd "$directory"
    moved/bin/mss run installed_only --set solve.duration=0.01 --out results
    [[ -s results/series.csv ]] || fail "no series.csv"
    moved/bin/mss check --quick --only volume --out check | tee check.log
    grep -q "nothing moved" check.log || fail "the installed baselines were not met"
    ;;
  *) fail "$way is none of package, pkg_config, program, subdirectory" ;;
esac
