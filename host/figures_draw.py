"""figures_draw.py - the pictures: one style, PNG and SVG, the same bytes from the same numbers.

Colours are Okabe and Ito's (2008), which readers of every colour vision tell apart; lines differ in weight or dash as well, so that
a print in grey still reads.
"""
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

BLACK, BLUE, ORANGE, GREEN, PURPLE, SKY = "#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9"
GREY, DARK = "#D4D4D4", "#4D4D4D"
SPEED, AXIAL = "bit_speed_rpm", "bit_axial_speed_m_s"
SPEED_LABEL, AXIAL_LABEL, TIME_LABEL, HZ_LABEL = "bit speed [rpm]", "axial bit speed [m/s]", "time [s]", "frequency [Hz]"
WIDTH = 7.1                               # [in], a page of text
PARAMETERS = (("fc", r"$Y_1$: weight $|f_c|$"), ("mu", r"$Y_2$: $\mu$"), ("a1", r"$Y_3$: $\alpha_1$"), ("a2", r"$Y_4$: $\alpha_2$"),
              ("rpm", r"$Y_5$: top speed"))

plt.rcParams.update({
    "figure.dpi": 100, "savefig.dpi": 200, "font.size": 9, "font.family": "DejaVu Sans", "axes.titlesize": 9, "axes.titlelocation": "left",
    "axes.labelsize": 9, "legend.fontsize": 8, "xtick.labelsize": 8, "ytick.labelsize": 8, "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "grid.color": "#E6E6E6", "grid.linewidth": 0.6, "axes.axisbelow": True, "lines.linewidth": 1.0, "legend.frameon": False,
    "lines.solid_joinstyle": "round", "svg.hashsalt": "kelly", "path.simplify": True, "path.simplify_threshold": 0.3, "agg.path.chunksize": 20000, "figure.constrained_layout.use": True,
})


def panels(rows, columns, height, **more):
    return plt.subplots(rows, columns, figsize=(WIDTH, height), **more)


def legend_above(ax, **more):
    """Above the axes, at the right: over no data; the panel's letter stands at the left."""
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 0.985), borderaxespad=0.1, handlelength=1.8, **{"ncol": 3, "columnspacing": 1.2, **more})


def mark(ax, x, text, y=0.985, side="left"):
    ax.axvline(x, color=DARK, lw=0.7, ls=(0, (2, 2)))
    ax.annotate(text, (x, y), xycoords=("data", "axes fraction"), xytext=(3 if side == "left" else -3, 0), textcoords="offset points", ha=side,
                va="top", fontsize=8, color=DARK)


def region(ax, x, envelope, quantity, nominal):
    """95 % region, mean and nominal, as Figures 5 to 7 have them."""
    low, high = (envelope[f"{quantity}_{q}"] for q in ("q025", "q975"))
    ax.fill_between(x, low, high, color=GREY, lw=0, label="95 % region (pointwise)")
    ax.plot(x, low, color=DARK, lw=0.5)
    ax.plot(x, high, color=DARK, lw=0.5)
    ax.plot(x, nominal, color=BLUE, lw=0.8, label="nominal")
    ax.plot(x, envelope[f"{quantity}_mean"], color=BLACK, lw=1.3, label="mean")


def fig1(r):
    fig, axes = panels(1, 2, 2.9, gridspec_kw={"width_ratios": (1.0, 1.35)})
    f = r["fine f"]
    for key, label, color, lw in (("axial 10", "10 elastic modes", ORANGE, 2.6), ("axial 1", "1 elastic mode", BLUE, 1.0)):
        for ax, every in zip(axes, (1, r["finer"])):
            ax.plot(f[::every], r["axial spectra"][key][::every], color=color, lw=lw, label=label + ", and the rigid one")
    first, turn = r["peaks"]["axial 10"]
    axes[0].set(xlim=(1.2, 1.9), ylim=(0, None), xlabel=HZ_LABEL, ylabel="amplitude [m/s]", title="(a)")
    mark(axes[0], first, f"{first:.3f} Hz")
    mark(axes[0], turn, f"{turn:.3f} Hz")
    axes[1].set(xlim=(0, 10), ylim=(1e-6, None), yscale="log", xlabel=HZ_LABEL, ylabel="amplitude [m/s]", title="(b)")
    legend_above(axes[1], ncol=1)
    return fig, "Amplitude spectrum of the axial bit speed over the whole run, straight line taken out, Hann window: 10 torsional modes with 10 and with 1 " \
                "elastic axial mode besides the rigid one. (a) the two peaks; (b) all of it, logarithmic."


