#!/usr/bin/env python3
"""No run-time error, proved: Frama-C's Eva over the kernel, the samplers, the codecs and the device program, and WP where Eva cannot see.

usage: [EVA_JOBS=2] tests/check_eva.py [--double] [--rest] [DRIVER...]
       tests/check_eva.py --levels

Each driver of tests/eva calls public functions with inputs that stand for every value of their documented ranges. A claim is
that nothing is open: no alarm (memory, overflow, shift, division, uninitialised value, non-finite float), no contract in doubt. Every function of the
files under proof is reached by one driver or another; statements that none reaches are printed. Then faults are planted in copies:
each has to be found. What is taken for granted is printed as well. --double: the drivers with real = double, and no more than they. --rest: what
the drivers leave out else of slices of the weight on the rock and of the rock's law (tests/eva/torque.h) and of counts of modes, and no more. --levels: what WP
proves of the levels of rare events, whatever their size, and the faults planted there, and no more.
"""
import concurrent.futures
import os
import re
import shutil
import subprocess
import sys

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
EVA = os.path.join(ROOT, "tests", "eva")
OPTIONS = ("--double", "--rest", "--levels")
DOUBLE, REST, LEVELS = (option in sys.argv[1:] for option in OPTIONS)
OUT = os.path.join(ROOT, "build", "eva" + "-rest" * REST + "-double" * DOUBLE + "-levels" * LEVELS)
JOBS = int(os.environ.get("EVA_JOBS", "1"))     # drivers at a time

LINK = "link/crc32c link/frame link/keys link/messages link/wits link/fields".split()
MODEL = "detmath link/crc32c string_model realisation tables/paper".split()
COPIES = ("", "_0", "_1")                # a static of a header: one for each file
TORQUE, UNFOLDED = (",".join(name + copy for copy in COPIES) for name in ("kelly_bit_torque_folded", "kelly_bit_torque"))

