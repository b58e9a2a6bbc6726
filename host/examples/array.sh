#!/bin/sh
# array.sh - one ensemble as an array of jobs, and what they leave put together.
#
#   usage: array.sh OUT SAMPLES PARTS [case of kelly montecarlo]
#
# Here the parts run one after another. In a batch system each is a task of an array; what a task runs is the function `part`, e.g.
# for Slurm with  #SBATCH --array=0-99  and  part "$SLURM_ARRAY_TASK_ID",  for PBS with $PBS_ARRAY_INDEX, for Grid Engine with $SGE_TASK_ID - 1.
# A task that was killed or ran out of its time is simply started again: --resume goes on from its journal, and a task that had
# come to its end is skipped: give every study an OUT of its own. No two parts share a realisation or a file, and the result does not
# depend on how many there are.
set -eu

[ $# -ge 3 ] || { sed -n '4s/^# *//p' "$0" >&2; exit 2; }
out=$1 samples=$2 parts=$3
shift 3
kelly=${KELLY:-kelly}

# Realisations of part k: the first `samples % parts` parts have one more.
part() {
    k=$1
    shift
    count=$((samples / parts + (k < samples % parts)))
    first=$((k * (samples / parts) + (k < samples % parts ? k : samples % parts)))
    [ "$count" -gt 0 ] || return 0
    if [ -f "$out.$k.csv" ] && [ -f "$out.$k.json" ] && [ ! -f "$out.$k.csv.journal" ]; then
        return 0
    fi
    "$kelly" montecarlo "$@" --first "$first" --samples "$count" --csv "$out.$k.csv" --json "$out.$k.json" --quiet --resume
}

k=0
files=
while [ "$k" -lt "$parts" ] && [ "$k" -lt "$samples" ]; do
    part "$k" "$@"
    files="$files $out.$k.csv"
    k=$((k + 1))
done

# shellcheck disable=SC2086 # one word a file
"$kelly" merge $files --csv "$out.csv" --json "$out.json"