def fig2(r):
    fig, axes = panels(2, 1, 4.4)
    t = r["t"]
    end = t[-1]
    for ax, span, title in ((axes[0], (0, end), "(a)"), (axes[1], (0.6 * end, 0.8 * end), "(b) zoom")):
        inside = (t >= span[0]) & (t <= span[1])
        ax.axhline(100.0, color=DARK, lw=0.8, ls=(0, (4, 2)), label="top, 100 rpm")
        ax.plot(t[inside], r["torsional 1"][SPEED][inside], color=ORANGE, lw=0.9, ls=(0, (3, 1)), label="1 torsional mode")
        ax.plot(t[inside], r["axial 10"][SPEED][inside], color=BLUE, lw=1.1, label="10 torsional modes")
        ax.set(xlim=span, ylabel=SPEED_LABEL, title=title)
    axes[1].set_xlabel(TIME_LABEL)
    legend_above(axes[0])
    return fig, "Bit speed of the nominal case with 10 and with 1 torsional mode (10 elastic axial modes in both; they do not act on torsion)."


def fig3(r):
    x = r["integrals"]
    n = np.arange(1, len(x) + 1)
    value = np.cumsum(x) / n
    error = 1.96 * x.std() / np.sqrt(n)
    fig, ax = panels(1, 1, 2.7)
    ax.fill_between(n[1:], (value[-1] - error)[1:], (value[-1] + error)[1:], color=GREY, lw=0, label="1.96 standard errors")
    ax.axhline(value[-1], color=DARK, lw=0.8, ls=(0, (4, 2)), label=f"after {len(x)}")
    ax.plot(n, value, color=BLUE, lw=1.3, label=r"conv$(n_s)$")
    low, high = value[n >= 4].min(), value[n >= 4].max()
    ax.set(xlim=(0, len(x)), ylim=(min(low, value[-1] - error[min(len(x), 25) - 1]), high + 0.25 * (high - low)), xlabel=r"realisations $n_s$", ylabel=r"conv$(n_s)$ [m$^2$ s]")
    mark(ax, r["samples"], f"{r['samples']} realisations")
    ax.ticklabel_format(axis="y", style="sci", scilimits=(0, 0), useMathText=True)
    legend_above(ax)
    return fig, r"Convergence of the Monte Carlo simulation: conv(n) = (1/n) sum of int |U|^2 dt, all five parameters at 20 %, hard rock. U: nodal displacement " \
                "and twist relative to the prestressed string and to the top, SI, unweighted."


def smooth(x, n):
    """Running mean over the numbers among n values; ends left out."""
    there = ~np.isnan(x)
    return np.convolve(np.where(there, x, 0), np.ones(n), mode="valid") / np.maximum(1, np.convolve(there, np.ones(n), mode="valid"))


def fig4(r):
    rows = PARAMETERS + (("paper", "as captioned"),)
    fig, axes = panels(len(rows), 2, 8.8, sharex="col", sharey="col")
    f, t = r["f"], r["t"]
    n = max(1, int(round(5.0 / t[1])))
    for row, (name, label) in zip(axes, rows):
        pairs = (((name, 0.05), ORANGE, "5 %"), ((name, 0.20), BLUE, "20 %"))
        if name == "paper":
            pairs = ((("rpm", 0.05), ORANGE, r"$Y_5$ at 5 %"), (("all", 0.20), BLUE, "all at 20 %"))
        for key, color, text in pairs:
            row[0].plot(t, r["cases"][key]["time"], color=color, lw=0.4, alpha=0.45)
            row[0].plot(smooth(t, n), smooth(r["cases"][key]["time"], n), color="white", lw=3.0)
            row[0].plot(smooth(t, n), smooth(r["cases"][key]["time"], n), color=color, lw=1.6, label=text)
            row[1].plot(f, r["cases"][key]["frequency"], color=color, lw=0.8, label=text)
        row[0].axhline(0.85, color=BLACK, lw=0.9, ls=(0, (4, 2)), label="0.85, the paper's")
        row[0].set(ylabel="dispersion", title=label, ylim=(0, 2), xlim=(0, t[-1]))
        row[1].set(xlim=(0, 5), ylim=(0, 4.3))
        if name in ("fc", "paper"):
            legend_above(row[1], ncol=2)
    legend_above(axes[0][0], ncol=1, handles=axes[0][0].get_lines()[-1:])
    axes[-1][0].set_xlabel(TIME_LABEL)
    axes[-1][1].set_xlabel(HZ_LABEL)
    return fig, "Dispersion (standard deviation over the mean) of the bit speed at each instant (left; thick: running mean over 5 s) and of its amplitude " \
                "spectrum at each frequency (right): one parameter random at a time, and the two cases of the paper's caption. Instants at which the mean " \
                f"itself is below {r['still']:g} rpm have no dispersion and are left out."


