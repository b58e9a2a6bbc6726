#!/usr/bin/env python3
"""mutate - would the tests notice? One small change of the kernel at a time, and the tests run on each.

usage: tests/mutate.py [--mutants 300] [--only TEXT] [--quick] [--jobs N] [--list]

A site is an operator, a comparison, a connective or a number in firmware/*.[ch] and firmware/link/*.c; each has one to three changes.
They are sorted by a hash of SEED, the line and the change, and the first --mutants are run: which they are depends on nothing else, so
that an edit elsewhere draws no others. What does not compile, and what compiles to the same objects in float and in double (compared
byte by byte), is no mutant; the next one takes its place.

A mutant is killed when a test ends with another status than 0 or takes ten times its usual time of the processor: the unit
tests and lanes in float and double at the sample sizes of a board, accuracy, the digests of `make digest` against those of the
README, the check of the link where the file is of the link, and the unit tests at the sample sizes of a host. Survivors are argued
one by one in tests/mutants.txt, `FILE | the line with the change as [[old -> new]] | why nothing can notice`; they count as
not killed. A survivor without an argument, and an argument for what is killed or no site any more, is a failure.
"""
import argparse
import collections
import concurrent.futures
import hashlib
import os
import queue
import re
import resource
import shlex
import shutil
import subprocess
import sys
import threading

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
OUT = os.path.join(ROOT, "build", "mutants")
SEED = "kelly 1"
LEAST = 0.95
HEADERS = tuple(sorted(f for f in os.listdir(os.path.join(ROOT, "firmware")) if f.endswith(".h")))
LIMITS = {("unit", 0): 2, ("lanes", 0): 30, ("accuracy", 0): 250, ("unit", 1): 200}    # processor time [s], ten times what they take
DIGEST = "montecarlo --duration 4 --window 2:4 --mu 0.04 --cov 0.2 --samples 8"      # as in make digest
# One vector unit beside the plain build: its lanes are the same source, and the others only take longer to compile.
MAKE = ["make", "-s", "machine=any", "CFLAGS=-O1", "CPPFLAGS=-DCHECK_STOP"]
TOKEN = re.compile(r"""/\*.*?\*/ | //[^\n]* | "(?:\\.|[^"\\])*" | '(?:\\.|[^'\\])*'
    | 0[xX][0-9a-fA-F]+\.[0-9a-fA-F]*[pP][-+]?\d+[fF]? | 0[xX][0-9a-fA-F]+[uUlL]* | (?:\d+\.\d*|\.\d+)(?:[eE][-+]?\d+)?[fF]?
    | \d+[eE][-+]?\d+[fF]? | \d+[uUlL]* | [A-Za-z_]\w* | \#\# | ->|\+\+|--|<<=|>>=|<<|>>|<=|>=|==|!=|&&|\|\||[-+*/%&|^]= | \S""", re.X | re.S)
CHANGES = {"+": ("-", "*"), "-": ("+",), "*": ("/", "+"), "/": ("*",), "+=": ("-=",), "-=": ("+=",), "<": ("<=", ">="), "<=": ("<", ">"),
           ">": (">=", "<="), ">=": (">", "<"), "==": ("!=",), "!=": ("==",), "&&": ("||",), "||": ("&&",)}


def numbers(text):
    """Other numbers in the same form: one more, one less, twice; 0 and 1 for each other."""
    digits = text.rstrip("uUlL") if not re.search(r"[.pP]", text) or re.fullmatch(r"\d+[uUlL]*", text) else text
    if re.fullmatch(r"\d+|0[xX][0-9a-fA-F]+", digits):
        value, suffix = int(digits, 0) if digits != "0" * len(digits) else 0, text[len(digits):]
        form = hex if digits[:2] in ("0x", "0X") else str
        return [form(v) + suffix for v in ((1,) if value == 0 else (value + 1, value - 1, 2 * value) if value > 1 else (0, 2))]
    plain = text.rstrip("fF") if not digits[:2] in ("0x", "0X") else text
    suffix = text[len(plain):]
    if plain[:2] in ("0x", "0X"):
        value, form = float.fromhex(plain.rstrip("fF")), float.hex
        suffix = "f" if text[-1] in "fF" and "p" in text else ""
    else:
        value, form = float(plain), repr
    others = (1.0,) if value == 0 else (value + 1, value - 1, 2 * value) if value != 1 else (0.0, 2.0)
    return [form(v) + suffix for v in others if v >= 0]


