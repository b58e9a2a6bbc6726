"""figures_page.py - index.html: for every figure what the paper says, what kelly found, and how far apart they are.

Every number on the page is computed from the runs, but those in PAPER, which are the paper's own.
"""
import html
import os

import numpy as np

SPEED, AXIAL = "bit_speed_rpm", "bit_axial_speed_m_s"
PAPER = {"first axial": 1.41, "top": 1.67, "range": (0.0, 300.0), "realisations": 350.0, "converged": 400, "dispersion": 0.85,
         "hard": 1.0, "soft": 0.5}
NAMES = {"fc": "weight |f<sub>c</sub>|", "mu": "&mu;", "a1": "&alpha;<sub>1</sub>", "a2": "&alpha;<sub>2</sub>", "rpm": "top speed"}

STYLE = """body{font:16px/1.5 system-ui,sans-serif;max-width:62rem;margin:2rem auto;padding:0 1rem;color:#111;background:#fff}
h1{font-size:1.6rem}h2{font-size:1.2rem;margin-top:3rem}img{width:100%;height:auto}table{border-collapse:collapse;width:100%;margin:.5rem 0}
td,th{border-bottom:1px solid #ccc;padding:.35rem .6rem;text-align:left;vertical-align:top}th{background:#f2f2f2}td:nth-child(4){white-space:nowrap}
.differs{font-weight:600}.differs::before{content:"\\2260  "}.agrees::before{content:"=  "}.silent{color:#555}figcaption,.note{color:#333;font-size:.92rem}
code{background:#f2f2f2;padding:0 .2rem}pre{overflow-x:auto;background:#f2f2f2;padding:.6rem;font-size:.8rem}@media print{h2{page-break-before:always}}"""


def verdict(found, paper, within):
    """Whether a number is the paper's, within a share of it that the words of the paper allow."""
    away = (found - paper) / paper
    return ("agrees" if abs(away) <= within else "differs"), f"{100 * away:+.1f} %"


def row(says, value, found, kind="silent", text=""):
    return f'<tr><td>{says}</td><td>{value}</td><td>{found}</td><td class="{kind}">{kind if kind != "silent" else "no number in the paper"}' \
           f'{": " + text if text else ""}</td></tr>'


def compared(says, paper, found, within, form, unit="", value=None):
    kind, text = verdict(found, paper, within)
    return row(says, value or f"{paper:g}{unit}", f"{form.format(found)}{unit}", kind, text)


def yes(holds, says, value, found):
    return row(says, value, found, "agrees" if holds else "differs")


# ---- a list of rows and a note for each figure

def about_1(r):
    ten, one = r["peaks"]["axial 10"], r["peaks"]["axial 1"]
    first = r["modes"]["axial_prestressed_hz"][0]
    x, y = r["axial 10"][AXIAL], r["axial 1"][AXIAL]
    apart = np.sqrt(np.mean((x - y) ** 2)) / np.std(x)
    low, high = ([r["heights"][key][k] for key in ("axial 10", "axial 1")] for k in (0, 1))
    rows = [compared("lower peak, the first axial natural frequency", PAPER["first axial"], ten[0], 0.01, "{:.4f}", " Hz"),
            compared("upper peak, the top's rotation", PAPER["top"], ten[1], 0.01, "{:.4f}", " Hz"),
            row("one axial mode gives &ldquo;a good result&rdquo;", "", f"peaks with one mode at {one[0]:.4f} and {one[1]:.4f} Hz, "
                f"{100 * (low[1] / low[0] - 1):+.1f} % and {100 * (high[1] / high[0] - 1):+.1f} % in height; root mean square difference in time "
                f"{100 * apart:.1f} % of the signal's")]
    drift = half_mean(y)
    return rows, f"The table of natural frequencies has {first:.4f} Hz for the first axial mode; the paper's 1.41 is that number cut off, not rounded. &ldquo;1 axial " \
                 "mode&rdquo; is read as the text has it: one elastic mode together with the rigid one (<code>--axial 2</code>), and &ldquo;10&rdquo; as ten elastic ones " \
                 f"(<code>--axial 11</code>). The paper calls this speed the rate of penetration. At {drift:.2f} m/s in the mean of the last half, that is " \
                 f"{3600 * drift:.0f} m/h, it is a motion of the bit in this model and no drilling rate."


