#!/usr/bin/env python3
"""draw_drives - two maps of the same settings under two drives: by how much P(stick-slip) falls, and where the 50 % lines lie.

usage: host/draw_drives.py FIRST.json SECOND.json STEM     -> STEM.png, STEM.svg; figures on the terminal

Everything drawn is in the JSON of `kelly map`. Needs matplotlib (Debian: python3-matplotlib).
"""
import argparse
import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402

sys.dont_write_bytecode = True
from draw_map import BLUE, GREY, PANELS, STYLE, grid  # noqa: E402

SAME = ("rpm", "wob_kN", "f0_kN", "model", "seed", "first", "samples")


def panel(axes, first, second, start, title):
    rpm, wob = np.array(first["rpm"]), np.array(first["wob_kN"])
    p, q = grid(first, start, "probability"), grid(second, start, "probability")
    shade = axes.contourf(rpm, wob, 100 * (p - q), levels=np.arange(-52.5, 55, 5), cmap="PuOr_r", extend="both")
    for value, colour, style in ((p, "black", "solid"), (q, BLUE, "dashed")):
        if np.nanmin(value) < 0.5 < np.nanmax(value):
            axes.contour(rpm, wob, value, levels=[0.5], colors=colour, linestyles=style, linewidths=1.4)
    axes.set(title=title, xlabel="top speed [rpm]")
    axes.tick_params(direction="in", top=True, right=True)
    return shade


def tell(first, second, start):
    """Where P is not settled already, by how much it falls."""
    p, q = grid(first, start, "probability"), grid(second, start, "probability")
    open_cells, apart = (p > 0.1) & (p < 0.9), grid(second, start, "hi95") < grid(first, start, "lo95")
    fall = (p - q)[open_cells]
    print(f"{start}: {open_cells.sum()} of {p.size} cells with P of {first['case']['drive']} in 0.1..0.9; it falls there by "
          + (f"{fall.mean():.3f} on the average, {fall.min():.3f} to {fall.max():.3f}" if fall.size else "nothing")
          + f"; intervals apart in {apart.sum()} cells, higher in {(q > p).sum()} (by {max(0.0, np.nanmax(q - p)):.4f} at most)")


def draw(first, second):
    plt.rcParams.update(STYLE)
    figure, both = plt.subplots(1, 2, figsize=(7.1, 4.3), sharey=True)
    figure.subplots_adjust(left=0.075, right=0.87, bottom=0.2, top=0.815, wspace=0.085)
    for axes, (start, title, _) in zip(both, PANELS):
        shade = panel(axes, first, second, start, title)
    both[0].set_ylabel("weight on bit [kN]")
    bar = figure.colorbar(shade, cax=figure.add_axes([0.89, 0.2, 0.02, 0.615]))
    bar.set_ticks(range(-50, 51, 10))
    bar.set_label("fall of P(stick-slip) [percentage points]", labelpad=3)
    case = first["case"]
    figure.suptitle("What another top drive changes", y=0.985, fontsize=11)
    figure.text(0.5, 0.89, f"string {first['model']}, \u03bc = {case['mu']:g}; {first['samples']} realisations a cell, the same under both drives",
                ha="center", fontsize=7.5, color=GREY)
    figure.legend(handles=[Line2D([], [], color="black", label=f"P = 50 %, {case['drive']}"),
                           Line2D([], [], color=BLUE, linestyle="dashed", label=f"P = 50 %, {second['case']['drive']}")],
                  loc="lower center", ncol=2, frameon=False)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("first", "second", "stem"):
        parser.add_argument(name)
    args = parser.parse_args()
    maps = []
    for path in (args.first, args.second):
        with open(path, encoding="utf-8") as file:
            maps.append(json.load(file))
    differ = [name for name in SAME if maps[0][name] != maps[1][name]]
    if differ:
        sys.exit(f"draw_drives: {args.first} and {args.second} differ in {', '.join(differ)}; give two maps of the same settings")
    for start, *_ in PANELS:
        tell(*maps, start)
    figure = draw(*maps)
    figure.savefig(args.stem + ".png", dpi=200, metadata={"Software": None})
    figure.savefig(args.stem + ".svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
