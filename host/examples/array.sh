#!/bin/sh
# array.sh - one ensemble as an array of jobs, and what they leave put together.
#
#   usage: array.sh OUT SAMPLES PARTS [case of kelly montecarlo]
#
# Here the parts run one after another. In a batch system each is a task of an array; what a task runs is the function `part`, e.g.
# for Slurm with  #SBATCH --array=0-99  and  part "$SLURM_ARRAY_TASK_ID" "$@",  for PBS with $PBS_ARRAY_INDEX, for Grid Engine with
# $SGE_TASK_ID - 1. A task that was killed or ran out of its time is simply started again: --resume goes on from its journal, and a task
# that had come to its end is skipped. OUT.study holds what it is of: another number or case with the same OUT is refused, and so are
# parts without it. No two parts share a realisation or a file, and the result does not depend on how many there are.
set -eu

refuse() {
    echo "array.sh: $*" >&2
    exit 2
}

# A whole number 1..4294967295, as the shell computes with it.
check_number() {
    case $2 in
    '' | *[!0-9]* | 0* | ???????????*) refuse "$1 '$2': not a whole number from 1 on; give e.g. 1000" ;;
    esac
}

[ $# -ge 3 ] || { sed -n '4s/^# *//p' "$0" >&2; exit 2; }
out=$1 samples=$2 parts=$3
shift 3
kelly=${KELLY:-kelly}
check_number SAMPLES "$samples"
check_number PARTS "$parts"

# A line for each argument; made in one piece, whichever task comes first.
study=$(printf '%s\n' "$samples samples in $parts parts" "$@")
begun=
if [ ! -f "$out.study" ]; then
    for left in "$out".[0-9]*.csv "$out".[0-9]*.csv.journal; do
        [ ! -f "$left" ] || [ -f "$out.study" ] || refuse "$left: a part of an unknown study, as $out.study is not there; move it away, or give another OUT"
    done
    printf '%s\n' "$study" > "$out.study.$$"
    mv "$out.study.$$" "$out.study"
    begun=1
fi
[ "$(cat "$out.study")" = "$study" ] || refuse "$out.study: of another study ($(tr '\n' ' ' < "$out.study")); give that one's arguments, or another OUT"

# Whether part k has come to its end.
whole() {
    [ -f "$out.$1.csv" ] && [ -f "$out.$1.json" ] && [ ! -f "$out.$1.csv.journal" ]
}

# Realisations of part k: the first `samples % parts` parts have one more.
part() {
    k=$1
    shift
    count=$((samples / parts + (k < samples % parts)))
    first=$((k * (samples / parts) + (k < samples % parts ? k : samples % parts)))
    [ "$count" -gt 0 ] || return 0
    ! whole "$k" || return 0
    [ ! -f "$out.$k.csv.journal" ] || set -- "$@" --resume
    "$kelly" montecarlo "$@" --first "$first" --samples "$count" --csv "$out.$k.csv" --json "$out.$k.json" --quiet || {
        status=$?   # 1 where none of its realisations can be trusted: that is for the sum to say
        [ "$status" -ne 2 ] || [ -z "$begun" ] || rm -f "$out.study"   # a mistake: there is nothing to go on with
        [ "$status" -eq 1 ] && whole "$k" || return "$status"
    }
}

k=0
while [ "$k" -lt "$parts" ] && [ "$k" -lt "$samples" ]; do
    part "$k" "$@"
    k=$((k + 1))
done

# The parts, one argument a file.
set --
while [ "$k" -gt 0 ]; do
    k=$((k - 1))
    set -- "$out.$k.csv" "$@"
done
"$kelly" merge "$@" --csv "$out.csv" --json "$out.json"
