# shellcheck shell=bash
# The build, outside the checkout and one for each checkout. Sourced by platform.sh.

# build TARGET: ninja decides what is out of date.
build() {
    with_lock "$(basename "$build")" build_locked "$1"
}

build_locked() {
    local log
    log=$logs/$(basename "$build").log
    is_up_to_date "$1" && return
    require_space "$cache" 1000
    say "building $1 (some minutes the first time, then what has changed)"
    bring_up_to_date "$1" </dev/null >"$log" 2>&1 && return
    tail -n 40 "$log" >&2
    ! tells_full_disk "$log" || fail "$(disk_advice)"
    say "the build failed: its last lines are above, all of it is in $log"
    return 1
}

is_up_to_date() {
    [ -f "$build/build.ninja" ] && "${inside[@]}" ninja -C "$build" -n "$1" 2>/dev/null | grep -q 'no work to do'
}

bring_up_to_date() {
    [ -f "$build/build.ninja" ] || configure || return
    setpriv --pdeathsig TERM "${inside[@]}" ninja -C "$build" -j "$(jobs_that_fit)" "$1"
}

configure() {
    "${inside[@]}" cmake -S "$repo" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_CXX_COMPILER=g++ -DCMAKE_CXX_COMPILER_LAUNCHER=ccache \
        -DYADE_SOURCE_DIR="$headers" -DSOFTGRAIN_BUILD_TESTS=ON
}

# A unit that includes YADE takes up to 2 GB to compile.
jobs_that_fit() {
    awk -v cores="$(nproc)" '/^MemAvailable/ { n = int($2 / 2e6); print n < 1 ? 1 : n < cores ? n : cores }' /proc/meminfo
}