class Site:
    def __init__(self, path, text, at, old, new):
        begin, end = text.rfind("\n", 0, at) + 1, text.find("\n", at)
        self.path, self.at, self.old, self.new, self.line = path, at, old, new, text.count("\n", 0, at) + 1
        self.shown = (text[begin:at] + f"[[{old} -> {new}]]" + text[at + len(old):end]).strip()
        self.key = hashlib.sha256(f"{SEED}|{path}|{self.shown}".encode()).hexdigest()

    def __str__(self):
        return f"{self.path} | {self.shown}"


def sites_of(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        text = file.read()
    skipped = [m.span() for m in re.finditer(r"^[ \t]*#[ \t]*(?:include|if|ifdef|ifndef|elif|else|endif|error|pragma|undef)\b.*$", text, re.M)]
    before = ""
    for token in TOKEN.finditer(text):
        old, at = token[0], token.start()
        if old.startswith(("/*", "//")):
            continue
        if not any(a <= at < b for a, b in skipped):
            operand = re.fullmatch(r"[\w.]+|\)|\]", before) and before not in ("return", "case")
            operator = operand and text[at + 1] == " "       # a sign or a pointer stands close
            if old in CHANGES and (operator or old not in "+-*/"):
                yield from (Site(path, text, at, old, new) for new in CHANGES[old])
            elif old[0].isdigit() or re.match(r"\.\d", old):
                yield from (Site(path, text, at, old, new) for new in numbers(old))
        before = old


def all_sites():
    names = [n for d in ("firmware", "firmware/link") for n in sorted(f"{d}/{f}" for f in os.listdir(os.path.join(ROOT, d)) if f.endswith(".c"))]
    found = [site for name in [*names, *(f"firmware/{h}" for h in HEADERS)] for site in sites_of(name)]
    return sorted(found, key=lambda site: (site.key, site.at))


# ---- the programs as they are

def as_make_would(goals, settings):
    """({object: words that compile it}, {program: words that link it})"""
    told = subprocess.run([*MAKE, *settings, "-n", "-B", *goals], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    lines = [shlex.split(line) for line in told.splitlines() if re.match(r"\S*(gcc|clang|cc) ", line)]
    return {w[-1]: w for w in lines if "-c" in w}, {os.path.basename(w[-1]): w for w in lines if "-c" not in w}


class Build:
    """Programs in one precision and with one sample size, in a directory of their own."""

    def __init__(self, real, checks, programs):
        self.name, self.real, self.long = f"{real}-{checks}", real, checks
        self.dir = os.path.relpath(os.path.join(OUT, self.name), ROOT)
        settings, goals = [f"dir={self.dir}", f"REAL={real}", f"CHECK_LONG={checks}"], [f"{self.dir}/{p}" for p in programs]
        subprocess.run([*MAKE, *settings, f"-j{os.cpu_count()}", *goals], cwd=ROOT, check=True, stderr=subprocess.DEVNULL)
        self.compile, self.link = as_make_would(goals, settings)
        self.uses = {made: self.sources(made) for made in self.compile}

    def sources(self, made):
        with open(os.path.join(ROOT, made[:-2] + ".d"), encoding="utf-8") as file:
            return {os.path.normpath(word) for word in file.read().split(":")[1].replace("\\\n", " ").split()}

    def touched(self, path, program):
        """Objects of the program that a change of this file makes anew. Those for lanes are linked into unit, but not called."""
        return [word for word in self.link[program] if word in self.uses and path in self.uses[word] and not (program == "unit" and "/vector/" in word)]


def plain_bytes(build, made, known={}, lock=threading.Lock()):      # noqa: B006  kept on purpose
    """The optimised object of the source as it is."""
    with lock:
        if (build.name, made) not in known:
            out = os.path.join(OUT, "plain.o")
            subprocess.run(optimised(build, made, out), cwd=ROOT, check=True, stderr=subprocess.DEVNULL)
            with open(out, "rb") as file:
                known[build.name, made] = file.read()
        return known[build.name, made]


def compiling(build, made, out):
    return [word for word in build.compile[made][:-1] if word not in ("-MMD", "-MP")] + [out]


def optimised(build, made, out):
    words = compiling(build, made, out)
    return [*words[:-4], "-O2", *words[-4:]]             # ... -c SOURCE -o OUT


# ---- one mutant

class Mutant:
    """A site's change in a tree of sources of its own; objects and programs are made beside it."""

    def __init__(self, tree, site):
        self.tree, self.site, self.made = tree, site, {}
        self.path = os.path.join(tree, site.path)
        shutil.rmtree(os.path.join(tree, "made"), ignore_errors=True)
        os.mkdir(os.path.join(tree, "made"))

    def __enter__(self):
        at, site = self.site.at, self.site
        with open(self.path, encoding="utf-8") as file:
            self.text = file.read()
        with open(self.path, "w", encoding="utf-8") as file:
            file.write(self.text[:at] + site.new + self.text[at + len(site.old):])
        return self

    def __exit__(self, *_):
        with open(self.path, "w", encoding="utf-8") as file:
            file.write(self.text)

    def sh(self, words, limit=600):
        """(status, output); the limit is one of processor time, which a busy machine does not shorten."""
        def limits():
            resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
        try:
            done = subprocess.run(words, cwd=self.tree, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                  preexec_fn=limits, timeout=30 * limit + 60, check=False)
        except subprocess.TimeoutExpired:                 # it sleeps
            return 124, b""
        return done.returncode, done.stdout

    def beside(self, *name):
        return os.path.join(self.tree, "made", "+".join(name).replace("/", "+"))

    def compiled(self, build, made):
        """The path of this object with the change in it; None where that does not compile."""
        key = (build.name, made)
        if key not in self.made:
            out = self.beside(made)
            self.made[key] = out if self.sh(compiling(build, made, out))[0] == 0 else None
        return self.made[key]

    def linked(self, build, program):
        """The path of the program with the change in it; None where nothing in it changes."""
        touched = build.touched(self.site.path, program)
        words = [self.compiled(build, w) if w in touched else os.path.join(ROOT, w) if w.endswith(".o") else w for w in build.link[program][:-1]]
        out = self.beside(build.name, program)
        if touched and self.sh([*words, out])[0] != 0:
            raise RuntimeError(f"does not link: {self.site}")
        return out if touched else None

    def dies(self, build, program):
        own = self.linked(build, program)
        return own is not None and self.sh([own], LIMITS[program, build.long])[0] != 0

    def in_lanes(self, build):
        """Whether vectors are computed otherwise: the test of the lanes compares them with one lane, and sees nothing else."""
        return any("/vector/" in made for made in build.touched(self.site.path, "lanes"))

    def compiles(self, build, program):
        return all(self.compiled(build, made) for made in build.touched(self.site.path, program))

    def same(self, build):
        """Whether every object comes out as it was at -O2: there is nothing to notice."""
        for made in build.touched(self.site.path, "kelly"):
            out = self.beside("optimised.o")
            self.sh(optimised(build, made, out))
            with open(out, "rb") as file:
                if file.read() != plain_bytes(build, made):
                    return False
        return True

    def other_digest(self, build, known):
        own = self.linked(build, "kelly")
        for seed, first in ((1, 0), (20261122, 4000000000)):
            status, said = self.sh([own, *DIGEST.split(), "--seed", str(seed), "--first", str(first)], 30)
            found = re.search(rb"digest ([0-9a-f]{8})", said)
            if status != 0 or not found or found[1].decode() not in known:
                return True
        return False

    def fails_the_link(self):
        """check_link.py without its fuzzer, up to the first claim that fails."""
        if "link/" not in self.site.path:
            return False
        process = subprocess.Popen([sys.executable, "tests/check_link.py", "--fuzz", "0"], cwd=self.tree, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        with process:
            for line in process.stdout:
                if line.startswith("FAILED"):
                    process.kill()
                    return True
        return process.returncode != 0


def verdict(mutant, builds, known, quick):
    """`none`: no mutant; by what it was killed; or `survives`."""
    short, long = builds[:2], builds[2:]
    for build in short:
        if not mutant.compiles(build, "unit"):
            return "none"
        if mutant.dies(build, "unit"):
            return f"unit-{build.real}"
    if not all(mutant.compiles(b, "kelly") for b in short) or all(mutant.same(b) for b in short):
        return "none"
    for build in short:
        if mutant.in_lanes(build) and mutant.dies(build, "lanes"):
            return f"lanes-{build.real}"
    if any(mutant.other_digest(b, known) for b in short):
        return "digests"
    if mutant.fails_the_link():
        return "link"
    for build in () if quick else short:
        if mutant.dies(build, "accuracy"):
            return f"accuracy-{build.real}"
    for build in () if quick else long:
        if mutant.dies(build, "unit"):
            return f"unit-{build.real} in full"
    return "survives"


# ---- all of them

def tree_of(number):
    root = os.path.join(OUT, f"tree{number}")
    shutil.rmtree(root, ignore_errors=True)
    for part in ("firmware", "host", "tests", "gen"):
        shutil.copytree(os.path.join(ROOT, part), os.path.join(root, part), ignore=shutil.ignore_patterns("__pycache__"))
    return root


class Kept:
    """Verdicts on file, so that a campaign goes on where it was cut off; those of other sources or tests are dropped."""

    def __init__(self, quick):
        self.path, self.lock, self.verdicts = os.path.join(OUT, "verdicts-quick.txt" if quick else "verdicts.txt"), threading.Lock(), {}
        state = hashlib.sha256()
        for folder in ("firmware", "firmware/link", "tests", "gen"):
            for name in sorted(os.listdir(os.path.join(ROOT, folder))):
                if name.endswith((".c", ".h", ".py")) and not name.startswith("check_"):
                    with open(os.path.join(ROOT, folder, name), "rb") as file:
                        state.update(name.encode() + file.read())
        self.state = state.hexdigest()
        if os.path.exists(self.path):
            with open(self.path, encoding="ascii") as file:
                first, *rest = file.read().splitlines() or [""]
            if first == self.state:
                self.verdicts = dict(line.split(" ", 1) for line in rest if " " in line)
        if not self.verdicts:
            with open(self.path, "w", encoding="ascii") as file:
                file.write(self.state + "\n")

    def add(self, site, said):
        with self.lock, open(self.path, "a", encoding="ascii") as file:
            file.write(f"{site.key}{site.at} {said}\n")

    def get(self, site):
        return self.verdicts.get(f"{site.key}{site.at}")


def judged(sites, wanted, jobs, builds, known, quick):
    """[(site, verdict)] of the first `wanted` mutants."""
    trees, found, at = queue.Queue(), [], 0
    for k in range(jobs):
        trees.put(tree_of(k))

    kept = Kept(quick)

    def judge(site):
        if kept.get(site):
            return site, kept.get(site)
        tree = trees.get()
        try:
            with Mutant(tree, site) as mutant:
                said = verdict(mutant, builds, known, quick)
        finally:
            trees.put(tree)
        kept.add(site, said)
        if said == "survives":
            print(f"survives: {site.path}:{site.line}: {site.shown}", flush=True)
        return site, said

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        while len(found) < wanted and at < len(sites):
            some = sites[at:at + min(wanted - len(found), 500)]
            at += len(some)
            found += [pair for pair in pool.map(judge, some) if pair[1] != "none"]
    return found, at


def argued():
    """{site as text: argument} of tests/mutants.txt"""
    with open(os.path.join(ROOT, "tests", "mutants.txt"), encoding="utf-8") as file:
        lines = [line.strip() for line in file if line.strip() and not line.startswith("#")]
    return {line.rsplit(" | ", 1)[0]: line.rsplit(" | ", 1)[1] for line in lines}


def report(found, drawn, sites):
    """Prints it; (passed, failed)"""
    arguments, names = argued(), {str(s) for s in sites}
    killed = [site for site, said in found if said != "survives"]
    by = collections.Counter(said for _, said in found if said != "survives")
    survivors = [str(site) for site, said in found if said == "survives"]
    wrong = [f"no argument for the survivor {s}" for s in survivors if s not in arguments]
    wrong += [f"argued, and killed: {site}" for site in killed if str(site) in arguments]
    wrong += [f"argued, and no site: {text}" for text in arguments if text not in names]
    if len(killed) < LEAST * len(found):
        wrong.append(f"{len(killed)} of {len(found)} are killed, less than {LEAST:.0%}")
    for text in wrong:
        print("FAIL " + text)
    print(f"{drawn} of {len(sites)} sites drawn, {drawn - len(found)} of them no mutant (does not compile, or to the same objects)")
    print("killed by " + ", ".join(f"{what} {n}" for what, n in by.most_common()))
    print(f"figure: mutants of the kernel killed: {len(killed)} of {len(found)} ({100 * len(killed) / len(found):.1f} %), "
          f"{sum(s in arguments for s in survivors)} survivors argued")
    return len(found) - len([s for s in survivors if s not in arguments]), len(wrong)


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1])
    parser.add_argument("--mutants", type=int, default=300)
    parser.add_argument("--only", default="", help="sites whose file and line hold this")
    parser.add_argument("--quick", action="store_true", help="without accuracy and the sample sizes of a host, a minute for each survivor")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--list", action="store_true")
    args = parser.parse_args()
    sites = [site for site in all_sites() if args.only in str(site)]
    if args.list:
        return print(*(f"{s.path}:{s.line}: {s.shown}" for s in sites[:args.mutants]), sep="\n")
    os.makedirs(OUT, exist_ok=True)
    with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as file:
        known = set(re.findall(r"\b[0-9a-f]{8}\b", file.read().split("<!-- digests -->")[1].split("<!-- /digests -->")[0]))
    builds = [Build(real, 0, ("unit", "lanes", "accuracy", "kelly")) for real in ("float", "double")]
    builds += [Build(real, 1, ("unit",)) for real in ("float", "double") if not args.quick]
    found, drawn = judged(sites, args.mutants, args.jobs, builds, known, args.quick)
    passed, failed = report(found, drawn, sites if not args.only else all_sites())
    print(f"{passed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
