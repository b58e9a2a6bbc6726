"""bench_answers - what a campaign on a board must give: the rows and the digest of `kelly montecarlo` of the same case."""
import csv
import os
import re
import struct
import subprocess
import tempfile

import numpy

from bench_board import as_float, link
from programs import PROGRAM


def montecarlo(samples, *extra):
    """Rows of the CSV and the digest."""
    with tempfile.TemporaryDirectory() as folder:      # of its own: a second writer of a file is refused
        path = os.path.join(folder, "run.csv")
        words = [PROGRAM["float"], "montecarlo", "--duration", "4", "--window", "2:4", "--mu", "0.04", "--cov", "0.2", "--samples", str(samples), "--csv", path]
        done = subprocess.run([*words, *extra], check=True, capture_output=True, text=True)
        with open(path, encoding="ascii", newline="") as file:
            return list(csv.DictReader(file)), re.search("digest ([0-9a-f]{8})", done.stdout)[1]


def near(value):
    """Floats that a printed, scaled one may have been."""
    middle = numpy.float32(value)
    below, above = numpy.nextafter(middle, numpy.float32(-numpy.inf)), numpy.nextafter(middle, numpy.float32(numpy.inf))
    return [float(v) for v in (numpy.nextafter(below, numpy.float32(-numpy.inf)), below, middle, above, numpy.nextafter(above, numpy.float32(numpy.inf)))]


def draw_of(row, key):
    """The draw of a row of the CSV: weight and speed are printed in other units, so the key says which floats they were."""
    mu, a1, a2 = (as_float(float(row[k])) for k in ("mu", "alpha1", "alpha2"))
    for fc in near(float(row["fc_kN"]) * 1000):
        for w0 in near(float(row["rpm"]) * numpy.pi / 30):
            if link.draw_crc((fc, mu, a1, a2, w0)) == key:
                return fc, mu, a1, a2, w0
    return None


def digest(results, rows):
    crc = 0
    for result, row in zip(results, rows):
        draw = draw_of(row, result["draw_crc"])
        if draw is None:
            return f"no such draw: {row['index']}"
        values = [result[k] for k in ("lowest", "highest", "mean", "ss")]
        crc = link.crc32c(struct.pack("<I9fB", result["index"], *draw, *values, result["status"]), crc)
    return f"{crc:08x}"


def differs(result, row):
    """Names of the columns of the CSV that a result does not have."""
    rpm = {"bit_min_rpm": "lowest", "bit_max_rpm": "highest", "bit_mean_rpm": "mean"}
    wrong = [c for c, k in rpm.items() if abs(float(row[c]) - result[k] * 30 / numpy.pi) > 2e-7 * abs(result[k] * 30 / numpy.pi)]
    wrong += [k for k in ("index", "stuck", "liftoff") if int(row[k]) != result[k]]
    if as_float(float(row["ss"])) != result["ss"] or row["status"] != link.STATUS[result["status"]]:
        wrong.append("ss, status")
    return wrong