def region_figure(r, key):
    fig, axes = panels(2, 1, 5.0, sharex=True)
    case = r["cases"][key]
    for ax, quantity, label, title in ((axes[0], AXIAL, AXIAL_LABEL, "(a)"), (axes[1], SPEED, SPEED_LABEL, "(b)")):
        region(ax, r["t"], case["envelope"], quantity, r["nominal"][quantity])
        ax.set(ylabel=label, title=title, xlim=(0, r["t"][-1]))
    axes[1].axhline(r["nominal"][SPEED].max(), color=BLUE, lw=0.8, ls=(0, (4, 2)), label="nominal maximum")
    axes[1].set_xlabel(TIME_LABEL)
    legend_above(axes[1], ncol=4)
    return fig


def fig5(r):
    return region_figure(r, ("rpm", 0.05)), "Axial (a) and angular (b) speed of the bit, top speed random with 5 %: pointwise 2.5 and 97.5 % quantiles, mean, nominal case."


def fig6(r):
    return region_figure(r, ("all", 0.20)), "The same, all five parameters random with 20 %."


def fig7(r):
    fig, axes = panels(2, 1, 5.0, sharex=True, sharey=True)
    for ax, key, title in ((axes[0], ("rpm", 0.05), r"(a) $Y_5$ at 5 %"), (axes[1], ("all", 0.20), "(b) all five at 20 %")):
        a = r["cases"][key]["amplitude"]
        band = {f"a_{q}": np.quantile(a, p, axis=0) for q, p in (("q025", 0.025), ("q975", 0.975))}
        region(ax, r["f"], {**band, "a_mean": a.mean(axis=0)}, "a", r["nominal amplitude"])
        ax.set(yscale="log", ylabel="amplitude [rpm]", title=title, xlim=(0, 8), ylim=(5e-3, None))
    axes[1].set_xlabel(HZ_LABEL)
    legend_above(axes[0])
    return fig, "Amplitude spectrum of the bit speed (whole run, mean taken out, Hann window): quantiles and mean over the realisations at each frequency."


def fig8(r):
    fig, axes = panels(3, 2, 5.2, sharex=True, sharey=True)
    for column, (rock, title) in enumerate((("hard", r"(a) $\mu$ = 0.04"), ("soft", r"(b) $\mu$ = 0.004"))):
        for j, x in enumerate(r["three"][rock]):
            ss = r["severity"][rock][j]
            ax = axes[j][column]
            ax.plot(x["time_s"], x[SPEED], color=ORANGE if ss > r["limit"] else BLUE, lw=0.8)
            ax.set(title=f"{title}, realisation {j}: ss = {ss:.2f}, {'stick-slip' if ss > r['limit'] else 'none'}", xlim=(0, r["t"][-1]))
            if column == 0:
                ax.set_ylabel(SPEED_LABEL)
        axes[2][column].set_xlabel(TIME_LABEL)
    return fig, "The first three realisations of seed 1 for (a) the hard and (b) the soft rock, all five parameters at 20 %; the same draws of the other four " \
                "parameters on both sides. ss over the last half; orange: ss above the limit."


def fig9(r):
    fig, axes = panels(2, 1, 4.4, sharex=True)
    exact, t = r["cases"]["all", 0.20]["envelope"], r["t"]
    late = t >= 0.8 * t[-1]
    for q, color, label in (("q975", ORANGE, "97.5 %"), ("q500", BLUE, "median"), ("q025", GREEN, "2.5 %")):
        axes[0].plot(t[late], exact[f"{SPEED}_{q}"][late], color=color, lw=2.4, alpha=0.45, label=f"{label}, exact")
        axes[0].plot(t[late], r["streaming"][f"{SPEED}_{q}"][late], color=color, lw=0.9, label=f"{label}, fixed memory")
        axes[1].plot(t[late], (r["streaming"][f"{SPEED}_{q}"] - exact[f"{SPEED}_{q}"])[late], color=color, lw=0.8, label=label)
    axes[0].set(ylabel=SPEED_LABEL, title="(a)", xlim=(t[late][0], t[-1]))
    axes[1].set(ylabel="difference [rpm]", xlabel=TIME_LABEL, title="(b)")
    legend_above(axes[0], columnspacing=0.8)
    return fig, "Not in the paper: quantiles of the bit speed as a microcontroller estimates them in fixed memory, against the exact ones of the same " \
                f"{r['samples']} realisations, all at 20 %, last fifth of the run."


def all_figures(r, out):
    """Draw and write every figure; -> list of (file name without ending, caption)."""
    done = []
    for make in (fig1, fig2, fig3, fig4, fig5, fig6, fig7, fig8, fig9):
        fig, caption = make(r)
        name = make.__name__
        for kind, extra in (("png", {"metadata": {"Software": None}}), ("svg", {"metadata": {"Date": None, "Creator": None}})):
            path = os.path.join(out, f"{name}.{kind}")
            fig.savefig(path + ".part", format=kind, **extra)
            os.replace(path + ".part", path)
        plt.close(fig)
        done.append((name, caption))
    return done