# driver: (files of firmware/ besides it, options). use-spec: proved by another driver, or assumed below.
DRIVERS = {
    "math": (["detmath"], "-eva-precision 3 -eva-min-loop-unroll 25 -eva-slevel 60"),
    "exp": (["detmath"], "-eva-precision 0"),
    "sine": (["detmath"], "-eva-precision 1 -eva-slevel 50 -eva-split-return full"),
    "normal": (["detmath"], "-eva-precision 3 -eva-slevel 100 -eva-split-return full"),
    "random": (["random", "detmath"], "-eva-precision 3 -eva-auto-loop-unroll 128 -eva-use-spec kelly_normal"),
    "torque": (["detmath"], "-eva-precision 0 -eva-slevel 20"),
    "step": (["integrator", "block", "detmath"], f"-eva-precision 1 -eva-slevel 30 -eva-auto-loop-unroll 24 -eva-use-spec {TORQUE},kelly_sin_turn"),
    "turns": (["integrator", "block", "detmath"], f"-eva-precision 0 -eva-slevel 20 -eva-auto-loop-unroll 24 -eva-use-spec {TORQUE},kelly_sin_turn"),
    "driven": (["drive", "detmath"], f"-eva-precision 1 -eva-slevel 30 -eva-auto-loop-unroll 24 -eva-use-spec {UNFOLDED},kelly_sin_turn"),
    "load": (MODEL + ["block", "drive_block", "drive", "integrator", "seal"],
             "-eva-precision 0 -eva-slevel 6 -eva-min-loop-unroll 20 -eva-split-return full -eva-use-spec kelly_sin_turn,kelly_phase_step,kelly_block_resync"),
    "strings": (MODEL + ["axial", "random"],
                "-eva-precision 1 -eva-slevel 30 -eva-auto-loop-unroll 24 -eva-slevel-function crc_of:400,crc_reals:400 "
                "-eva-split-return full -eva-use-spec kelly_normal,kelly_sin_turn,kelly_crc32c"),
    "ensemble": (["ensemble", "seal"], "-eva-precision 1 -eva-slevel 30"),
    "indices": (["random", "detmath"], "-eva-precision 1 -eva-slevel 100 -eva-auto-loop-unroll 64 -eva-split-return full"),
    "statistics": ("tally link/crc32c".split(), "-eva-precision 0 -eva-slevel 10 -eva-auto-loop-unroll 64"),
    "messages": (["link/messages", "link/fields"], "-eva-precision 0 -eva-auto-loop-unroll 25 -eva-min-loop-unroll 2 -eva-slevel 12 -eva-split-return full"),
    "link": (LINK, "-eva-precision 1 -eva-auto-loop-unroll 34 -eva-slevel 12 -eva-slevel-function put_digits:60 -eva-split-return full "
                   "-eva-use-spec kelly_cobs"),
    "text": ("app/out app/say link/frame link/crc32c".split(),
             "-eva-precision 0 -eva-slevel 30 -eva-auto-loop-unroll 16 -eva-partition-value deferred -eva-split-return full -eva-use-spec kelly_cobs"),
    "sequence": (["sequence", "detmath"], "-eva-precision 0 -eva-slevel 4 -eva-auto-loop-unroll 30 -eva-min-loop-unroll 28 -eva-use-spec kelly_log32"),
    "interval": (["detmath"], "-eva-precision 0 -eva-slevel 4 -eva-auto-loop-unroll 30 -eva-min-loop-unroll 60 "
                              "-eva-use-spec kelly_log,kelly_exp"),
    "reweight": (["reweight", "detmath"], "-eva-precision 0 -eva-slevel 10 -eva-auto-loop-unroll 30 -eva-use-spec kelly_log,kelly_exp"),
    "envelope": (["envelope", "detmath"],
                 "-eva-precision 0 -eva-slevel 10 -eva-slevel-function merge_neighbours:2000 -eva-slevel-merge-after-loop merge_neighbours "
                 "-eva-auto-loop-unroll 100 -eva-min-loop-unroll 96 -eva-split-return full"),
    "rare": (["rare", "rare_answer", "detmath"],
             "-eva-precision 0 -eva-slevel 0 -eva-slevel-function sink:60,end_level:20,next_level:20,kelly_rare_accept:20,judge:5 "
             "-eva-slevel-merge-after-loop sink -eva-auto-loop-unroll 210 -eva-min-loop-unroll 41 -eva-split-return-function end_level:full,judge:full "
             "-eva-use-spec kelly_exp,kelly_log"),
    "walk": (["rare_walk", "detmath"],
             "-eva-precision 0 -eva-slevel 60 -eva-auto-loop-unroll 50 -eva-split-return full -eva-use-spec kelly_normal,kelly_log32"),
    "look": (["rare_look", "rare_answer", "detmath"],
             "-eva-precision 0 -eva-slevel 0 -eva-slevel-function share_seen:200,kelly_rare_compare:10,kelly_rare_read:4 -eva-auto-loop-unroll 41 -eva-min-loop-unroll 41 "
             "-eva-use-spec kelly_exp,kelly_log"),
    "guide": (["rare_guide", "string_model", "link/crc32c", "tables/paper", "detmath"],
              "-eva-precision 0 -eva-slevel 500 -eva-slevel-function forced:0,slope_of:0,ratio_of:0,kelly_tanh:0,kelly_poly:0,main:0,hints:0 "
              "-eva-auto-loop-unroll 24 -eva-split-return full -eva-subdivide-non-linear-function forced:40 -eva-use-spec kelly_log32"),
    "lines": (["app/line", "app/scpi"],
              "-eva-precision 0 -eva-slevel 500 -eva-slevel-function line_read:0,read_word:10 "
              "-eva-slevel-merge-after-loop line_read -eva-auto-loop-unroll 100 -eva-min-loop-unroll 80 "
              "-eva-split-return-function match:full,scpi_number:0,is_digit:full,is_capital:full,after:full"),
    "console": ("app/console app/scpi app/out app/say link/frame link/crc32c tables/paper".split(),
                "-eva-precision 0 -eva-slevel 200 -eva-auto-loop-unroll 100 -eva-min-loop-unroll 80 -eva-split-return full "
                "-eva-use-spec kelly_cobs,scpi_is,scpi_number"),
    "requests": ("app/requests app/bench app/campaign app/gauge app/lockstep app/realtime app/session link/frame link/messages tables/paper".split(),
                 "-eva-precision 0 -eva-slevel 60 -eva-auto-loop-unroll 34 -eva-min-loop-unroll 2 -eva-split-return full "
                 "-eva-split-return-function kelly_receive:0:-1,finish:0:-1,append:full -eva-use-spec kelly_cobs,kelly_crc32c"),
    "device": (["app/estimate", "app/bench", "tables/paper"],
               "-eva-precision 0 -eva-slevel 30 -eva-auto-loop-unroll 100 -eva-min-loop-unroll 2 -eva-split-return full"),
    "plant": (MODEL + ["plant", "axial"],
              "-eva-precision 1 -eva-slevel 200 -eva-slevel-function kelly_plant_start:5000,kelly_plant_start_commanded:5000,prepare:5000,start:5000,use:2000 -eva-domains cvalue,equality,symbolic-locations -eva-auto-loop-unroll 24 -eva-split-return full "
              "-eva-use-spec kelly_sin_turn"),
}
# Drivers of what computes in wide (real.h), which is float on a board: run as there, too.
BOARD = "math exp interval statistics text device sequence rare look walk".split()
# what each file needs besides eva.h
FLAGS = {"step": "-include torque.h", "turns": "-DSLICES_A=1 -include torque.h -DKELLY_VECTORS=4", "driven": "-include torque.h",
         **dict.fromkeys(("unpacking", "round trip"), " -include receiver.h"),
         **dict.fromkeys(("level", "next level", "look at a mode"), " -include levels.h"), "lemmas": " -DQUOTIENTS -include levels.h",
         "seeds": " -DQUOTIENTS -DEVA_LOG32 -include levels.h"}

