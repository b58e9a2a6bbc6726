#!/usr/bin/env python3
"""draw_map - the driller's map: RPM on x, WOB on y, P(stick-slip) from rest and already rotating.

usage: host/draw_map.py MAP.json STEM [--rpm R --wob W]     -> STEM.png, STEM.svg

Everything drawn is in the JSON of `kelly map`. --rpm and --wob put the operating point elsewhere than at the well file's.
Needs matplotlib (Debian: python3-matplotlib).
"""
import argparse
import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.colors import LinearSegmentedColormap  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.patheffects import withStroke  # noqa: E402

LEVELS = {0.05: ("5 %", "dotted"), 0.5: ("50 %", "solid"), 0.95: ("95 %", "dashed")}
PANELS = (("rest", "started from rest", "release"), ("rotating", "already rotating", "onset"))
BLUE, GREY = "#0072B2", "#4D4D4D"
STYLE = {"font.size": 8.5, "axes.titlesize": 9, "axes.labelsize": 9, "xtick.labelsize": 8, "ytick.labelsize": 8, "legend.fontsize": 8,
         "font.family": "DejaVu Sans", "svg.hashsalt": "kelly"}
# white to a red on which black lines still read; its lightness falls steadily, so it works in grey as well
SHADES = LinearSegmentedColormap.from_list("risk", ["#ffffff", "#fff0c4", "#fdc27a", "#f08a5d", "#cf5a56"])


def numbers(row):
    """A list of the JSON, null as NaN."""
    return np.array([np.nan if x is None else x for x in row], float)


def grid(data, start, name):
    return np.array([numbers(row) for row in data[start][name]])


def label_place(path, axes):
    """The point of a contour line nearest to the middle of the upper half of its panel: off the markers' crowd and the star."""
    at = axes.transData.transform(path) - axes.transAxes.transform((0.45, 0.8))
    return path[np.argmin((at ** 2).sum(axis=1))]


def draw_contours(axes, rpm, wob, p):
    """The three lines, each with its label; a level that does not occur is left out."""
    inside = [level for level in LEVELS if np.nanmin(p) < level < np.nanmax(p)]
    if not inside:
        return
    lines = axes.contour(rpm, wob, p, levels=inside, colors="black", linestyles=[LEVELS[level][1] for level in inside], linewidths=1.3, zorder=3)
    for level, parts in zip(inside, lines.allsegs):
        place = label_place(max(parts, key=len), axes)
        axes.annotate(LEVELS[level][0], place, xytext=(-5, 2), textcoords="offset points", ha="right", fontsize=8.5, fontweight="bold",
                      zorder=6, path_effects=[withStroke(linewidth=2.5, foreground="white")])


def draw_panel(axes, data, panel, other, point):
    start, title, edge = panel
    rpm, wob, p = np.array(data["rpm"]), np.array(data["wob_kN"]), grid(data, start, "probability")
    axes.set(title=title, xlabel="top speed [rpm]", xlim=(rpm[0], rpm[-1]), ylim=(wob[0], wob[-1]))
    axes.tick_params(direction="in", top=True, right=True)
    shade = axes.contourf(rpm, wob, p, levels=np.linspace(0, 1, 21), cmap=SHADES)
    opposite = grid(data, other, "probability")
    if np.nanmin(opposite) < 0.5 < np.nanmax(opposite):
        axes.contour(rpm, wob, opposite, levels=[0.5], colors=GREY, linewidths=0.9, linestyles=[(0, (6, 2, 1, 2))], zorder=2)
    draw_contours(axes, rpm, wob, p)
    axes.plot(numbers(data[f"{edge}_rpm"]), wob, color=BLUE, marker="o", markersize=4.2, markerfacecolor="white", markeredgewidth=1.1,
              linestyle="none", zorder=4)
    refused = sum(grid(data, start, f"refused_{why}") for why in ("step", "range", "nonfinite")) > 0
    j, i = np.nonzero(refused)
    axes.plot(rpm[i], wob[j], "x", color=GREY, markersize=4, zorder=3, clip_on=False)
    axes.plot(*point, marker="*", markersize=14, color="white", markeredgecolor="black", markeredgewidth=1.1, zorder=7, linestyle="none")
    return shade, refused.any()


