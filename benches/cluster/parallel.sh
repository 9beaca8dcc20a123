#!/bin/bash
# The shards of a batch under GNU parallel.
#
#   parallel.sh OUT SHARDS INPUT ... [-- FLAGS of microtome batch]
#
# The environment may set
#   MICROTOME   the program [default: microtome]
#   JOBS        shards at a time [default: one for every core]
#   THREADS     threads of a shard [default: 1]
#   ATTEMPTS    how often a shard that was stopped on the way is started again [default: 5]
# Prints a line a shard; ends with 0 (all good), 7 (models failed; the report says which) or 9 (start it again: it goes
# on where it was). The report of the whole is OUT/report.html. The log of the shards is OUT/.microtome/parallel.log.
set -u
usage='usage: parallel.sh OUT SHARDS INPUT ... [-- FLAGS]'
out=${1:?"$usage"} shards=${2:?"$usage"}; shift 2
[ $# -gt 0 ] || { echo "$usage" >&2; exit 2; }
inputs=()
while [ $# -gt 0 ]; do
    [ "$1" = -- ] && { shift; break; }
    inputs+=("$1"); shift
done
MICROTOME=${MICROTOME:-microtome} THREADS=${THREADS:-1} ATTEMPTS=${ATTEMPTS:-5}
export MICROTOME THREADS ATTEMPTS

shard() {
    local shard=$1 out=$2 try code=9; shift 2
    local child= told=
    trap 'told=1; [ -n "$child" ] && kill -TERM "$child" 2>/dev/null' TERM
    for ((try = 0; try <= ATTEMPTS; try++)); do
        "$MICROTOME" batch "$@" -o "$out" --shard "$shard" --resume --threads "$THREADS" --quiet &
        child=$!
        wait "$child"; code=$?
        [ -n "$told" ] && { wait "$child"; code=$?; break; }
        # 9 = stopped on the way, above 128 = killed; all else is an end.
        [ $code -eq 9 ] || [ $code -gt 128 ] || break
    done
    echo "shard $shard ended with $code after $((try + 1)) starts"
    return $code
}
export -f shard

mkdir -p "$out/.microtome" || exit 6
log=$out/.microtome/parallel.log
SHELL=/bin/bash parallel --will-cite --jobs "${JOBS:-100%}" --joblog "$log" --termseq TERM,60000,KILL,1000 --halt never \
    shard "{}/$shards" "$(printf %q "$out")" "$(printf '%q ' "${inputs[@]}" "$@")" ::: $(seq "$shards")

"$MICROTOME" report "$out" || exit
awk -F'\t' -v shards="$shards" 'NR > 1 { n++; if ($7 == 7 || $7 == 8) failed = 1; else if ($7 != 0 || $8 != 0) stopped = 1 }
    END { exit n < shards || stopped ? 9 : failed ? 7 : 0 }' "$log"
