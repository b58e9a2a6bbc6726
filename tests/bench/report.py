"""Turn the benchmark's measurements into a table for people (terminal, Markdown) and one JSON file.

    report.py MEASUREMENTS PROGRAM OUT.json OUT.md
"""
import collections
import json
import re
import subprocess
import sys

# Operations of one step of one realisation as the source has them, ten modes: form_s.h and form_m.h, stages.h, bitrock.h, detmath.h.
# The first mode begins the sums and adds nothing.
FORM = {
    "float": {"ten modes": 10 * 17 - 4,      # form S: move 9, outputs 4, sums 4
              "four torques": 4 * 21,        # tanh 12, Stribeck term and product 9
              "their speeds and times": 19, "inputs of the modes": 9, "stage speeds": 17},
    "double": {"ten modes": 10 * 30 - 5,     # form M: move 16, outputs 9, sums 5
               "four torques": 4 * 29,       # tanh 20
               "their speeds and times": 19, "inputs of the modes": 14, "stage speeds": 14},
}
FORM_OPERATIONS = {real: sum(form.values()) for real, form in FORM.items()}
FORM_OTHERS = {"divisions": 4, "clamps, minima and maxima": 4 + 2 + 2}

MNEMONIC = re.compile(r"^v?(mul|add|sub|div|min|max|fm|fnm|mov|and|or|xor|broadcast|blend|cmp|shuf|perm|extract|insert|cvt|unpck)[a-z0-9]*?([sp][sd])?$")
KINDS = {"mul": "mul", "add": "add", "sub": "add", "div": "div", "min": "minmax", "max": "minmax", "fm": "fma", "fnm": "fma"}


def read(path):
    rows = collections.defaultdict(list)
    with open(path) as lines:
        for line in lines:
            row = json.loads(line)
            rows[row.pop("kind")].append(row)
    return rows