def legend(figure, point, refused):
    lines = [Line2D([], [], color="black", linestyle=style, linewidth=1.3, label=f"P = {text}") for text, style in LEVELS.values()]
    lines += [Line2D([], [], color=BLUE, marker="o", markersize=4.2, markerfacecolor="white", linestyle="none",
                     label="nominal run ceases to stick: release (left), onset (right)"),
              Line2D([], [], color=GREY, linewidth=0.9, linestyle=(0, (6, 2, 1, 2)), label="P = 50 % of the other start"),
              Line2D([], [], color="white", marker="*", markersize=11, markeredgecolor="black", linestyle="none",
                     label=f"operating point, {point[0]:g} rpm, {point[1]:g} kN")]
    if refused:
        lines.append(Line2D([], [], color=GREY, marker="x", linestyle="none", label="some realisations refused"))
    figure.legend(handles=lines, loc="lower center", ncol=2, frameon=False, columnspacing=3, handlelength=2.6)


def subtitle(data):
    case, cov = data["case"], data["case"]["cov"]
    spread = f"all five {100 * cov['rpm']:g} %" if len(set(cov.values())) == 1 else ", ".join(f"{k} {100 * v:g} %" for k, v in cov.items())
    ratio = np.array(data["f0_kN"]) / np.array(data["wob_kN"])
    weight = f"f0 = {ratio[0]:.3g} WOB" if np.allclose(ratio, ratio[0]) else f"f0 = {data['f0_kN'][0]:g} kN"
    n = f"at most {data['samples']}" if data["adaptive_width"] else f"{data['samples']}"
    drive = "" if case.get("drive", "stiff") == "stiff" else f", drive {case['drive']}"
    return (f"string {data['model']}, \u03bc = {case['mu']:g}, {weight}{drive}; coefficients of variation: {spread}\n{n} realisations a cell; "
            f"stick-slip: ss > {case['limit']:g} over {case['window_s'][0]:g}\u2013{case['window_s'][1]:g} s")


def draw(data, point):
    plt.rcParams.update(STYLE)
    figure, both = plt.subplots(1, 2, figsize=(7.1, 4.7), sharey=True)
    figure.subplots_adjust(left=0.075, right=0.885, bottom=0.255, top=0.815, wspace=0.085)
    drawn = [draw_panel(axes, data, panel, other[0], point) for axes, panel, other in zip(both, PANELS, PANELS[::-1])]
    both[0].set_ylabel("weight on bit [kN]")
    bar = figure.colorbar(drawn[0][0], cax=figure.add_axes([0.905, 0.255, 0.02, 0.56]), ticks=[0, 0.05, 0.25, 0.5, 0.75, 0.95, 1])
    bar.ax.set_yticklabels(["0", "5", "25", "50", "75", "95", "100"])
    bar.set_label("P(stick-slip) [%]", labelpad=1)
    figure.suptitle("Probability of stick-slip over speed and weight", y=0.985, fontsize=11)
    figure.text(0.5, 0.882, subtitle(data), ha="center", fontsize=7.5, color=GREY, linespacing=1.4)
    legend(figure, point, any(refused for _, refused in drawn))
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map")
    parser.add_argument("stem")
    parser.add_argument("--rpm", type=float)
    parser.add_argument("--wob", type=float)
    args = parser.parse_args()
    with open(args.map, encoding="utf-8") as file:
        data = json.load(file)
    if len(data["rpm"]) < 2 or len(data["wob_kN"]) < 2:
        sys.exit(f"draw_map: {args.map}: {len(data['rpm'])} speeds x {len(data['wob_kN'])} weights; contours need at least 2 x 2")
    point = (args.rpm or data["case"]["rpm"], args.wob or data["case"]["wob_kN"])
    figure = draw(data, point)
    figure.savefig(args.stem + ".png", dpi=200, metadata={"Software": None})
    figure.savefig(args.stem + ".svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
