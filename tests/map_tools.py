"""map_tools.py - what the checks of the map share: running kelly, claims and their count."""
import json
import shlex
import subprocess

from programs import PROGRAM

count = {True: 0, False: 0}
SHORT = "--mu 0.004 --duration 8 --window 4:8"


def claim(holds, what):
    count[bool(holds)] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)
    return bool(holds)


def kelly(args, real="float", **more):
    return subprocess.run([PROGRAM[real]] + shlex.split(args), capture_output=True, text=True, check=False, timeout=300, **more)


def done(args, real="float"):
    """Output of a run that must succeed and say nothing on stderr."""
    result = kelly(args, real)
    claim(result.returncode == 0 and result.stderr == "", f"{args}: exit {result.returncode}, {result.stderr.strip()!r}")
    return result.stdout


def refused(args, word, real="float", status=2):
    result = kelly(args, real)
    return claim(result.returncode == status and result.stderr.count("\n") == 1 and result.stderr.startswith("kelly: ") and
                 word in result.stderr and result.stdout == "",
                 f"{args}: exit {result.returncode} and {(result.stdout[:80] + result.stderr)!r}; wanted {status} and one line with {word!r}")


def map_json(args, real="float"):
    return json.loads(done(f"map {args} --json -", real))


def montecarlo(args, real="float"):
    return json.loads(done(f"montecarlo {args} --json -", real))


def read(path):
    with open(path, "rb") as file:
        return file.read()


def write(path, data):
    with open(path, "wb") as file:
        file.write(data)
