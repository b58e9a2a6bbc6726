"""The README's tables of drives, of the bench and of many cores, from runs on this tree.

    readme_runs.py drives > build/drives.md      after `make drives`
    readme_runs.py benches > build/benches.md    after `make TARGET=...` of BOARDS
    readme_runs.py plan > build/plan.md          after `make mpi`
"""
import json
import subprocess
import sys

KELLY = "build/host/kelly"
BOARDS = ("stm32f405", "mps2-an500", "rv32")
DRIVES = ("stiff", "soft", "soft:Z=100", "soft:Z=1000,f=0.1")
MAPS = ("build/figures/map-stiff.json", "build/figures/map-soft.json")


def probability(mu, start, drive):
    words = [KELLY, "montecarlo", "--mu", mu, "--samples", "4000", "--start", start, "--drive", drive, "--quiet", "--json", "-"]
    run = json.loads(subprocess.run(words, capture_output=True, text=True, check=True).stdout)
    return f"{run['probability']:.4f} ({run['ci95'][0]:.4f}..{run['ci95'][1]:.4f})"


def cells(stiff, soft, start):
    """Pairs of cells of two maps, and of those the ones that are not settled under the stiff drive."""
    both = [(a, b) for row in zip(stiff, soft) for a, b in zip(*row)]
    return both, [(a, b) for a, b in both if 0.1 < a < 0.9], start


def drives():
    print("| | " + " | ".join(f"`{d}`" for d in DRIVES) + " |\n|---|" + "---|" * len(DRIVES))
    for mu in ("0.004", "0.04"):
        for start in ("rest", "rotating"):
            print(f"| mu {mu}, {start} | " + " | ".join(probability(mu, start, d) for d in DRIVES) + " |")
    maps = [json.load(open(path, encoding="utf-8")) for path in MAPS]
    print("\n`make drives`, soft rock over 40-140 rpm and 25-225 kN, 400 realisations a cell (picture: build/figures/drives.png):\n")
    for start in ("rest", "rotating"):
        stiff, soft = (m[start]["probability"] for m in maps)
        both, unsettled, _ = cells(stiff, soft, start)
        falls = [100 * (a - b) for a, b in unsettled]
        print(f"- {start}: in the {len(falls)} of {len(both)} cells where P of the stiff drive lies between 10 and 90 %, it falls by {sum(falls) / len(falls):.0f} points on "
              f"average ({min(falls):.0f} to {max(falls):.0f}); it rises in {sum(b > a for a, b in both)} cells.")


def shown(*words, program=(KELLY,), hidden=()):
    """A command as one types it, and what it says; `hidden` are words that only a run without a user needs."""
    print("    $ " + " ".join([*program, *words]))
    done = subprocess.run([program[0], *hidden, *program[1:], *words], capture_output=True, text=True, check=True)
    print("".join(f"    {line}\n" for line in done.stdout.splitlines()))


def benches():
    ports = [word for board in BOARDS for word in ("--port", "qemu:" + board)]
    case = ("--mu", "0.004", "--duration", "20", "--samples", "96")
    shown("bench", *ports, *case)
    shown("montecarlo", *case)
    shown("bench", "--port", "qemu:stm32f405", "--mode", "lockstep", "--duration", "60")
    for board in BOARDS:
        shown("bench", "--port", "qemu:" + board, "--icount", "shift=5,sleep=off", "--mode", "realtime", "--duration", "60")
    shown("bench", "--port", "qemu:stm32f405", "--icount", "shift=5,sleep=off", "--mode", "realtime", "--duration", "60", "--overload", "7:1500")


def plan():
    shown("plan", "--mu", "0.004", program=("mpirun", "-n", "2", "build/mpi/kelly"), hidden=("--allow-run-as-root", "--oversubscribe"))


PARTS = {"drives": drives, "benches": benches, "plan": plan}

if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1] not in PARTS:
        sys.exit(__doc__)
    PARTS[sys.argv[1]]()