# name: (files, functions, options, options where a fault is planted): goals of WP, run-time errors included. Split: a branch of a loop's
# body, a goal. Where a fault is planted a goal has as long as the sound program's goals do not take.
SPLIT = "-wp-split -wp-timeout 240"
INDICES = SPLIT + " -wp-model Typed+real -warn-special-float none"
BY_EVA = " -wp-prop=-argument"
WP = {
    "packing": (["firmware/link/frame"], "kelly_cobs", SPLIT, SPLIT + " -wp-prop packed -wp-timeout 10"),
    "unpacking": (["firmware/link/frame", "tests/eva/roundtrip"], "append,kelly_receive", SPLIT, SPLIT + " -wp-timeout 10"),
    "round trip": (["firmware/link/frame", "tests/eva/roundtrip"], "round_trip", SPLIT, SPLIT + " -wp-prop one -wp-timeout 30"),
    "heap": (["firmware/rare"], "sink,heap,pop", SPLIT, SPLIT + " -wp-timeout 5"),
    "lemmas": (["firmware/rare"], "", INDICES + " -wp-prop @lemma", INDICES + " -wp-prop @lemma -wp-timeout 5"),
    "ring": (["firmware/app/out"], "send_one,out_defer,out_pump,out_room,out_byte", "-wp-timeout 40", "-wp-timeout 10"),
    "level": (["firmware/rare"], "kth_guide,count_different,know_failures,inside,count_pairs,measure,choose_seeds,key_move,is_led,propose,draw_all,"
              "descend,settle,kelly_rare_failed,kelly_rare_count,kelly_rare_start,kelly_rare_lead", INDICES + BY_EVA, INDICES + " -wp-prop span,hinted,share -wp-timeout 20"),
    "next level": (["firmware/rare"], "now,adapt,judge,judge_failures,end_level,next_level,kelly_rare_accept", INDICES + BY_EVA,
                   INDICES + " -wp-prop turn -wp-timeout 20"),
    "seeds": (["firmware/rare_walk"], "kelly_rare_aim", INDICES + BY_EVA, INDICES + BY_EVA + " -wp-timeout 20"),
    "look at a mode": (["firmware/rare_look"], "enough_of,reached,kelly_rare_look,kelly_rare_see,share_seen", INDICES + BY_EVA,
                       INDICES + " -wp-prop front,share -wp-timeout 20"),
}