def listing(program):
    """address -> mnemonic and operands, of the whole program; empty where there is no objdump."""
    try:
        text = subprocess.run(["objdump", "-d", "--no-show-raw-insn", program], capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return {}
    found = re.findall(r"^ +([0-9a-f]+):\t(\S+) *(.*)$", text, re.M)
    return {address: (mnemonic, operands) for address, mnemonic, operands in found}


def kind_of(mnemonic, operands):
    m = MNEMONIC.match(mnemonic)
    if m and m.group(1) in KINDS and m.group(2):
        return KINDS[m.group(1)] if m.group(2)[0] == "p" else "scalar " + KINDS[m.group(1)]
    if "mov" in mnemonic and re.search(r"%[xyz]mm", operands):
        if "(" not in operands:
            return "register moves"
        return "stores" if operands.rstrip().endswith(")") else "loads"
    return "others"


def instructions(row, code):
    """Machine instructions of one step of one vector, by kind; memory operands of arithmetic counted beside."""
    sums = collections.Counter()
    for address, hits in row["hits"].items():
        mnemonic, operands = code.get(address, ("?", ""))
        kind = kind_of(mnemonic, operands)
        sums[kind] += hits
        sums["all"] += hits
        if kind in ("mul", "add", "div", "minmax", "fma") and "(" in operands:
            sums["with a memory operand"] += hits
    return {k: v / row["vectors"] for k, v in sorted(sums.items())}


def best_builds(times):
    """One row a name: the fastest of its builds. Failed peers stay visible."""
    best = {}
    for row in times:
        old = best.get(row["name"])
        if old is None or (row["ok"], -row["ns"]) > (old["ok"], -old["ns"]):
            best[row["name"]] = row
    return list(best.values())


def setting_of(row):
    if "kelly" in row:
        return "RK4, 1 ms"
    if row["told"]:
        return row["told"]
    if row["rtol"] > 0:
        text = "rtol %.2g, atol %.2g" % (row["rtol"], row["atol"])
        return text + (", h <= %g ms" % (1e3 * row["h"]) if row["h"] < 1 else "")
    return "%g ms" % (1e3 * row["h"])


def table(header, rows):
    """Markdown that also reads well on a terminal: padded columns, numbers to the right."""
    cells = [header] + rows
    width = [max(len(r[i]) for r in cells) for i in range(len(header))]
    def line(r):
        return "| " + " | ".join(r[i].ljust(width[i]) if i == 0 or not rows or not re.match(r"^[-0-9.]*$", rows[0][i]) else r[i].rjust(width[i])
                                 for i in range(len(header))) + " |"
    return "\n".join([line(header), "|" + "|".join("-" * (w + 2) for w in width) + "|"] + [line(r) for r in rows])


def number(x, digits=3):
    if x is None:
        return ""
    return "%.*f" % (max(0, digits - len(str(int(abs(x))))) if abs(x) >= 1 else digits - 1, x)


def main_table(best, one):
    rows = []
    units = [r["engine"] for r in best if "kelly" in r]
    shown = [r for r in best if r.get("count") != 1 or r["engine"] in (units[0], units[-1])]     # alone: scalar and the widest
    for row in sorted(shown, key=lambda r: (r["ns"] < 0, r["ns"])):
        name = ("**%s**" if "kelly" in row else "%s") % row["name"]
        if not row["ok"]:
            rows.append([name, "FAILED", "", "%s" % row["error_rpm"], "", "", setting_of(row), row["flags"]])
            continue
        rows.append([name, number(row["ns"]), number(row["ns"] / one), "%.3f" % row["error_rpm"], number(row.get("drawn_ns")),
                     "%.3f" % row["drawn_error_rpm"] if "drawn_error_rpm" in row else "", setting_of(row),
                     row["flags"]])
    return table(["who", "ns", "times kelly", "error, rpm", "ns, drawn", "rpm, drawn", "setting", "flags"], rows)


def peak_table(rows, best, counts):
    """What kelly reaches of the separate multiply and add rate of each unit."""
    peaks = {p["unit"]: p for p in rows["peak"]}
    out, data = [], []
    for row in best:
        unit = row.get("engine")
        if unit not in peaks or row["count"] == 1:
            continue
        count = counts.get((unit, row["kelly"], row["guarded"]), {})
        operations = count.get("mul", 0) + count.get("add", 0)
        source = "machine code"
        if not operations:
            operations, source = FORM_OPERATIONS[row["kelly"]], "form"
        everything = operations + (count["div"] + count["minmax"] if count else sum(FORM_OTHERS.values()))
        rate = operations / row["ns"]
        peak = peaks[unit][row["kelly"]]
        data.append({"engine": unit, "real": row["kelly"], "guarded": row["guarded"], "operations": operations, "all": everything, "counted_from": source, "rate": rate,
                     "peak": peak, "fraction": rate / peak})
        out.append([row["kelly"] + ", " + unit + ("" if row["guarded"] else ", unguarded"), number(row["ns"]), "%.0f" % operations, number(rate), number(peak), "%.0f %%" % (100 * rate / peak),
                    "%.0f" % count["all"] if count else "", "%.0f" % (count.get("loads", 0) + count.get("with a memory operand", 0)) if count else "",
                    "%.0f" % count.get("stores", 0) if count else ""])
    return table(["kelly", "ns", "mul + add", "Gop/s", "peak Gop/s", "of peak", "instructions", "reads", "writes"], out), data


def growth_lines(rows):
    lines = []
    samples = rows["samples"]
    if samples:
        lines.append(table(["samples of 4 s, one thread", "s", "us a sample", "peak memory, MB"],
                           [["%d" % r["samples"], "%.3f" % r["seconds"], number(1e6 * r["seconds"] / r["samples"]), "%.1f" % r["megabytes"]]
                            for r in samples]))
    for what in ("modes", "lanes"):
        by = collections.defaultdict(dict)
        for r in rows[what]:
            by[r[what]][r["real"]] = r["ns"]
        lines.append(table([what, "ns, float", "ns, double"], [["%d" % n, number(v.get("float")), number(v.get("double"))] for n, v in sorted(by.items())]))
    first = {r["real"]: r for r in rows["threads"] if r["threads"] == 1}
    lines.append(table(["400 x 100 s, whole program", "threads", "s, median", "s, least", "s of processor", "speed-up", "of the least"],
                       [[r["real"], "%d" % r["threads"], "%.3f" % r["seconds"], "%.3f" % r["least"], "%.3f" % r["processor"],
                         "%.2f" % (first[r["real"]]["seconds"] / r["seconds"]),
                         "%.2f" % (first[r["real"]]["least"] / r["least"])] for r in rows["threads"]]))
    return "\n\n".join(lines)


def digests(rows):
    """One digest for each precision, whatever the vector unit. Returns the sentence and whether it holds."""
    by = collections.defaultdict(set)
    for r in rows["digest"]:
        by[r["real"]].add(r["digest"])
    units = ", ".join(dict.fromkeys(r["engine"] for r in rows["digest"]))
    good = all(len(v) == 1 for v in by.values())
    said = "; ".join("%s %s" % (k, " ".join(sorted(v))) for k, v in by.items())
    return "Digest of 96 realisations x 100 s on %s: %s%s." % (units, said, "" if good else " -- THEY DIFFER"), good


def target_lines(best, of_peak, rows):
    """The figures that were aimed at, from this run."""
    ns = {r["name"]: r["ns"] for r in best if r["ok"]}

    def kelly(real, guarded, one=False):
        return min(r["ns"] for r in best if r.get("kelly") == real and r["guarded"] == guarded and (r["count"] == 1) == one)
    dopri, plain = min((v for k, v in ns.items() if "dopri5" in k), default=None), ns.get("textbook C, libm, double")
    lines = []
    for guarded in (True, False):
        how = "As built" if guarded else "Unguarded (-DKELLY_GUARD=0)"
        if dopri and plain:
            f, d = kelly("float", guarded), kelly("double", guarded)
            lines.append("%s: float %.1f times faster than Boost's dopri5, %.1f times textbook C with libm; double %.1f and %.1f times."
                         % (how, dopri / f, plain / f, dopri / d, plain / d))
        if of_peak:
            lines.append("Of the machine's separate multiply and add peak: "
                         + ", ".join("%s %s %.0f %%" % (p["engine"], p["real"], 100 * p["fraction"]) for p in of_peak if p["guarded"] == guarded) + ".")
    if plain:
        lines.append("One realisation alone, float: %.1f times textbook C with libm." % (plain / kelly("float", True, one=True)))
    return "\n".join(lines)


def main():
    measurements, program, json_path, md_path = sys.argv[1:5]
    rows = read(measurements)
    best = best_builds(rows["time"])
    fastest = min((r["ns"] for r in best if r.get("kelly") == "float" and r["guarded"] and r["ok"]), default=1.0)
    code = listing(program)
    counts = {(r["engine"], r["real"], r["guarded"]): instructions(r, code) for r in rows["steps"]} if code else {}
    peak_text, of_peak = peak_table(rows, best, counts)
    digest_text, good = digests(rows)
    text = "\n\n".join([
        "Nanoseconds to simulate 1 ms of one realisation on one core: medians of interleaved runs of 100 s (numpy: 3 s) of the nominal string on\n"
        "hard rock. Error: largest distance of the bit speed from a reference. Adaptive peers have the settings at which they are fastest with an\n"
        "error like that of RK4 at 1 ms; each peer is shown at its best flags of three. Drawn: the same settings on 8 drawn realisations that are\n"
        "not chaotic, mean time and largest error.",
        main_table(best, fastest),
        target_lines(best, of_peak, rows),
        peak_text,
        "Operations: multiplies and additions of one step of one realisation, counted in the machine code as it ran; the source has\n"
        "10 x 17 - 4 + %d = %d in float and 10 x 30 - 5 + %d = %d in double, and %d divisions and %d clamps, minima and maxima beside. Instructions, reads and\n"
        "writes: of one step of one vector."
        % (FORM_OPERATIONS["float"] - FORM["float"]["ten modes"], FORM_OPERATIONS["float"], FORM_OPERATIONS["double"] - FORM["double"]["ten modes"],
           FORM_OPERATIONS["double"], FORM_OTHERS["divisions"], FORM_OTHERS["clamps, minima and maxima"]),
        digest_text,
        growth_lines(rows),
    ])
    print(text)
    with open(md_path, "w") as out:
        out.write(text + "\n")
    with open(json_path, "w") as out:
        json.dump({"time": rows["time"], "best": best, "peak": rows["peak"], "of_peak": of_peak, "form_operations": FORM_OPERATIONS,
                   "instructions": [{"engine": k[0], "real": k[1], "guarded": k[2], "per_step_and_vector": v} for k, v in counts.items()],
                   "digest": rows["digest"], "samples": rows["samples"], "modes": rows["modes"], "lanes": rows["lanes"],
                   "threads": rows["threads"]}, out, indent=1)
    if not good or not all(r["ok"] for r in rows["time"]):
        sys.exit(1)


if __name__ == "__main__":
    main()