def half_mean(x):
    return float(np.nanmean(x[len(x) // 2:]))


def about_2(r):
    ten, one = r["axial 10"][SPEED], r["torsional 1"][SPEED]
    apart = np.sqrt(np.mean((ten - one) ** 2)) / np.std(ten)
    low, high = ten.min(), ten.max()
    still = np.mean(np.abs(ten[len(ten) // 2:]) < 5.0)
    rows = [compared("bit speed varies up to", PAPER["range"][1], high, 0.1, "{:.1f}", " rpm"),
            yes(abs(low) < 0.02 * PAPER["range"][1], "and down to", f"{PAPER['range'][0]:g} rpm", f"{low:.1f} rpm"),
            yes(still > 0, "the bit gets stuck at times", "&omega; = 0", f"{100 * still:.0f} % of the last half below 5 rpm"),
            yes(apart > 0.5, "one torsional mode is not sufficient", "&ldquo;clear&rdquo;",
                f"root mean square difference {100 * apart:.0f} % of the signal's; one mode stays within {one.min():.1f} and {one.max():.1f} rpm")]
    return rows, "A hyperbolic tangent holds the bit, not dry friction: a stuck bit creeps, and dips a little below zero."


def about_3(r):
    x = r["integrals"]
    value = np.cumsum(x) / np.arange(1, len(x) + 1)
    n = r["samples"]
    error = 1.96 * x.std() / x.mean() / np.sqrt(n)
    after = np.max(np.abs(value[n - 1:] / value[-1] - 1))
    rows = [yes(after < 0.02, "a reasonable convergence", f"{PAPER['converged']} samplings",
                f"conv({n}) = {value[n - 1]:.5g} m&sup2; s, {100 * (value[n - 1] / value[-1] - 1):+.2f} % from conv({len(x)}) = {value[-1]:.5g}; from {n} on never more "
                f"than {100 * after:.2f} % away; 1.96 standard errors at {n}: {100 * error:.2f} %")]
    return rows, "The paper does not define the norm or the zero of U; the values of its axis cannot be compared, the way in which it settles can."


def about_4(r):
    rows = []
    for level in (0.05, 0.20):
        for name, words in NAMES.items():
            found = half_mean(r["cases"][name, level]["time"])
            rows.append(compared(f"{words} alone at {100 * level:.0f} %: mean over time, last half", PAPER["dispersion"], found, 0.05, "{:.3f}"))
    rows.append(compared("all five at 20 %", PAPER["dispersion"], half_mean(r["cases"]["all", 0.20]["time"]), 0.05, "{:.3f}"))
    f = r["f"]
    inside = (f > 0.1) & (f < 5)
    means = {key: case["frequency"][inside].mean() for key, case in r["cases"].items()}
    low, high = min(means, key=means.get), max(means, key=means.get)
    rows.append(yes(means[high] > 1.5 * means[low], "in frequency &ldquo;quite different&rdquo;", "", "mean over 0.1 to 5 Hz from "
                    f"{means[low]:.2f} ({label(low)}) to {means[high]:.2f} ({label(high)})"))
    times = [half_mean(c["time"]) for c in r["cases"].values()]
    below = [100 * (1 - pick(times) / PAPER["dispersion"]) for pick in (max, min)]
    return rows, f"Here the dispersion averages {min(times):.2f} to {max(times):.2f}, {below[0]:.0f} to {below[1]:.0f} % below the paper's number; " \
                 "that it hardly depends on which parameter is random is confirmed. The paper gives neither the instants nor the start of its runs; with one " \
                 "parameter at 5 % the realisations fall out of step slowly and the dispersion still swings with the stick-slip period at the end of the run."


def label(key):
    return ("all five" if key[0] == "all" else NAMES[key[0]]) + f" at {100 * key[1]:.0f} %"


def about_region(r, key):
    s = r["cases"][key]["summary"]
    top = float(s["nominal"])
    words = f"kelly's nominal maximum, {top:.1f} rpm"
    return [compared("upper bound of the 95 % region &ldquo;close to the maximum response of the nominal model&rdquo;: its highest value", top, s["upper"], 0.1,
                     "{:.1f}", " rpm", words),
            compared("the same, mean of the last half", top, s["upper_late"], 0.1, "{:.1f}", " rpm", words),
            yes(s["outside"] == 0, "speeds of all realisations between", f"0 and {PAPER['realisations']:g} rpm",
                f"{s['lowest']:.1f} and {s['highest']:.1f} rpm; {100 * s['outside']:.3f} % of all values below -5 or above 350 rpm"),
            yes(s["slope"] > 0, "axial speed increases", "", f"{s['slope']:.5f} m/s&sup2; (mean), {s['nominal_slope']:.5f} (nominal)")]


def about_5(r):
    s = r["cases"]["rpm", 0.05]["summary"]
    return about_region(r, ("rpm", 0.05)), f"The upper bound overshoots while the realisations are still in step, and settles at {s['upper_late']:.0f} rpm once they are not: the " \
                                           "nominal run passes its maximum for an instant only, and the bound is what 2.5 % of the realisations exceed at one instant."


def about_6(r):
    small, large = (r["cases"][key]["summary"] for key in (("rpm", 0.05), ("all", 0.20)))
    rows = about_region(r, ("all", 0.20))
    rows.append(yes(large["width"] > small["width"] and large["axial_width"] > small["axial_width"], "more uncertain than in Figure 5", "",
                    f"mean width of the region, last half: {large['width']:.0f} against {small['width']:.0f} rpm, {large['axial_width']:.2f} against "
                    f"{small['axial_width']:.2f} m/s"))
    first = 60 * r["modes"]["axial_prestressed_hz"][0]
    return rows, f"The axial region reaches {large['axial_high']:.1f} m/s: a top speed drawn near {first:.0f} rpm excites the first axial mode in resonance. Where " \
                 "realisations leave 0 to 350 rpm, they are few: the tails of the gamma laws, and the torque law that lets the bit be thrown backwards."


def about_7(r):
    rows = []
    for key, words in ((("rpm", 0.05), "top speed at 5 %"), (("all", 0.20), "all five at 20 %")):
        case = r["cases"][key]
        mean = case["amplitude"].mean(axis=0)
        f = r["f"]
        top = f[np.argmax(np.where(f > 0.1, mean, 0))]
        rows.append(yes(case["bandwidth"] > 3 * top, f"a broad band spectrum ({words})", "", f"95 % of the power below {case['bandwidth']:.2f} Hz, the highest peak at "
                        f"{top:.2f} Hz (first torsional mode {r['modes']['torsion_prestressed_hz'][0]:.3f} Hz)"))
    return rows, "The peaks stand at the torsional modes; the paper gives no numbers for this figure."


def about_8(r):
    rows = []
    for rock, mu in (("hard", "0.04"), ("soft", "0.004")):
        for n in (r["samples"], r["many"]):
            p = r["P"][rock, n]
            lo, hi = p["ci95"]
            found = p["probability"]
            rows.append(yes(lo <= PAPER[rock] <= hi, f"probability of stick-slip, &mu; = {mu}", f"{100 * PAPER[rock]:g} %",
                            f"{100 * found:.2f} % of {p['samples'] - p['refused']} (95 % interval {100 * lo:.2f} to {100 * hi:.2f} %; refused {p['refused']})"))
    hard, soft = (r["severity"][rock] for rock in ("hard", "soft"))
    limit = r["limit"]
    rows.append(yes(all(s > limit for s in hard), "hard: stick-slip in all three", "", ", ".join(f"ss = {s:.3f}" for s in hard)))
    rows.append(yes(0 < sum(s > limit for s in soft) < 3, "soft: in some, not in others", "", ", ".join(f"ss = {s:.3f}" for s in soft)))
    return rows, f"ss = (max &minus; min)/(max + min) over the last half, stick-slip above {limit:g}. The realisations are the first three of the seed, not chosen."


def about_9(r):
    rows = [row(words, "&ndash;", f"root mean square {r['errors'][q][0]:.3g} rpm, largest {r['errors'][q][1]:.3g} rpm; sampling error of {r['samples']} realisations themselves "
                f"{r['errors'][q][2]:.3g} rpm") for q, words in (("mean", "mean"), ("sd", "standard deviation"), ("q025", "2.5 % quantile"), ("q500", "median"),
                                                                 ("q975", "97.5 % quantile"))]
    return rows, "Difference between the estimator of <code>firmware/envelope.h</code> and the exact statistics at all output times. The sampling error is the root mean " \
                 "square difference to an ensemble of another seed, over the square root of two."


ABOUT = {"fig1": about_1, "fig2": about_2, "fig3": about_3, "fig4": about_4, "fig5": about_5, "fig6": about_6, "fig7": about_7, "fig8": about_8, "fig9": about_9}


def section(r, name, caption):
    rows, note = ABOUT[name](r)
    title = f"Figure {name[3:]}" if name != "fig9" else "Quantiles in fixed memory"
    return f'<section id="{name}"><h2>{title}</h2>\n<figure><a href="{name}.svg"><img src="{name}.png" alt="{html.escape(caption)}"></a>' \
           f'<figcaption>{html.escape(caption)} (<a href="{name}.svg">SVG</a>, <a href="{name}.png">PNG</a>)</figcaption></figure>\n' \
           '<table><tr><th>the paper</th><th>its number</th><th>kelly</th><th>comparison</th></tr>\n' + "\n".join(rows) + f'</table>\n<p class="note">{note}</p></section>'


def write(r, path, pictures, commands):
    p = r["P"]["hard", r["samples"]]
    used = min(c["used"] for c in r["cases"].values())
    case = p["case"]
    shown = [c for c in commands if "--convergence" not in c] + [next(c for c in commands if "--convergence" in c) + "   # and so on, two by two"]
    text = f"""<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>kelly: Figures 1-8</title>
<style>{STYLE}</style></head><body><h1>The paper's Figures 1 to 8, from kelly's own runs</h1>
<p>Stochastic drill-string dynamics with uncertainty on the imposed speed and on the bit-rock parameters: what the paper says of each figure, and what was found here.
Table {p["model"]}, {p["real"]}, seed {p["seed"]}, {r["samples"]} realisations of {case["duration_s"]:g} s at a step of {case["step_s"]:g} s (at least {used} of them counted in every
ensemble), string at rest at t = 0. Choices the paper leaves open: start, duration and window; regions are pointwise 2.5 and 97.5 % quantiles (numpy's linear), standard deviations
have the divisor n, &ldquo;the last half&rdquo; is the window of the severity. <span class="agrees">agrees</span> means within what the paper's words allow: 1 % for a frequency, 10 % for
the range of the bit speed and for &ldquo;close to&rdquo;, 5 % for &ldquo;about 0.85&rdquo;, within the 95 % interval for a probability. The percentage is kelly less the paper.</p>
{chr(10).join(section(r, name, caption) for name, caption in pictures)}
<h2>Runs</h2><p>Every number above is computed from these, in <code>runs/</code>.</p><pre>{html.escape(chr(10).join(shown))}</pre></body></html>
"""
    with open(path + ".part", "w", encoding="utf-8") as out:
        out.write(text)
    os.replace(path + ".part", path)