# What the proofs take for granted, besides Frama-C itself.
ASSUMED = [
    "one lane a vector (KELLY_WIDTH 1), one vector and four; the committed table, x86-64 sizes; wider vectors are the same source and are "
    "compared with it bit by bit",
    "memory holds what was written to it (lanes.h reads the guarded state as volatile: faults are struck, not proved)",
    "sqrtf is correctly rounded, __builtin_clzll counts as gcc says",
    "draws within what string_model.h says of mu (fc + f0), a1, a2, w0; h w0 within 2.8 rad a step (kelly_realise)",
    "a step starts from a state within bounds: stages up to 1e7 rad/s, and a lever h/2 (sum of b^2) that fits the weight as "
    "kelly_realise has it; that RK4 stays within them is its stability, and is checked at run time (kelly_block_sane)",
    "steps of 2 beta and more; weights between a lightest and a heaviest slice, counts of modes of a plant but 1 and all, of a realisation and a guide but "
    "all, and all slices of a2 but one where there are four vectors are left to --rest",
    "on a board wide is float: the drivers of what has it there are run so too (BOARD); reweight.h and sobol.h are for where it is double",
    "string_model.h: impedance of a drive within 1e12, its frequency within 1 kHz; envelope.h: no x that is not finite",
    "under a soft drive or a commanded top: what a step moves belongs together as tests/eva/driven.c has it (kelly_realise)",
    "plant.h: readings of a sane string, speeds within 1e6 rad/s, modal values within 1e15",
    "ensemble.h: propagators are stubs there",
    "rare.h: memory, indices and what is summed or divided over the samples of a level are proved for a level of any size (WP, floats as reals, "
    "with room for their rounding; not that a loop ends), all other values with 40 samples; a run that is done has a failure "
    "among its samples and the finds that judge_failures asks for, and what was measured of a level stays; tests/eva/levels.h is taken at its word of "
    "kelly_rare_move, kelly_rare_guess, kelly_rare_resonance, kelly_rare_product, kelly_rare_read, kelly_rng_key, kelly_gamma_normal, kelly_splitmix64; a walk stays within |x| of 1000, as "
    "9.3 sqrt(1 + moves) is all that 11 levels of 9 led moves of 8 steps make; hints within 1e6, a level of them within 1e9, variances of a level within 1e9",
    "rare.h: speeds of 0.01 rad/s and more, under a guide or hint that lies within the ranges of string_model.h",
    "link.h, wits.h: numbers within 1e30; sobol.h: values within 1e12",
    "a board's line has 80 bytes; its keys have 1 to 7 characters",
    "host programs are not analysed: their parsers (options, journal, stored runs) are fuzzed",
]

