# shellcheck shell=bash
# Words for all set-up steps: the cache, messages, logs, locks. Sourced by platform.sh.

: "${HOME:=$(getent passwd "$(id -u)" | cut -d: -f6)}"
export HOME
cache=$(realpath -m -- "${XDG_CACHE_HOME:-$HOME/.cache}/softgrain")
logs=$cache/logs

say() {
    printf 'softgrain: %s\n' "$*" >&2
}

fail() {
    say "$*"
    exit 1
}

mkdir -p -- "$logs" 2>/dev/null && [ -w "$cache" ] && [ -w "$logs" ] \
    || fail "cannot write to $cache: free some space there, or set XDG_CACHE_HOME to a folder that can be written"

# with_lock NAME STEP...: one call at a time runs STEP, the others wait for it. STEP must look again
# at what is left to do. What STEP starts holds the lock too, so that a killed call's remains have
# ended before the next one starts.
with_lock() {
    local lock=$cache/$1.lock status
    shift
    exec 9>"$lock"
    flock --nonblock 9 || {
        say "another call holds $lock: waiting for it"
        flock 9
    }
    "$@"
    status=$?
    exec 9>&-
    return $status
}

# logged NAME COMMAND...: runs COMMAND with its output in a log; a failure becomes one line.
logged() {
    local log=$logs/$1.log
    shift
    printf '== %s\n' "$*" >"$log" || fail "$(disk_advice)"
    "$@" </dev/null >>"$log" 2>&1 || fail "$(diagnosis "$log") (log: $log)"
}

# The likely cause of a failed step, and what to do.
diagnosis() {
    local log=$1
    if tells_full_disk "$log"; then
        disk_advice
    elif grep -qE 'Could not (resolve|connect)|Temporary failure resolving|Unable to connect|Failed to fetch|Connection (failed|timed out)|Network is unreachable' "$log"; then
        echo "cannot reach the package registry: check the network (and http_proxy), or set SOFTGRAIN_DEBIAN_MIRROR (now $mirror); then call again"
    else
        echo "this step failed: $(sed -n '1s/^== //p' "$log" | cut -c1-60)...; see the end of its log, then call again"
    fi
}

# A log on a full disk may lack the very line that says so.
tells_full_disk() {
    grep -qE 'No space left on device|not enough free space|Disk quota exceeded' "$1" \
        || [ "$(free_mb "$cache")" -lt 100 ]
}

disk_advice() {
    echo "the disk is full: free some space under $cache, or set XDG_CACHE_HOME to a folder on another disk; then call again"
}

free_mb() {
    df --output=avail -BM -- "$1" | tail -n 1 | tr -dc 0-9
}

# require_space DIR MB: a full disk is told before the work rather than in the middle of it.
require_space() {
    [ "$(free_mb "$1")" -ge "$2" ] \
        || fail "$1 has $(free_mb "$1") MB free, but $2 MB are needed: free some space there${3:-}"
}