# name: (driver or proof of WP, file to change, text, what it becomes)
PLANTED = {
    "a ring one byte too full": ("ring", "firmware/app/out.c", "if (waiting == OUT_RING) {", "if (waiting > OUT_RING) {"),
    "a byte in another's place": ("ring", "firmware/app/out.c", "ring[(oldest + waiting) % OUT_RING] = byte;", "ring[waiting % OUT_RING] = byte;"),
    "a child beyond the heap": ("heap", "firmware/rare.c", "child + 1 < n && keys[child + 1]", "child + 1 <= n && keys[child + 1]"),
    "a chain beyond the last": ("level", "firmware/rare.c", "rare->at * rare->chains + from;", "rare->at * rare->chains + from + 1;"),
    "a hint that nobody gave": ("level", "firmware/rare.c", "return rare->leads && rare->at", "return rare->at"),
    "a spread of all": ("level", "firmware/rare.c", "if (found == rare->n || found == 0) {", "if (found == 0) {"),
    "a mean of none": ("seeds", "firmware/rare_walk.c", "mean = n > 0.0f ? sum / n : 0.0f;", "mean = sum / n;"),
    "a share of none": ("look at a mode", "firmware/rare_look.c", "if (seen->failed > 0) {", "{"),
    "a seed beyond the front": ("look at a mode", "firmware/rare_look.c", "i < look->n && kept < most", "i <= look->n && kept < most"),
    "a state beyond the last": ("next level", "firmware/rare.c", "rare->at + 1 < KELLY_RARE_STATES", "rare->at < KELLY_RARE_STATES"),
    "seeds beyond the samples": ("seeds", "firmware/rare_walk.c", "i < rare->chains; i++", "i <= rare->n; i++"),
    "a byte that is not sent": ("ring", "firmware/app/out.c", "    board_write(ring[oldest]);\n", ""),
    "a byte that is dropped": ("ring", "firmware/app/out.c", "        board_write(byte);\n", ""),
    "off by one in COBS": ("packing", "firmware/link/frame.c", "if (at - code_at == GROUP) {", "if (at - code_at == GROUP + 1u) {"),
    "a full group without its code": ("packing", "firmware/link/frame.c", "            to[code_at] = (uint8_t)GROUP;\n", ""),
    "a 0 behind a full group": ("unpacking", "firmware/link/frame.c", "last != 0 && last != GROUP ?", "last != 0 ?"),
    "a group one byte too long": ("unpacking", "firmware/link/frame.c", "receiver->left = (uint8_t)(byte - 1u);", "receiver->left = byte;"),
    "a receiver that promises no byte": ("round trip", "tests/eva/receiver.h", "    ensures \\old(appended(receiver)) == 1 ==> receiver->payload["
                                         "\\old(received(receiver))] == (\\old(receiver->left) > 0 ? byte : 0);\n", ""),
    "no bound on a received payload": ("link", "firmware/link/frame.c", "if (receiver->size >= KELLY_FRAME_MAX) {", "if (receiver->size > KELLY_FRAME_MAX) {"),
    "no check of a text's length": ("messages", "firmware/link/fields.c", "value.low > f->what >> 4 || ", ""),
    "a spread that overflows": ("strings", "firmware/realisation.c", "run->cov[parameter] >= LEAST_COV", "run->cov[parameter] > 0.0f"),
    "digits without end": ("lines", "firmware/app/scpi.c", "++digits > 9u", "++digits > 10u"),
    "a vector behind the last": ("turns", "firmware/integrator.c", "torque(&block->lane[(v + lag) % vectors], &at[(v + lag) % vectors], 5 - lag);",
                                 "torque(&block->lane[v + lag], &at[v + lag], 5 - lag);"),
    "a mean over no time": ("ensemble", "firmware/ensemble.c", "steps == 0 || ", ""),
    "a root that begins at 0": ("indices", "firmware/sobol.c", "    r = 1 + x; ", "    r = x; "),
    "a fraction over 0": ("interval", "firmware/interval.c", "x > TINY ? x : TINY", "x"),
    "a resonance over 0": ("guide", "firmware/rare_guide.c", "square > LEAST_SQUARE ? square : LEAST_SQUARE", "square"),
    "a logarithm over 0": ("normal", "firmware/random.c", "s >= 0x1.0p-62f && ", ""),
}

USED = ("tests/eva/contracts.h", "tests/eva/torque.h", "tests/eva/kernel.h", "FRAMAC_SHARE")

count = {True: 0, False: 0}


def claim(holds, text):
    holds = bool(holds)
    count[holds] += 1
    if not holds:
        print("FAILED: " + text, flush=True)
    return holds


def frama_c(root, directory, files, options, flags=""):
    """-> everything that it prints"""
    flags = f"-I{root}/firmware -I{root}/firmware/board -I{root}/tests/eva -include eva.h {flags}"
    command = ["frama-c", "-c11", "-machdep", "gcc_x86_64", f"-cpp-extra-args={flags}", "-kernel-warn-key", "parser:decimal-float=inactive"]
    ran = subprocess.run(command + files + options, cwd=directory, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    return ran.stdout.decode(errors="replace").replace(root + "/", "")


def eva(root, name, driver, more=""):
    """Lines of eva_report.ml for one driver, with more flags of the preprocessor."""
    files, options = DRIVERS[driver]
    directory = os.path.join(OUT, name)
    os.makedirs(directory, exist_ok=True)
    script = os.path.join(directory, "eva_report.ml")         # compiled beside itself
    shutil.copy(os.path.join(EVA, "eva_report.ml"), script)
    sources = [os.path.join(root, "tests", "eva", driver + ".c")] + [os.path.join(root, "firmware", f + ".c") for f in files]
    text = frama_c(root, directory, sources, ["-load-script", script, "-eva", "-eva-verbose", "0", "-kernel-verbose", "0", "-eva-no-print",
                                              "-warn-special-float", "non-finite"] + options.split(), FLAGS.get(driver, "") + more + " -DKELLY_DOUBLE" * DOUBLE)
    with open(os.path.join(directory, "log.txt"), "w", encoding="utf-8") as file:
        file.write(text)
    return text.splitlines()


def open_ones(lines):
    """Alarms and contracts in doubt. Contracts that a driver uses (contracts.h) are proved by another, what a function ensures, what a
    loop keeps and what has a name in a file of WP by that; `reachability` is no property of the program."""
    by_wp = "|".join(re.escape(f"{files[0]}.c") for files, *_ in WP.values())
    proved = rf"open (?:{by_wp}):\d+ (ensures|(for given: )?loop invariant|assert [a-z]+:) "
    found = [line[5:] for line in lines if line.startswith("open ") and not re.match(proved, line)]
    return [f for f in found if not re.search(" reachability (of|post) ", f) and not f.startswith(USED)
            and not re.match(r"\S+ (default behavior|behavior given$|assigns )", f)]


class Coverage:
    """What the drivers reach together, of the functions of firmware/."""

    def __init__(self):
        self.reached, self.all, self.files, self.lines, self.dead = set(), set(), set(), {}, {}

    def take(self, lines):
        """Of one driver. A function that it takes by its contract is called, but none of its statements is reached."""
        dead = {}
        taken = {line.split()[3] for line in lines if line.startswith("statements 0 ")}
        for line in lines:
            words = line.split()
            if words[:1] == ["dead"]:
                if words[2] not in taken:
                    dead.setdefault(re.sub(r"_\d+$", "", words[2]) + " " + words[1].split(":")[0], set()).add(words[1])
        for line in lines:
            words = line.split()
            if words[:1] in (["reached"], ["unreached"]) and words[2].startswith("firmware/"):
                key = re.sub(r"_\d+$", "", words[1]) + " " + words[2]      # a static of a header has a copy in each file
                self.all.add(key)
                self.files.add(words[2])
                if words[0] == "reached" and words[1] not in taken:
                    self.reached.add(key)
                    self.dead[key] = self.dead.get(key, dead.get(key, set())) & dead.get(key, set())
            elif words[:1] == ["statements"] and words[4].startswith("firmware/"):
                key = re.sub(r"_\d+$", "", words[3]) + " " + words[4]
                best = self.lines.get(key, (0, 0))
                self.lines[key] = max(best, (int(words[1]), int(words[2])))


def wp(root, name, planted=False):
    """-> goals proved, goals"""
    files, functions, *options = WP[name]
    directory = os.path.join(OUT, "wp-" + name.replace(" ", "-"))
    os.makedirs(directory, exist_ok=True)
    text = frama_c(root, directory, [os.path.join(root, file + ".c") for file in files],
                   ["-wp", "-wp-rte", *["-wp-fct", functions] * bool(functions), "-wp-prover", "z3,cvc4", *options[planted].split()],
                   "-include contracts.h" + FLAGS.get(name, ""))
    with open(os.path.join(directory, "log.txt"), "w", encoding="utf-8") as file_:
        file_.write(text)
    found = re.search(r"Proved goals:\s+(\d+) / (\d+)", text)
    return (int(found[1]), int(found[2])) if found else (0, 0)


def rest():
    """(driver, flags) of what a driver leaves out: weights from 2^4 and 2^26 on, inwards; laws; counts of modes."""
    laws = " -USLICES_A -DSLICES_A=9"
    weights = [f" -DLEAST_M={2.0 ** k} -DLARGEST_M={2.0 ** (30 - k)}" for k in range(4, 16)]
    counts = [("plant", " -DFURTHER=1"), *[(driver, f" -DMODES={n}") for n in range(1, 20) for driver in ("load", "guide")]]
    return [*counts, *[("turns", laws + of) for of in ["", *weights]], *[(d, of) for of in weights for d in ("torque", "step", "driven")]]


def prove(runs):
    """Of each (driver, more flags)."""
    coverage, alarms, valid = Coverage(), 0, 0
    with concurrent.futures.ThreadPoolExecutor(JOBS) as pool:
        for (driver, more), lines in zip(runs, pool.map(lambda run: eva(ROOT, (run[0] + run[1]).replace(" ", ""), *run), runs)):
            found = open_ones(lines)
            done = [int(line.split()[1]) for line in lines if re.fullmatch(r"valid \d+", line)]
            claim(len(done) == 1, f"{driver}: the analysis comes to its end: {' '.join(lines[-3:])}")
            claim(not found, f"{driver}: nothing is open: " + "; ".join(found[:12]))
            broken = [line for line in lines if line.startswith("false ") and not re.search(" reachability (of|post) ", line)]
            claim(not broken, f"{driver}: nothing is false, which would end the analysis there: " + "; ".join(broken))
            alarms += len(found)
            valid += sum(done)
            coverage.take(lines)
            print(f"{driver}{more}: {len(found)} open, {sum(done)} proved", flush=True)
    return coverage, alarms, valid


def contracts():
    """Names of what WP proves in this run."""
    return [name for name, (_, _, usual, _) in WP.items() if (INDICES in usual) == LEVELS]


def prove_contracts(coverage):
    """What WP proves; (goals proved, goals)."""
    proved = goals = 0
    for name in contracts():
        files, functions, usual, _ = WP[name]
        p, g = wp(ROOT, name, planted=True)
        claim(p == g and g > 0, f"WP: {name}: {p} of {g} goals in the time that a planted fault has: it might be found for that alone")
        p, g = wp(ROOT, name)
        if claim(p == g and g > 0, f"WP: {name}: {p} of {g} goals") and INDICES not in usual:      # what values there are is Eva's to say
            coverage.reached.update(coverage.all & {f"{function} {files[0]}.c" for function in functions.split(",")})
        proved, goals = proved + p, goals + g
    return proved, goals


def check_contracts():
    """Whatever promises something is proved by one entry of WP or another, or said to be assumed."""
    for file in sorted({files[0] for files, *_ in WP.values()}):
        with open(os.path.join(ROOT, file + ".c"), encoding="utf-8") as source:
            text = source.read()
        promising = re.findall(r"ensures [^*]*\*/\n[\w *]*?\**(\w+)\(", text)
        bodies = re.findall(r"^[a-z][\w *]*?\**(\w+)\([^;{]*\n\{\n(.*?)^\}", text, re.M | re.S)
        promising += [function for function, body in bodies if re.search("loop invariant|@ *assert [a-z]+:", body)]
        done = [function for files, functions, *_ in WP.values() if files[0] == file for function in functions.split(",")]
        claim(set(promising) <= set(done), f"WP: {file}: {promising} promise something, {done} are proved")
    with open(os.path.join(EVA, "levels.h"), encoding="utf-8") as header:
        promising = re.findall(r"\*/\n[\w *]*?\**(\w+)\(", header.read())
    done = {function for _, functions, *_ in WP.values() for function in functions.split(",")}
    assumed = re.search(r"levels.h is taken at its word of ([\w, ]+);", " ".join(ASSUMED))[1].split(", ")
    left = [function for function in promising if function not in done and function not in assumed]
    claim(promising and not left, f"WP: levels.h promises something of {left}, which is neither proved nor said to be assumed")


def cover(coverage):
    unreached = sorted(coverage.all - coverage.reached)
    claim(not unreached, "every function is reached: " + ", ".join(unreached))
    reached, statements = (sum(v[k] for v in coverage.lines.values()) for k in (0, 1))
    for key in sorted(coverage.dead):
        if coverage.dead[key]:
            print(f"not reached by any input: {key.split()[0]}, " + ", ".join(sorted(coverage.dead[key])))
    return reached, statements


def planted():
    return {name: fault for name, fault in PLANTED.items() if fault[0] in contracts() or not LEVELS and fault[0] in DRIVERS}


def faults():
    found = 0
    copy = os.path.join(OUT, "planted")
    for name, (where, path, old, new) in planted().items():
        shutil.rmtree(copy, ignore_errors=True)
        for part in ("firmware", "tests/eva"):
            shutil.copytree(os.path.join(ROOT, part), os.path.join(copy, part))
        with open(os.path.join(copy, path), encoding="utf-8") as file:
            text = file.read()
        claim(text.count(old) == 1, f"{name}: its place is there once")
        with open(os.path.join(copy, path), "w", encoding="utf-8") as file:
            file.write(text.replace(old, new))
        if where in DRIVERS:
            seen = bool(open_ones(eva(copy, "planted-run", where)))
        else:
            proved, goals = wp(copy, where, planted=True)
            seen = proved < goals
        found += claim(seen, f"{name}: planted, and not found")
    return found


def main():
    only = [name for name in sys.argv[1:] if name not in OPTIONS]
    if not set(only) <= set(DRIVERS):
        sys.exit(f"check_eva: {', '.join(set(only) - set(DRIVERS))}: neither one of {', '.join(OPTIONS)} nor a driver")
    runs = [] if LEVELS else rest() if REST else [(name, "") for name in only or DRIVERS] + [(name, " -ffreestanding") for name in BOARD if not only and not DOUBLE]
    if shutil.which("why3"):      # a list of provers of our own: another run beside this one may be writing its
        os.makedirs(OUT, exist_ok=True)
        os.environ["WHY3CONFIG"] = os.path.join(OUT, "why3.conf")
        subprocess.run(["why3", "config", "detect"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    coverage, alarms, valid = prove(runs)
    if LEVELS:
        proved, goals = prove_contracts(coverage)
        print(f"figure: proof by WP, levels of rare events of any size, goals proved: {proved} of {goals}")
        print(f"figure: proof by WP, levels of rare events of any size, planted faults found: {faults()} of {len(planted())}")
    elif REST:
        what = f"figure: proof by Eva{' in double' * DOUBLE}, what the other run leaves out"
        print(f"{what}, alarms with -warn-special-float non-finite: {alarms}")
        print(f"{what}, properties proved by {len(runs)} runs: {valid}")
    elif DOUBLE:
        print(f"figure: proof by Eva in double, alarms with -warn-special-float non-finite: {alarms}")
        print(f"figure: proof by Eva in double, properties proved by {len(runs)} of {len(DRIVERS)} drivers: {valid}")
    elif not only:
        proved, goals = prove_contracts(coverage)
        check_contracts()
        reached, statements = cover(coverage)
        found = faults()
        for text in ASSUMED:
            print("assumed: " + text)
        sources = {os.path.relpath(os.path.join(d, f), ROOT) for part in (".", "link", "app")
                   for d in [os.path.normpath(os.path.join(ROOT, "firmware", part))] for f in os.listdir(d) if f.endswith(".c")}
        claim(sources <= coverage.files, "every file is analysed: " + ", ".join(sorted(sources - coverage.files)))
        print(f"figure: proof by Eva, source files of kernel, link and device program analysed: {len(sources & coverage.files)} of {len(sources)}")
        print(f"figure: proof by Eva, alarms with -warn-special-float non-finite: {alarms}")
        print(f"figure: proof by Eva, functions reached: {len(coverage.reached)} of {len(coverage.all)} in {len(coverage.files)} files")
        print(f"figure: proof by Eva, statements reached: {reached} of {statements}")
        print(f"figure: proof by Eva, properties proved: {valid}")
        print(f"figure: proof by WP, goals proved: {proved} of {goals}")
        print(f"figure: proof, planted faults found: {found} of {len(planted())}")
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
